// Newton's method from seeds: its claims against solve() and all_roots(), bit by bit, from good seeds, bad
// ones and nonsense, on every instruction set.
#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <cstring>
#include <limits>

#include "tests/core/trace/patch_nets.h"

namespace trimray::trace {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<std::int64_t> targets() {
  std::vector<std::int64_t> list{0};  // the best one
  for (const std::int64_t target : {std::int64_t{HWY_AVX2}, std::int64_t{HWY_STATIC_TARGET}})
    if ((hwy::SupportedTargets() & target) != 0) list.push_back(target);
  return list;
}

void set_lane(RayLanes& rays, int i, const dvec3& org, const dvec3& dir) {
  rays.org_x[i] = org.x, rays.org_y[i] = org.y, rays.org_z[i] = org.z;
  rays.dir_x[i] = dir.x, rays.dir_y[i] = dir.y, rays.dir_z[i] = dir.z;
}

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Rays through points of a patch, with their parameters. Half of the directions are near the tangent plane.
struct Shots {
  RayLanes rays = {};
  double u[kLanes], v[kLanes], slope[kLanes];  // |n . d|
};

Shots shoot(std::mt19937& rng, const Net& net) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  Shots s;
  s.rays.active = 0xff;
  for (int i = 0; i < kLanes; ++i) {
    const double u = s.u[i] = 0.01 + 0.98 * uniform(rng), v = s.v[i] = 0.01 + 0.98 * uniform(rng), h = 1e-6;
    const dvec3 p = point(net, u, v);
    const dvec3 n = glm::normalize(glm::cross(point(net, u + h, v) - p, point(net, u, v + h) - p));
    dvec3 d = glm::normalize(dvec3(normal(rng), normal(rng), normal(rng)));
    if (i % 2) d = glm::normalize(d - (1.0 - 0.2 * uniform(rng)) * glm::dot(d, n) * n);
    s.slope[i] = std::fabs(glm::dot(n, d));
    set_lane(s.rays, i, p - (1.0 + 100.0 * uniform(rng)) * d, d);
  }
  return s;
}

SeedLanes seeds_near(std::mt19937& rng, const Shots& shots, double off) {
  std::uniform_real_distribution<double> noise(-off, off);
  SeedLanes seeds;
  for (int i = 0; i < kLanes; ++i) seeds.u[i] = shots.u[i] + noise(rng), seeds.v[i] = shots.v[i] + noise(rng);
  return seeds;
}

// What solve(), or all_roots() in its stead, says about the leaf that solve_seeded() names. Returns the
// number of lanes in `one`.
int check_claims(const PatchSet& set, const RayLanes& rays, const SeededRoots& got) {
  EXPECT_EQ(got.one & ~rays.active, 0u);
  std::vector<Root> roots;
  int count = 0;
  for (int i = 0; i < kLanes; ++i) {
    if (!(got.one >> i & 1u)) continue;
    ++count;
    RootLanes want;
    set.solve(got.leaf[i], rays, want);
    EXPECT_FALSE(want.none >> i & 1u) << describe(lane(rays, i));
    if (want.one >> i & 1u) {
      EXPECT_TRUE(same(got.t[i], want.t[i]) && same(got.u[i], want.u[i]) && same(got.v[i], want.v[i]) &&
                  same(got.normal_x[i], want.normal_x[i]) && same(got.normal_y[i], want.normal_y[i]) &&
                  same(got.normal_z[i], want.normal_z[i]) && same(got.param_u[i], want.param_u[i]) &&
                  same(got.param_v[i], want.param_v[i]))
          << describe(lane(rays, i));
    }
    roots.clear();
    EXPECT_TRUE(set.all_roots(got.leaf[i], lane(rays, i), roots));
    EXPECT_EQ(roots.size(), 1u) << describe(lane(rays, i));
    if (roots.size() != 1) continue;
    EXPECT_TRUE(same(got.t[i], roots[0].t) && same(got.u[i], roots[0].uv_face.x) &&
                same(got.v[i], roots[0].uv_face.y))
        << describe(lane(rays, i));
  }
  return count;
}

