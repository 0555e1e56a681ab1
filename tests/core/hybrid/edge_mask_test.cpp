// The mask of rays near an edge against every ray and every capsule, in double.
#include "core/hybrid/edge_mask.h"

#include <gtest/gtest.h>

#include "core/view/sampling.h"
#include "tests/core/hybrid/tile_rays.h"

namespace trimray::hybrid {
namespace {

using testing::Random;
using testing::random_tile;
using testing::TileView;

struct Approach {
  double distance = kInf, s = 0.0;  // of the line; at the depth s
};

// Where the line o + s d (d of any length) comes closest to the segment.
Approach closest(const dvec3& o, const dvec3& d, const dvec3& a, const dvec3& b) {
  const dvec3 e = b - a, w = a - o;
  const double dd = glm::dot(d, d), ee = glm::dot(e, e), de = glm::dot(d, e);
  const double det = dd * ee - de * de;
  double x = det > 1e-14 * dd * ee ? (glm::dot(w, d) * de - glm::dot(w, e) * dd) / det : 0.0;
  x = std::clamp(x, 0.0, 1.0);
  const double s = glm::dot(a + x * e - o, d) / dd;
  return {glm::length(a + x * e - o - s * d), s};
}

double to_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 e = b - a;
  const double ee = glm::dot(e, e);
  const double x = ee > 0.0 ? std::clamp(glm::dot(p - a, e) / ee, 0.0, 1.0) : 0.0;
  return glm::length(a + x * e - p);
}

// A solid whose bands are so wide that rays meet them often; instances of all
// kinds.
std::vector<nurbs::NurbsStore> stores() {
  std::mt19937_64 rng(9);
  std::vector<nurbs::NurbsStore> all;
  for (const double noise : {0.0, 1e-3, 0.03}) {
    all.push_back(trace::box_solid({-2, -1, 0}, {2, 1, 3}, noise, rng));
    all.push_back(trace::capped_cylinder(2.0, 3.0, noise));
  }
  return all;
}

TEST(EdgeMask, HoldsEveryRayThatPassesAnEdge) {
  Random random(1);
  long rays = 0, near = 0, marked = 0, wide = 0, behind = 0, around_eye = 0;
  const std::vector<nurbs::NurbsStore> models = stores();
  for (int i = 0; i < 350; ++i) {
    TileView tile_view = random_tile(random, 0.0, 1.0);
    nurbs::NurbsStore store = models[i % models.size()];
    tile_view.placement.translation = random.log_between(0.1, 100.0) * random.direction();
    store.instances[0].placement = tile_view.placement;
    // Look at an edge, from outside, from next to it, or along it.
    const nurbs::Edge& edge = store.edges[random.below(store.edges.size())];
    const nurbs::Range& r = store.edge_pieces[edge.pieces.begin].ctrl;
    const dvec4 h0 = store.edge_ctrl_h[r.begin], h1 = store.edge_ctrl_h[r.end - 1];
    const dvec3 a = tile_view.placement.point(dvec3(h0) / h0.w),
                b = tile_view.placement.point(dvec3(h1) / h1.w);
    const dvec3 target = a + random.between(-0.1, 1.1) * (b - a);
    view::Camera& camera = tile_view.camera;
    const double size = 8.0;
    tile_view.depth = random.chance(0.3) ? random.log_between(1e-3, 1.0) : size * random.between(1.0, 3.0);
    camera.pixel = random.log_between(1e-4, 0.1);
    if (camera.perspective && random.chance(0.5)) camera.pixel /= tile_view.depth;
    if (glm::length(b - a) > 0.1 && random.chance(0.3)) {
      camera.forward = glm::normalize(b - a + 1e-3 * random.direction());
      camera.right = glm::normalize(glm::cross(camera.forward, random.direction()));
      camera.up = glm::cross(camera.right, camera.forward);
    }
    // Also a few bands beyond it.
    camera.eye = random.chance(0.3) ? target + random.between(0.0, 5.0) * edge.band * camera.forward
                                    : target - tile_view.depth * camera.forward;
    camera.width_px = 96, camera.height_px = 80;
    trace::Tile tile;
    tile.x0 = static_cast<int>(random.below(64)), tile.y0 = static_cast<int>(random.below(48));
    tile.x1 = std::min(camera.width_px, tile.x0 + 1 + static_cast<int>(random.below(kMaxTile)));
    tile.y1 = std::min(camera.height_px, tile.y0 + 1 + static_cast<int>(random.below(kMaxTile)));
    const std::vector<dvec2> places = view::sample_pattern(random.chance(0.5) ? 1 : 3);
    tile.places = places;
    const dvec2 middle(0.5 * camera.width_px, 0.5 * camera.height_px);
    const FrameRect rect{tile.x0 - middle.x, tile.y0 - middle.y, tile.x1 - middle.x, tile.y1 - middle.y};

    const trace::Scene scene(std::make_shared<nurbs::NurbsStore>(store), 1);
    const InstanceView view(scene.impl(), camera, 0);
    const double reference = random.chance(0.3) ? 0.0 : tile_view.depth * random.between(-2.0, 3.0);
    const double reach = random.chance(0.3) ? 0.0 : random.log_between(1e-4, 10.0);
    TileState state;
    state.reset(tile);
    const trace::EdgeSieve& sieve = view.edges();
    const dvec3 center = sieve.bvh().center;
    const dmat3 back = glm::inverse(view.frame.linear);
    // What each ray passes, and whether it comes anywhere near.
    struct Passes {
      std::int32_t slot;
      std::vector<double> depths;  // of edges in reach, none before the eye
      bool wide = false;
    };
    std::vector<Passes> all;
    float far = -kFarDepth;
    for (std::size_t p = 0; p < places.size(); ++p)
      for (int y = 0; y < tile.y1 - tile.y0; ++y)
        for (int x = 0; x < tile.width(); ++x) {
          Passes& ray =
              all.emplace_back(Passes{static_cast<std::int32_t>(p * kTileSlots) + y * kMaxTile + x, {}});
          const dvec2 at = dvec2(rect.x0 + x, rect.y0 + y) + places[p];
          const dvec3 o =
              back * ((camera.perspective ? dvec3(0.0) : dvec3(at, 0.0)) - view.frame.shift) - center;
          const dvec3 d = back * (camera.perspective ? dvec3(at, 1.0) : dvec3(0, 0, 1));
          for (const trace::Capsule& c : sieve.capsules()) {
            const dvec3 ca(c.a[0], c.a[1], c.a[2]), cb(c.b[0], c.b[1], c.b[2]);
            const Approach line = closest(o, d, ca, cb);
            ray.wide |= line.distance <= 12.0 * c.radius + 1e-6 * view.prototype->diagonal *
                                                               std::max(1.0, 1.0 / tile_view.depth);
            if (line.distance > c.radius) continue;
            const bool eye = to_segment(o, ca, cb) <= c.radius;
            around_eye += eye;
            // The standard tracer asks for edges from a little before the ray's start.
            const bool within = line.s * glm::length(d) >= -sieve.max_slack();
            if (within || eye) ray.depths.push_back(std::max(line.s, 0.0));
          }
          float& best = state.best[ray.slot];
          if (i % 2 && random.chance(0.5))
            best = static_cast<float>(tile_view.depth - reference + random.between(-1.0, 1.0) * size / 4);
          else if (i % 2 && !ray.depths.empty())  // as near as it may be
            best = std::nextafter(
                static_cast<float>(ray.depths[random.below(ray.depths.size())] - reference - reach),
                kFarDepth);
          far = std::max(far, best);
        }
    mark_edges(view, tile, rect, reference, reach, far, state);

    for (const Passes& ray : all) {
      const double last = static_cast<double>(state.best[ray.slot]) + reference + reach;
      const auto before =
          std::count_if(ray.depths.begin(), ray.depths.end(), [&](double s) { return s <= last; });
      const bool set = TileState::has(state.near_edge, ray.slot);
      ++rays, near += before > 0, marked += set, wide += ray.wide;
      behind += static_cast<long>(ray.depths.size()) - before;
      ASSERT_TRUE(set || before == 0)
          << i << (camera.perspective ? " perspective" : " orthographic") << " slot " << ray.slot << " best "
          << state.best[ray.slot] << " depth " << tile_view.depth;
    }
  }
  EXPECT_GT(near, 50000);
  EXPECT_GT(behind, 20000);
  EXPECT_GT(around_eye, 20000);
  EXPECT_LT(marked, rays / 2);
  EXPECT_LT(marked, wide + rays / 20);
}

}  // namespace
}  // namespace trimray::hybrid
