// Footprints against the slabs of the hulls themselves, ray by ray: none is
// missed, and few are given for nothing.
#include "core/hybrid/footprint.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "tests/core/hybrid/tile_rays.h"

namespace trimray::hybrid {
namespace {

using testing::Random;
using testing::random_tile;
using testing::TileView;
using trace::LeafHull;
using Real = long double;
using RealVec = glm::tvec3<Real>;

RealVec real(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
dvec3 vec(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
void put(float (&to)[3], const dvec3& v) {
  for (int a = 0; a < 3; ++a) to[a] = static_cast<float>(v[a]);
}

// Depths at which a tile's rays are in a hull, by its three slabs.
struct Slabs {
  RealVec across[3];  // across[i] . (p - center): the hull's own coordinate of a
                      // point of the frame
  RealVec center;
  bool perspective;

  Slabs(const TileView& view, const dvec3& bvh_center, const LeafHull& hull) {
    perspective = view.frame.perspective;
    glm::tmat3x3<Real> linear;
    RealVec shift(view.frame.shift);
    for (int a = 0; a < 3; ++a) {
      linear[a] = RealVec(view.frame.linear[a]);
      shift += linear[a] * static_cast<Real>(bvh_center[a]);
    }
    center = linear * real(hull.center) + shift;
    const RealVec e[3] = {linear * real(hull.a), linear * real(hull.b), linear * real(hull.k)};
    const Real volume = glm::dot(glm::cross(e[0], e[1]), e[2]);
    for (int i = 0; i < 3; ++i) across[i] = glm::cross(e[(i + 1) % 3], e[(i + 2) % 3]) / volume;
  }

  // True and [near, far] where the ray through a place meets the hull in front
  // of the eye.
  bool meets(const dvec2& at, Real& near, Real& far) const {
    const RealVec o = perspective ? RealVec(0) : RealVec(at.x, at.y, 0);
    const RealVec d = perspective ? RealVec(at.x, at.y, 1) : RealVec(0, 0, 1);
    near = 0, far = std::numeric_limits<Real>::infinity();
    for (const RealVec& n : across) {
      const Real p = glm::dot(n, o - center), q = glm::dot(n, d);
      if (q == 0) {
        if (std::abs(p) > 1) return false;
        continue;
      }
      const Real s = (-1 - p) / q, t = (1 - p) / q;
      near = std::max(near, std::min(s, t)), far = std::min(far, std::max(s, t));
    }
    return near <= far;
  }
};

// A hull in the frame: where, and how long and how skewed its axes are, px.
LeafHull random_hull(Random& random, const TileView& view, const dvec3& bvh_center) {
  const double depth = random.chance(0.1)   ? view.depth * random.between(-1.0, 0.3)
                       : random.chance(0.2) ? view.depth * random.log_between(0.1, 10.0)
                                            : view.depth + 0.4 * view.size * random.between(-1.0, 1.0);
  const double reach = random.chance(0.2) ? 100.0 : 2.0;
  const dvec2 at(random.between(view.rect.x0 - reach, view.rect.x1 + reach),
                 random.between(view.rect.y0 - reach, view.rect.y1 + reach));
  const dvec3 middle = view.to_prototype(view.point(at, depth));
  const double px = view.camera.pixel * (view.camera.perspective ? std::abs(depth) : 1.0);  // mm
  const dmat3 from_world = glm::inverse(view.placement.linear);
  const dmat3 turn = random.rotation();
  dvec3 axes[3];
  const double longest = random.log_between(1e-3, 300.0) * px;
  for (int i = 0; i < 3; ++i) {
    axes[i] =
        turn[i] * longest * (random.chance(0.5) ? random.between(0.3, 1.0) : random.log_between(1e-6, 1.0));
    if (random.chance(0.2)) axes[i] += 0.9 * axes[(i + 1) % 3] * random.between(-1.0, 1.0);  // skewed
  }
  if (random.chance(0.3)) {  // edge-on: an axis along the ray, and the others across it
    const dvec3 ray = view.camera.perspective ? glm::normalize(view.placement.point(middle) - view.camera.eye)
                                              : view.camera.forward;
    const dvec3 right = glm::normalize(glm::cross(ray, random.direction()));
    const int i = static_cast<int>(random.below(3));
    axes[i] = glm::length(axes[i]) * ray;
    axes[(i + 1) % 3] = glm::length(axes[(i + 1) % 3]) * right;
    axes[(i + 2) % 3] = glm::length(axes[(i + 2) % 3]) * glm::cross(ray, right);
  }
  LeafHull hull;
  put(hull.center, middle - bvh_center);
  put(hull.a, from_world * axes[0]), put(hull.b, from_world * axes[1]), put(hull.k, from_world * axes[2]);
  return hull;
}

double radius_of(const LeafHull& h) {
  double radius = 0.0;
  for (int c = 0; c < 8; ++c)
    radius = std::max(radius, glm::length(vec(h.center) + (c & 1 ? 1.0 : -1.0) * vec(h.a) +
                                          (c & 2 ? 1.0 : -1.0) * vec(h.b) + (c & 4 ? 1.0 : -1.0) * vec(h.k)));
  return radius;
}

struct Counts {
  long rays = 0, met = 0, set = 0, limited = 0, missed = 0;
};

// One batch of hulls in one tile; counts the rays. Complains about rays that
// are missed.
void check(Random& random, const TileView& view, const dvec3& bvh_center, const std::vector<LeafHull>& hulls,
           double reference, bool unlimited, Counts& counts, const std::string& what) {
  double radius = 0.0;
  for (const LeafHull& h : hulls) radius = std::max(radius, radius_of(h));
  const TileFrame frame(view.frame, bvh_center, radius, view.rect, reference);
  std::vector<std::int32_t> leaves;
  for (std::size_t i = 0; i < hulls.size(); ++i) leaves.push_back(static_cast<std::int32_t>(i));
  std::shuffle(leaves.begin(), leaves.end(), random.engine);
  if (random.chance(0.5)) leaves.resize(1 + random.below(leaves.size()));
  Footprints footprints;
  make_footprints(frame, hulls, leaves, view.width, view.height, footprints);
  const dvec2 place(random.chance(0.3) ? dvec2(0.5) : dvec2(random.unit(), random.unit()));
  std::vector<float> best(kMaxTile * kMaxTile + kMaxTile);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Slabs slabs(view, bvh_center, hulls[leaves[i]]);
    const double middle =
        glm::dot(RealVec(view.frame.about(bvh_center).point(vec(hulls[leaves[i]].center))), RealVec(0, 0, 1));
    // Near the front of the hull, anywhere in it, or nothing met yet.
    const auto index = static_cast<int>(i);
    const double spread =
        glm::length(view.placement.linear * (vec(hulls[leaves[i]].a) + vec(hulls[leaves[i]].b)));
    for (float& b : best)
      b = unlimited || random.chance(0.3)
              ? kFarDepth
              : static_cast<float>(middle - reference + 2.0 * spread * random.between(-1.0, 1.0));
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x) {
        Real near, far;
        if (!unlimited && random.chance(0.2) && slabs.meets(view.at(x, y, place), near, far))
          best[y * kMaxTile + x] =
              std::nextafter(static_cast<float>(near - reference), std::numeric_limits<float>::max());
      }
    ASSERT_TRUE(footprints.x0[i] >= 0 && footprints.x1[i] <= view.width && footprints.y0[i] >= 0 &&
                footprints.y1[i] <= view.height);
    std::uint64_t rows[kMaxTile] = {};
    bool any = false;
    if (footprints.x0[i] < footprints.x1[i] && footprints.y0[i] < footprints.y1[i])
      any = cover(footprints, index, best.data(), static_cast<float>(place.x - 0.5),
                  static_cast<float>(place.y - 0.5), view.width, view.height, rows);
    std::uint64_t all = 0;
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x) {
        const bool set = y >= footprints.y0[i] && y < footprints.y1[i] && (rows[y] >> x & 1u);
        all |= set;
        Real near = 0, far = 0;
        const bool meets = slabs.meets(view.at(x, y, place), near, far);
        const bool counts_here = meets && near - static_cast<Real>(reference) <= best[y * kMaxTile + x];
        ++counts.rays, counts.met += meets, counts.limited += counts_here, counts.set += set;
        if (counts_here && !set && ++counts.missed <= 3)
          ADD_FAILURE() << what << ": hull " << i << " of " << leaves.size() << " misses pixel " << x << ", "
                        << y << " of " << view.width << " x " << view.height
                        << (view.frame.perspective ? ", perspective" : ", orthographic") << ", depths "
                        << static_cast<double>(near) << " to " << static_cast<double>(far) << ", best "
                        << best[y * kMaxTile + x] << " from " << reference;
      }
    for (int y = footprints.y0[i]; y < footprints.y1[i]; ++y)
      ASSERT_EQ(view.width < 64 ? rows[y] >> view.width : 0, 0u) << what;
    ASSERT_EQ(any, all != 0) << what;
  }
}

double any_reference(Random& random, const TileView& view) {
  switch (random.below(4)) {
    case 0:
      return 0.0;
    case 1:
      return view.depth;
    case 2:
      return view.depth * random.log_between(0.1, 10.0);
    default:
      return -view.depth * random.log_between(0.1, 10.0);
  }
}

TEST(Footprint, HoldsEveryRayThatMeetsTheHull) {
  Random random(1);
  Counts counts;
  for (int i = 0; i < 1500; ++i) {
    const double far = i % 3 == 0 ? 0.0 : random.log_between(0.1, 1e3);
    const TileView view = random_tile(random, far, i % 2 ? 1.0 : random.log_between(1.0, 1e3));
    const dvec3 center = view.target + view.size * random.unit() * random.direction();
    std::vector<LeafHull> hulls(1 + random.below(20));
    if (hulls.size() > kBatch) hulls.resize(kBatch);
    for (LeafHull& h : hulls) h = random_hull(random, view, center);
    check(random, view, center, hulls, any_reference(random, view), i % 4 == 0, counts, std::to_string(i));
    if (counts.missed > 0) break;
  }
  EXPECT_EQ(counts.missed, 0);
  EXPECT_GT(counts.limited, 400000);
  EXPECT_GT(counts.met, counts.limited + 100000);  // best mattered
  EXPECT_GT(counts.rays, 2 * counts.met);
}

TEST(Footprint, IsTheSameConservativeOneOnEveryMachine) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    Random random(2);
    Counts counts;
    for (int i = 0; i < 200 && counts.missed == 0; ++i) {
      const TileView view = random_tile(random, 1.0, 1.0);
      std::vector<LeafHull> hulls(kBatch);
      for (LeafHull& h : hulls) h = random_hull(random, view, view.target);
      check(random, view, view.target, hulls, any_reference(random, view), false, counts,
            std::string(hwy::TargetName(target)) + " " + std::to_string(i));
    }
    EXPECT_GT(counts.limited, 100000) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
}