// Every leaf that rules_out() excludes has no root, and no claim of solve()'s. Returns how many it excludes.
int check_exclusions(const PatchSet& set, const RayLanes& rays, const SeededRoots& got) {
  int count = 0;
  std::vector<Root> roots;
  RayLanes asked = rays;
  asked.active = got.one;
  for (std::size_t k = 0; k < set.leaves().size(); ++k) {
    const auto leaf = static_cast<std::int32_t>(k);
    const std::uint32_t out = set.rules_out(leaf, asked, got.param_u, got.param_v);
    EXPECT_EQ(out & ~got.one, 0u);
    if (out == 0) continue;
    RootLanes solved;
    set.solve(leaf, rays, solved);
    EXPECT_EQ(solved.one & out, 0u);
    for (int i = 0; i < kLanes; ++i) {
      if (!(out >> i & 1u)) continue;
      ++count;
      EXPECT_NE(got.leaf[i], leaf);
      roots.clear();
      EXPECT_TRUE(set.all_roots(leaf, lane(rays, i), roots));
      EXPECT_EQ(roots.size(), 0u) << describe(lane(rays, i));
    }
  }
  return count;
}

std::vector<Net> some_nets(std::mt19937& rng) {
  std::vector<Net> nets;
  for (int k = 0; k < 4; ++k) nets.push_back(random_net(rng, 3, 3, 0.15 + 0.1 * k, k % 2 == 1));
  for (const auto& [du, dv] : {std::pair(1, 1), std::pair(2, 1), std::pair(1, 3), std::pair(2, 2),
                               std::pair(5, 4), std::pair(7, 3)}) {
    nets.push_back(random_net(rng, du, dv, 0.2, false));
    nets.push_back(random_net(rng, du, dv, 0.2, true));
  }
  // One side collapsed to a point.
  for (const bool rational : {false, true}) {
    Net net = random_net(rng, 2, 3, 0.2, rational);
    for (int j = 0; j <= 3; ++j) net.h[j] = net.h[0];
    nets.push_back(net);
  }
  return nets;
}

TEST(PatchSeeded, GoodSeedsGiveTheBitsOfTheLeaves) {
  std::mt19937 rng(31);
  int steep = 0, steep_one = 0, steps = 0, excluded = 0;
  for (const Net& net : some_nets(rng)) {
    const Made made(as_face(net));
    const std::int32_t patch = made.set.patch_at(0, dvec2(0.5));
    ASSERT_EQ(patch, made.set.leaves()[0].patch);
    for (int k = 0; k < 200; ++k) {
      const Shots shots = shoot(rng, net);
      const SeedLanes seeds = seeds_near(rng, shots, 0.01);
      SeededRoots best;
      made.set.solve_seeded(patch, shots.rays, seeds, best);
      check_claims(made.set, shots.rays, best);
      if (k < 20) excluded += check_exclusions(made.set, shots.rays, best);
      steps += static_cast<int>(best.steps);
      for (int i = 0; i < kLanes; ++i)
        if (shots.slope[i] > 0.3) ++steep, steep_one += static_cast<int>(best.one >> i & 1u);
      for (const std::int64_t target : targets()) {
        hwy::SetSupportedTargetsForTest(target);
        SeededRoots other;
        made.set.solve_seeded(patch, shots.rays, seeds, other);
        EXPECT_EQ(made.set.rules_out(0, shots.rays, best.param_u, best.param_v) & best.one,
                  made.set.rules_out(0, shots.rays, other.param_u, other.param_v) & best.one);
        hwy::SetSupportedTargetsForTest(0);
        ASSERT_EQ(other.one, best.one);
        for (int i = 0; i < kLanes; ++i) {
          if (!(best.one >> i & 1u)) continue;
          EXPECT_EQ(other.leaf[i], best.leaf[i]);
          EXPECT_TRUE(same(other.t[i], best.t[i]) && same(other.u[i], best.u[i]) &&
                      same(other.v[i], best.v[i]) && same(other.normal_x[i], best.normal_x[i]) &&
                      same(other.param_u[i], best.param_u[i]));
        }
      }
    }
  }
  EXPECT_GT(steep_one, 0.97 * steep);
  EXPECT_GT(excluded, 500);
}

