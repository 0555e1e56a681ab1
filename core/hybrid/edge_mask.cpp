#include "core/hybrid/edge_mask.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/hybrid/tile_walk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/hybrid/edge_mask.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/base/simd_floats-inl.h"

// Thick lines in a tile, px from its middle.
#ifndef TRIMRAY_HYBRID_BANDS_
#define TRIMRAY_HYBRID_BANDS_
namespace trimray::hybrid {
struct Bands {
  alignas(64) float ax[kBatch], ay[kBatch], bx[kBatch], by[kBatch], radius[kBatch];
};
// Which capsules of a batch can cover some place, and which come too near to the plane of the eye to be
// projected.
struct BandMasks {
  std::uint32_t seen = 0, near_eye = 0;
};
}  // namespace trimray::hybrid
#endif

HWY_BEFORE_NAMESPACE();
namespace trimray::hybrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using trimray::HWY_NAMESPACE::bits_of;
using trimray::HWY_NAMESPACE::Float;
using trimray::HWY_NAMESPACE::Floats;
using trimray::HWY_NAMESPACE::set;

// Is some place first + i, i in [0, count), within [low, high]?
HWY_INLINE auto holds_place(Float low, Float high, float first, int count) {
  const Float next = hn::Max(hn::Ceil(hn::Sub(low, set(first))), set(0.0f));
  return hn::And(hn::Le(next, hn::Sub(high, set(first))), hn::Le(next, set(static_cast<float>(count - 1))));
}

