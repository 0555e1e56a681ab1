// Which pixels of a tile a leaf can cover, and how near it can be there: a conservative raster pass over
// proven parallelepipeds.
#pragma once

#include <cstdint>
#include <span>

#include "core/hybrid/camera_frame.h"
#include "core/trace/leaf_hull.h"

namespace trimray::hybrid {

inline constexpr int kMaxTile = 64;  // px along a side
inline constexpr int kBatch = 16;    // leaves that are set up at once
inline constexpr float kFarDepth = 1e30f;

// The camera frame of an instance about the middle of one tile, in float, for coordinates relative to the
// centre of the prototype's Bvh: x and y count from the tile's middle (perspective: from the ray through it),
// depths from the view's reference where they are compared.
struct TileFrame {
  float linear[3][3], shift[3];  // rows x, y, z
  float error[3];                // what rounding can move a point of the prototype by
  float reference = 0.0f;
  float half = 0.0f;  // px: no place of the tile is farther from its middle in x or y
  bool perspective = false;

  TileFrame(const CameraFrame& frame, const dvec3& center, double radius, const FrameRect& rect,
            double reference);
};

// An affine function of the place relative to the tile's middle, px; a value a leaf.
struct AffineBatch {
  alignas(64) float at[kBatch], dx[kBatch], dy[kBatch];
};

// Hulls seen in a tile. A line o + s d meets a parallelepiped (center, a, b, k) only where none of the axes
// d x a, d x b, d x k separates them; with g = (center - o) x d,
//   |g.b| <= |ab.d| + |bk.d|,  |g.a| <= |ab.d| + |ak.d|,  |g.k| <= |ak.d| + |bk.d|,
// and no nearer than where it meets the plane center - k sign + span(a, b). All of these are affine in the
// place, whichever of o and d depends on it.
struct Footprints {
  alignas(64) std::int32_t x0[kBatch], y0[kBatch], x1[kBatch], y1[kBatch];  // pixels that can matter
  alignas(64) float near[kBatch];  // no point of the hull is nearer, relative to the reference depth
  // Plain: |u|, |v|, |k| are below limits, and depth is the nearest depth at the place. Otherwise the limits
  // are functions of the place, and depth is the numerator of the nearest depth over ab.
  AffineBatch u, v, k, depth, ab, ak, bk;
  // Plain: the limits, with the slack for rounding; otherwise the slack alone.
  alignas(64) float limit_u[kBatch], limit_v[kBatch], limit_k[kBatch], slack_depth[kBatch], slack_ab[kBatch];
  std::uint32_t plain = 0;  // a bit a leaf
};

// hulls: all of the prototype; leaves: at most kBatch of them. width, height: of the tile, px.
void make_footprints(const TileFrame& frame, std::span<const trace::LeafHull> hulls,
                     std::span<const std::int32_t> leaves, int width, int height, Footprints& out);

// Sets rows[y] for y in [y0, y1) of leaf number i: bit x where the hull can cover the place of pixel (x, y)
// at a depth up to best[y * kMaxTile + x]. place: of the sample, relative to the middle of its pixel. False:
// none.
bool cover(const Footprints& footprints, int i, const float* best, float place_x, float place_y, int width,
           int height, std::uint64_t* rows);

}  // namespace trimray::hybrid