TEST(PatchSeeded, WrongSeedsNeverGiveAWrongRoot) {
  std::mt19937 rng(32);
  std::uniform_real_distribution<double> anywhere(-0.5, 1.5);
  const double nonsense[] = {kNaN, kInf, -kInf, 1e300, -1e300, 0.0, 1.0, 5e-324};
  std::uniform_int_distribution<int> pick(0, 7);
  int found = 0;
  for (const Net& net : some_nets(rng)) {
    const Made made(as_face(net));
    const std::int32_t patch = made.set.leaves()[0].patch;
    for (int k = 0; k < 60; ++k) {
      Shots shots = shoot(rng, net);
      SeedLanes seeds;
      for (int i = 0; i < kLanes; ++i) {
        seeds.u[i] = k % 3 ? anywhere(rng) : nonsense[pick(rng)];
        seeds.v[i] = k % 3 ? anywhere(rng) : nonsense[pick(rng)];
        // Some of the rays miss.
        if (k % 4 == 0) shots.rays.org_x[i] += anywhere(rng), shots.rays.org_z[i] += anywhere(rng);
      }
      shots.rays.active = k % 5 ? 0xff : 0x5a;
      SeededRoots roots;
      made.set.solve_seeded(patch, shots.rays, seeds, roots);
      found += check_claims(made.set, shots.rays, roots);
      if (k < 10) check_exclusions(made.set, shots.rays, roots);
    }
  }
  EXPECT_GT(found, 1000);
}

// The same root from many seeds: `one` sets the same bits, whatever the seed.
TEST(PatchSeeded, TheBitsDoNotDependOnTheSeed) {
  std::mt19937 rng(33);
  int compared = 0;
  for (const Net& net : some_nets(rng)) {
    const Made made(as_face(net));
    for (int k = 0; k < 20; ++k) {
      const Shots shots = shoot(rng, net);
      SeededRoots first;
      made.set.solve_seeded(0, shots.rays, seeds_near(rng, shots, 1e-3), first);
      for (const double off : {0.0, 1e-9, 1e-7, 1e-5, 1e-4, 3e-3, 0.03, 0.1}) {
        SeededRoots other;
        made.set.solve_seeded(0, shots.rays, seeds_near(rng, shots, off), other);
        for (int i = 0; i < kLanes; ++i)
          if ((first.one & other.one) >> i & 1u && first.leaf[i] == other.leaf[i]) {
            EXPECT_TRUE(same(first.t[i], other.t[i]) && same(first.u[i], other.u[i]) &&
                        same(first.v[i], other.v[i]) && same(first.normal_z[i], other.normal_z[i]));
            ++compared;
          }
      }
    }
  }
  EXPECT_GT(compared, 10000);
}