// A hull of ordinary shape, before the eye.
// least: of its size, px.
LeafHull plain_hull(Random& random, const TileView& view, double thickness, double least = 2.0) {
  const dvec2 at(random.between(view.rect.x0, view.rect.x1), random.between(view.rect.y0, view.rect.y1));
  const double depth = view.depth * random.between(0.8, 1.2);
  const double px = view.camera.pixel * (view.camera.perspective ? depth : 1.0);
  const dmat3 turn = random.rotation(), from_world = glm::inverse(view.placement.linear);
  const double size = random.log_between(least, 30.0) * px;
  LeafHull hull;
  put(hull.center, view.to_prototype(view.point(at, depth)) - view.target);
  put(hull.a, from_world * turn[0] * size);
  put(hull.b, from_world * (turn[1] + 0.5 * random.between(-1.0, 1.0) * turn[0]) * size);
  put(hull.k, from_world * turn[2] * size * thickness);
  return hull;
}

TEST(Footprint, OfPlainHullsIsTheirOutline) {
  Random random(3);
  for (const double thickness : {1.0, 0.1, 1e-3}) {
    Counts counts;
    for (int i = 0; i < 400; ++i) {
      TileView view = random_tile(random, 1.0, 1.0);
      // Coordinates are good to some 1e-6 of the size: less than a hundredth of
      // a pixel here.
      std::vector<LeafHull> hulls(kBatch);
      for (LeafHull& h : hulls) h = plain_hull(random, view, thickness);
      check(random, view, view.target, hulls, view.depth, true, counts, std::to_string(thickness));
    }
    EXPECT_EQ(counts.missed, 0);
    EXPECT_GT(counts.met, 100000);
    EXPECT_LT(counts.set, 1.02 * counts.met) << thickness;
  }
}

// Behind what is known already a flat hull leaves nothing to do. (Of small ones in perspective only the
// nearest depth counts.)
TEST(Footprint, OfFlatHullsEndsAtTheirDepth) {
  Random random(4);
  Counts counts[2];
  for (int i = 0; i < 400; ++i) {
    const TileView view = random_tile(random, 1.0, 1.0);
    std::vector<LeafHull> hulls(kBatch);
    for (LeafHull& h : hulls) h = plain_hull(random, view, 1e-3, 15.0);
    check(random, view, view.target, hulls, view.depth, false, counts[view.frame.perspective], "flat");
  }
  for (const Counts& c : counts) {
    EXPECT_EQ(c.missed, 0);
    EXPECT_GT(c.met, c.limited + 20000);
    EXPECT_LT(c.set - c.limited, 0.02 * (c.met - c.limited));
  }
}

}  // namespace
}  // namespace trimray::hybrid