void ProjectKernel(const TileFrame& frame, float across, float along, const float* capsules,
                   const std::int32_t* index, int count, const trace::Tile& tile, Bands& out,
                   BandMasks& masks) {
  const Floats d;
  const hn::Rebind<std::int32_t, Floats> di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int width = tile.width(), height = tile.y1 - tile.y0;
  masks = {};
  for (int i = 0; i < count; i += lanes) {
    const auto at = hn::LoadU(di, index + i);
    Float end[2][3];
    for (int e = 0; e < 2; ++e) {
      const Float x = hn::GatherIndex(d, capsules + 3 * e, at),
                  y = hn::GatherIndex(d, capsules + 3 * e + 1, at),
                  z = hn::GatherIndex(d, capsules + 3 * e + 2, at);
      for (int r = 0; r < 3; ++r)
        end[e][r] = hn::MulAdd(set(frame.linear[r][0]), x,
                               hn::MulAdd(set(frame.linear[r][1]), y,
                                          hn::MulAdd(set(frame.linear[r][2]), z, set(frame.shift[r]))));
    }
    const Float size = hn::GatherIndex(d, capsules + 6, at);
    // Rounding of what follows, in px, with a margin.
    const Float rounding = set(1e-4f);
    Float radius = hn::MulAdd(size, set(across), set(frame.error[0] + frame.error[1]));
    auto near_eye = hn::Lt(radius, radius);  // none
    if (frame.perspective) {
      // A point P within the radius of a ray's point Q: |Q/Qz - P/Pz| <= (|Q - P| + |P/Pz| |Qz - Pz|) / Qz,
      // where P/Pz is no farther from the middle than twice what the tile is.
      const Float depth = hn::MulAdd(size, set(along), set(frame.error[2]));
      const Float nearest = hn::Min(end[0][2], end[1][2]), farthest = hn::Max(end[0][2], end[1][2]);
      near_eye = hn::Le(nearest, hn::MulAdd(set(4.0f), depth, hn::Mul(set(1e-4f), hn::Abs(farthest))));
      const Float safe = hn::IfThenElse(near_eye, set(1.0f), nearest);
      radius = hn::Div(hn::MulAdd(set(2.0f * frame.half + 2.0f), depth, radius),
                       hn::Sub(safe, hn::Mul(depth, set(1.0f))));
      for (auto& e : end) {
        const Float inverse = hn::Div(set(1.0f), hn::IfThenElse(near_eye, set(1.0f), e[2]));
        e[0] = hn::Mul(e[0], inverse), e[1] = hn::Mul(e[1], inverse);
      }
      // Ends far outside are exact to a part of their own distance only.
      const Float far = hn::Max(hn::Max(hn::Abs(end[0][0]), hn::Abs(end[1][0])),
                                hn::Max(hn::Abs(end[0][1]), hn::Abs(end[1][1])));
      radius = hn::MulAdd(far, set(4e-6f), radius);
    }
    radius = hn::Add(radius, rounding);
    const auto seen = [&](float x, float y) HWY_ATTR {
      const auto across_x = holds_place(hn::Sub(hn::Min(end[0][0], end[1][0]), radius),
                                        hn::Add(hn::Max(end[0][0], end[1][0]), radius), x, width);
      const auto across_y = holds_place(hn::Sub(hn::Min(end[0][1], end[1][1]), radius),
                                        hn::Add(hn::Max(end[0][1], end[1][1]), radius), y, height);
      return hn::And(across_x, across_y);
    };
    std::uint32_t any = 0;
    for (const dvec2& place : tile.places)
      any |= bits_of(
          seen(static_cast<float>(place.x - 0.5 * width), static_cast<float>(place.y - 0.5 * height)));
    const std::uint32_t wanted = (count - i < lanes ? (std::uint32_t{1} << (count - i)) - 1u : ~0u);
    const std::uint32_t lost = static_cast<std::uint32_t>(bits_of(near_eye)) & wanted;
    masks.near_eye |= lost << i, masks.seen |= (any & wanted & ~lost) << i;
    hn::Store(end[0][0], d, out.ax + i), hn::Store(end[0][1], d, out.ay + i);
    hn::Store(end[1][0], d, out.bx + i), hn::Store(end[1][1], d, out.by + i);
    hn::Store(radius, d, out.radius + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trimray::hybrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray::hybrid {

HWY_EXPORT(ProjectKernel);

namespace {

class Marker {
 public:
  Marker(const trace::Tile& tile, TileState& state) : tile_(tile), state_(state) {}

  void all(float nearest) {
    for (std::size_t p = 0; p < tile_.places.size(); ++p)
      for (int y = 0; y < height(); ++y)
        for (int x = 0; x < tile_.width(); ++x) mark(p, x, y, nearest);
  }

  // The places within the radius of the segment: row by row, or column by column where that is fewer.
  void band(const Bands& bands, int i, float nearest) {
    const float a[2] = {bands.ax[i], bands.ay[i]}, b[2] = {bands.bx[i], bands.by[i]},
                radius = bands.radius[i];
    const float ex = std::abs(b[0] - a[0]), ey = std::abs(b[1] - a[1]);
    const int along = ey >= ex ? 1 : 0, across = 1 - along;
    const float run = along == 1 ? ey : ex;
    const float slope = run > 0.0f ? (b[across] - a[across]) / (b[along] - a[along]) : 0.0f;
    // At most sqrt 2 times the radius; slopes are at most 1, so rounding stays what it was.
    const float half = radius * std::sqrt(1.0f + slope * slope) * 1.00001f;
    const int counts[2] = {tile_.width(), height()};
    for (std::size_t p = 0; p < tile_.places.size(); ++p) {
      const float first[2] = {static_cast<float>(tile_.places[p].x - 0.5 * counts[0]),
                              static_cast<float>(tile_.places[p].y - 0.5 * counts[1])};
      const int begin = first_at(std::min(a[along], b[along]) - radius - first[along]);
      const int end =
          std::min(counts[along], 1 + last_at(std::max(a[along], b[along]) + radius - first[along]));
      for (int k = begin; k < end; ++k) {
        const float middle =
            a[across] + (first[along] + static_cast<float>(k) - a[along]) * slope - first[across];
        const int from = first_at(middle - half), to = std::min(counts[across] - 1, last_at(middle + half));
        for (int j = from; j <= to; ++j) along == 1 ? mark(p, j, k, nearest) : mark(p, k, j, nearest);
      }
    }
  }

 private:
  int height() const { return tile_.y1 - tile_.y0; }
  // The least integer >= x and the greatest <= x, kept within what pixels need. (std::ceil is a call.)
  static int first_at(float x) {
    if (!(x > 0.0f)) return 0;
    const int i = static_cast<int>(std::min(x, 1e6f));
    return i + (static_cast<float>(i) < x);
  }
  static int last_at(float x) { return x >= 0.0f ? static_cast<int>(std::min(x, 1e6f)) : -1; }

  void mark(std::size_t p, int x, int y, float nearest) {
    const std::size_t slot = p * kTileSlots + static_cast<std::size_t>(y) * kMaxTile + x;
    if (nearest <= state_.best[slot]) TileState::set(state_.near_edge, static_cast<std::int32_t>(slot));
  }

  const trace::Tile& tile_;
  TileState& state_;
};

}  // namespace

void mark_edges(const InstanceView& view, const trace::Tile& tile, const FrameRect& rect, double reference,
                double reach, float far, TileState& state) {
  const trace::EdgeSieve& sieve = view.edges();
  const trace::Bvh& bvh = sieve.bvh();
  if (bvh.nodes.empty()) return;
  const TileFrame frame(view.frame, bvh.center, bvh.radius, rect, reference);
  const auto length = [&](int r) {
    const float* m = frame.linear[r];
    return m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
  };
  const float across = std::sqrt(length(0) + length(1)) * 1.00001f, along = std::sqrt(length(2)) * 1.00001f;
  constexpr int kFloats = sizeof(trace::Capsule) / sizeof(float);
  static_assert(kFloats == 7);
  Marker marker(tile, state);
  const float behind = static_cast<float>(reach * 1.000001);
  alignas(64) std::int32_t index[kBatch] = {};
  float near[kBatch];
  int count = 0;
  const auto draw = [&] {
    Bands bands;
    BandMasks masks;
    HWY_DYNAMIC_DISPATCH(ProjectKernel)
    (frame, across, along, sieve.capsules().front().a, index, count, tile, bands, masks);
    for (std::uint32_t rest = masks.seen; rest != 0; rest &= rest - 1)
      marker.band(bands, std::countr_zero(rest), near[std::countr_zero(rest)] - behind);
    // Near the plane of the eye all places of the tile that the box of the capsule meets may be meant.
    for (std::uint32_t rest = masks.near_eye; rest != 0; rest &= rest - 1)
      marker.all(near[std::countr_zero(rest)] - behind);
    count = 0;
  };
  walk_tile(
      bvh, TileSpace(view.frame, bvh, rect, reference), [&] { return far + behind; },
      [&](std::int32_t capsule, float nearest) {
        index[count] = kFloats * capsule, near[count] = nearest;
        if (++count == kBatch) draw();
      });
  if (count > 0) draw();
}

}  // namespace trimray::hybrid
#endif