// Surfaces of revolution as NURBS: several patches, parameters that are angles, poles.
TEST(PatchSeeded, AnglesAndPoles) {
  std::mt19937 rng(35);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0), noise(-0.01, 0.01);
  nurbs::FaceSpec sphere = nurbs::full_sphere({}, 2.0), torus = nurbs::full_torus({}, 3.0, 1.0);
  for (nurbs::FaceSpec* face : {&sphere, &torus}) {
    face->surface = nurbs::as_nurbs(face->surface);
    const Made made(*face);
    int asked = 0, one = 0;
    std::vector<Root> roots;
    for (int k = 0; k < 4000; ++k) {
      // A line near the surface's points, and the roots it has, gathered by patch.
      const dvec3 target = face == &sphere ? dvec3(0.0) : dvec3(3.0, 0.0, 0.0);
      const double reach = face == &sphere ? 1.2 : 0.6;
      const dvec3 d = glm::normalize(dvec3(normal(rng), normal(rng), normal(rng)));
      const Ray ray{target + reach * dvec3(uniform(rng), uniform(rng), uniform(rng)) - 9.0 * d, d};
      for (const Root& root : every_root(made.set, ray, 6.0)) {
        const std::int32_t patch = made.set.patch_at(0, root.uv_face);
        ASSERT_GE(patch, 0);
        RayLanes rays = {};
        rays.active = 2;
        set_lane(rays, 1, ray.org, ray.dir);
        SeedLanes seeds = {};
        seeds.u[1] = root.uv_face.x + noise(rng), seeds.v[1] = root.uv_face.y + noise(rng);
        SeededRoots got;
        made.set.solve_seeded(patch, rays, seeds, got);
        ++asked, one += check_claims(made.set, rays, got);
        if (got.one == 0) continue;
        EXPECT_EQ(made.set.leaves()[got.leaf[1]].patch, patch);
        EXPECT_LT(std::fabs(got.t[1] - root.t), 1e-10);
        if (k % 50 == 0) {
          // Only leaves of the same patch may be asked about.
          for (std::size_t leaf = 0; leaf < made.set.leaves().size(); ++leaf) {
            if (made.set.leaves()[leaf].patch != patch) continue;
            if (!made.set.rules_out(static_cast<std::int32_t>(leaf), rays, got.param_u, got.param_v))
              continue;
            roots.clear();
            made.set.all_roots(static_cast<std::int32_t>(leaf), ray, roots);
            EXPECT_EQ(roots.size(), 0u);
          }
        }
      }
    }
    EXPECT_GT(asked, 7000);
    EXPECT_GT(one, 0.93 * asked);
  }
}

TEST(PatchSeeded, OffsetPatchesNeverSayOne) {
  std::mt19937 rng(36);
  nurbs::FaceSpec face = as_face(random_net(rng, 3, 3, 0.1, false));
  const Net net = random_net(rng, 3, 3, 0.1, false);
  face.surface = nurbs::as_offset(face.surface, 0.01);
  const Made made(face);
  for (int k = 0; k < 100; ++k) {
    const Shots shots = shoot(rng, net);
    SeededRoots got;
    made.set.solve_seeded(0, shots.rays, seeds_near(rng, shots, 0.01), got);
    EXPECT_EQ(got.one, 0u);
    EXPECT_EQ(made.set.rules_out(0, shots.rays, shots.u, shots.v), 0u);
  }
}

// Rows and columns of patches, one of them missing for its weights.
TEST(PatchSeeded, PatchAtFindsThePatchOfAPlace) {
  std::mt19937 rng(34);
  nurbs::FaceSpec face = as_face(random_net(rng, 3, 3, 0.2, false));
  const Made single(face);
  EXPECT_EQ(single.set.patch_at(0, dvec2(-3.0, 9.0)), 0);
  EXPECT_EQ(single.set.patch_at(0, dvec2(kNaN)), 0);

  const std::vector<double> knots_u{0, 0, 0, 1, 2, 4, 4, 4}, knots_v{0, 0, 3, 5, 5};
  std::vector<dvec4> ctrl;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 3; ++j) ctrl.push_back(dvec4(i, j, 0.1 * (i * j % 3), 1.0));
  face.surface = nurbs::make_bspline(2, 1, knots_u, knots_v, ctrl);
  face.uv_box = {};
  face.uv_box.add(dvec2(0.2, 0.5)), face.uv_box.add(dvec2(3.5, 5.0));
  const Made made(face);
  std::uniform_real_distribution<double> u(0.2, 3.5), v(0.5, 5.0);
  for (int k = 0; k < 1000; ++k) {
    const dvec2 uv(u(rng), v(rng));
    const std::int32_t patch = made.set.patch_at(0, uv);
    bool holds = false;
    for (const PatchLeaf& leaf : made.set.leaves())
      holds = holds || (leaf.patch == patch && leaf.uv_face.contains(uv));
    EXPECT_TRUE(holds) << uv.x << ", " << uv.y;
  }
}

}  // namespace
}  // namespace trimray::trace
