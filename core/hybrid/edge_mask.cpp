#include "core/hybrid/edge_mask.h"

#include <algorithm>
#include <cmath>

#include "core/hybrid/tile_walk.h"

namespace trimray::hybrid {
namespace {

// A thick line in the picture, px from its middle.
struct Band {
  dvec2 a{0.0}, b{0.0};
  double radius = 0.0;
};

// What can be seen of a capsule whose ends are in the camera frame; false: nothing within the picture.
// everywhere: it passes so near to the eye's plane that no bound can be given.
bool project(dvec3 a, dvec3 b, double across, double along, bool perspective, const FrameRect& rect,
             Band& band, bool& everywhere) {
  everywhere = false;
  if (!perspective) {
    band = {dvec2(a), dvec2(b), across};
    return true;
  }
  const double widest =
      1.0 + std::max({std::abs(rect.x0), std::abs(rect.x1), std::abs(rect.y0), std::abs(rect.y1)});
  const double least = 4.0 * along + 1e-12 * (std::abs(a.z) + std::abs(b.z));
  if (a.z > b.z) std::swap(a, b);
  if (!(b.z > -along)) return false;
  if (!(a.z > least)) {
    // The part before `least` is off the picture, or all is lost.
    const auto at = [&](double z) { return b.z > a.z ? a + (z - a.z) / (b.z - a.z) * (b - a) : a; };
    const dvec3 p = at(std::max(a.z, -along)), q = b.z > least ? at(least) : b;
    const double limit = 2.0 * widest * least + across;
    const auto beyond = [&](double u, double v) { return std::min(u, v) > limit || std::max(u, v) < -limit; };
    if (!beyond(p.x, q.x) && !beyond(p.y, q.y)) {
      everywhere = true;
      return true;
    }
    if (!(b.z > least)) return false;
    a = q;
  }
  // A point P within the radius of a ray's point Q: |Q/Qz - P/Pz| <= (|Q - P| + |P/Pz| |Qz - Pz|) / Qz.
  band = {dvec2(a) / a.z, dvec2(b) / b.z, (across + 2.0 * widest * along) / (a.z - along)};
  return true;
}

class Marker {
 public:
  Marker(const trace::Tile& tile, const FrameRect& rect, TileState& state)
      : tile_(tile), rect_(rect), state_(state) {}

  void all(float nearest) {
    for (std::size_t p = 0; p < tile_.places.size(); ++p)
      for (int y = 0; y < height(); ++y)
        for (int x = 0; x < tile_.width(); ++x) mark(p, x, y, nearest);
  }

  void band(const Band& band, float nearest) {
    const dvec2 e = glm::abs(band.b - band.a);
    const bool steep = e.y >= e.x;  // rows are the cheaper way
    const int along = steep ? 1 : 0, across = 1 - along;
    const double length = glm::length(e);
    const double slope =
        length > 0.0 ? (band.b[across] - band.a[across]) / (band.b[along] - band.a[along]) : 0.0;
    // Half the width across, at most sqrt 2 times the radius; coordinates are exact to some 1e-13.
    const double half = (length > 0.0 ? band.radius * length / e[along] : band.radius) + 1e-9;
    const double reach = band.radius + 1e-9;
    const dvec2 origin(rect_.x0, rect_.y0);
    const int counts[2] = {tile_.width(), height()};
    for (std::size_t p = 0; p < tile_.places.size(); ++p) {
      const dvec2 first = origin + tile_.places[p];  // of pixel 0
      const int begin = first_at(std::min(band.a[along], band.b[along]) - reach - first[along]);
      const int end =
          std::min(counts[along], 1 + last_at(std::max(band.a[along], band.b[along]) + reach - first[along]));
      for (int i = begin; i < end; ++i) {
        const double middle = band.a[across] + (first[along] + i - band.a[along]) * slope - first[across];
        const int from = first_at(middle - half), to = std::min(counts[across] - 1, last_at(middle + half));
        for (int j = from; j <= to; ++j) steep ? mark(p, j, i, nearest) : mark(p, i, j, nearest);
      }
    }
  }

 private:
  int height() const { return tile_.y1 - tile_.y0; }
  // The least integer >= x and the greatest <= x, kept within what pixels need. (std::ceil is a call.)
  static int first_at(double x) {
    if (!(x > 0.0)) return 0;
    const int i = static_cast<int>(std::min(x, 1e6));
    return i + (i < x);
  }
  static int last_at(double x) { return x >= 0.0 ? static_cast<int>(std::min(x, 1e6)) : -1; }

  void mark(std::size_t p, int x, int y, float nearest) {
    const std::size_t slot = p * kTileSlots + static_cast<std::size_t>(y) * kMaxTile + x;
    if (nearest <= state_.best[slot]) TileState::set(state_.near_edge, static_cast<std::int32_t>(slot));
  }

  const trace::Tile& tile_;
  const FrameRect& rect_;
  TileState& state_;
};

}  // namespace

void mark_edges(const InstanceView& view, const trace::Tile& tile, const FrameRect& rect, double reference,
                double reach, float far, TileState& state) {
  const trace::EdgeSieve& sieve = view.edges();
  const trace::Bvh& bvh = sieve.bvh();
  const CameraFrame frame = view.frame.about(bvh.center);
  Marker marker(tile, rect, state);
  const float behind = static_cast<float>(reach * 1.000001);
  walk_tile(
      bvh, TileSpace(view.frame, bvh, rect, reference), [&] { return far + behind; },
      [&](std::int32_t index, float near) {
        const trace::Capsule& c = sieve.capsules()[index];
        const dvec3 a = frame.point({c.a[0], c.a[1], c.a[2]}), b = frame.point({c.b[0], c.b[1], c.b[2]});
        const double across = c.radius * view.stretch_across, along = c.radius * view.stretch_along;
        Band band;
        bool everywhere;
        if (!project(a, b, across, along, frame.perspective, rect, band, everywhere)) return;
        const float nearest = near - behind;
        if (everywhere)
          marker.all(nearest);
        else
          marker.band(band, nearest);
      });
}

}  // namespace trimray::hybrid
