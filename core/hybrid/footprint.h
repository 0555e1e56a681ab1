// Which pixels of a tile a leaf can cover, and how near it can be there: a conservative raster pass over
// proven parallelepipeds.
#pragma once

#include <cstdint>

#include "core/hybrid/camera_frame.h"
#include "core/trace/patch.h"

namespace trimray::hybrid {

inline constexpr int kMaxTile = 64;  // px along a side
inline constexpr float kFarDepth = 1e30f;

// An affine function of the place relative to the tile's middle, px.
struct Affine {
  float at = 0.0f, dx = 0.0f, dy = 0.0f;
};

// A hull seen in a tile. A line o + s d meets a parallelepiped (center, a, b, k) only where none of the axes
// d x a, d x b, d x k separates them; with g = (center - o) x d,
//   |g.b| <= |ab.d| + |bk.d|,  |g.a| <= |ab.d| + |ak.d|,  |g.k| <= |ak.d| + |bk.d|,
// and no nearer than where it meets the plane center - k sign + span(a, b). All of these are affine in the
// place, whichever of o and d depends on it. Depths are relative to a reference depth, mm.
struct Footprint {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;                    // pixels of the tile that can matter; empty: none
  float near = 0.0f;                                     // no point of the hull is nearer
  bool affine_denominator = false;                       // perspective
  Affine u, v, k;                                        // orthographic: divided by their limits
  float limit_u = 0.0f, limit_v = 0.0f, limit_k = 0.0f;  // with the slack for rounding
  Affine depth;                                          // orthographic: the nearest depth at the place
  Affine ab, ak, bk, numerator;                          // perspective
  float slack_u = 0.0f, slack_v = 0.0f, slack_k = 0.0f, slack_depth = 0.0f, slack_ab = 0.0f;
};

// hull: in the camera frame. rect: the tile, its middle the origin of the affine functions; width and height
// px. reference: the depth that others are relative to.
Footprint make_footprint(const trace::LeafHull& hull, bool perspective, const FrameRect& rect, int width,
                         int height, double reference);

// Sets rows[y] for y in [y0, y1): bit x where the hull can cover the place of pixel (x, y) at a depth up to
// best[y * kMaxTile + x]. place: of the sample in its pixel, relative to the middle of the pixel.
void cover(const Footprint& footprint, const float* best, float place_x, float place_y, int width, int height,
           std::uint64_t* rows);

}  // namespace trimray::hybrid
