// The search in lanes for all roots of a line on a leaf, against the scalar one bit by bit, on every
// instruction set.
#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <cstring>

#include "tests/core/trace/patch_nets.h"

namespace trimray::trace {
namespace {

std::vector<std::int64_t> targets() {
  std::vector<std::int64_t> list{0};  // the best one
  for (const std::int64_t target : {std::int64_t{HWY_AVX2}, std::int64_t{HWY_STATIC_TARGET}})
    if ((hwy::SupportedTargets() & target) != 0) list.push_back(target);
  return list;
}

// Lines through points of a patch, or past them by 1e-1 to 1e-9 of its size; most of them near the tangent
// plane there, and some of those in it.
RayLanes grazing_rays(std::mt19937& rng, const Net& net, const Box2& uv) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  RayLanes rays = {};
  rays.active = static_cast<std::uint32_t>(rng() & 0xff);
  for (int i = 0; i < kLanes; ++i) {
    const dvec2 x = uv.lower + (1.2 * dvec2(uniform(rng), uniform(rng)) - 0.1) * uv.extent();
    const double h = 1e-6;
    const dvec3 p = point(net, x.x, x.y);
    const dvec3 n =
        glm::normalize(glm::cross(point(net, x.x + h, x.y) - p, point(net, x.x, x.y + h) - p) + dvec3(1e-30));
    dvec3 d = glm::normalize(dvec3(normal(rng), normal(rng), normal(rng)));
    const double steep = uniform(rng);
    if (steep < 0.8)
      d = glm::normalize(d - (steep < 0.2 ? 1.0 : 1.0 - steep * uniform(rng)) * glm::dot(d, n) * n);
    const double past = uniform(rng) < 0.5 ? 0.0 : std::pow(10.0, -1.0 - 8.0 * uniform(rng));
    const dvec3 o = p + (uniform(rng) < 0.5 ? past : -past) * n - (1.0 + 10.0 * uniform(rng)) * d;
    rays.org_x[i] = o.x, rays.org_y[i] = o.y, rays.org_z[i] = o.z;
    rays.dir_x[i] = d.x, rays.dir_y[i] = d.y, rays.dir_z[i] = d.z;
  }
  return rays;
}

bool same_bits(const Root& a, const Root& b) {
  return std::memcmp(&a.t, &b.t, sizeof a.t) == 0 &&
         std::memcmp(&a.uv_face, &b.uv_face, sizeof a.uv_face) == 0 &&
         std::memcmp(&a.normal, &b.normal, sizeof a.normal) == 0 && a.face == b.face && a.sign == b.sign &&
         !a.inside;
}

bool before(const Root& a, const Root& b) {
  if (a.t != b.t) return a.t < b.t;
  return a.uv_face.x != b.uv_face.x ? a.uv_face.x < b.uv_face.x : a.uv_face.y < b.uv_face.y;
}

bool tangent(const std::vector<Root>& roots, const Ray& ray) {
  return std::all_of(roots.begin(), roots.end(),
                     [&](const Root& r) { return std::fabs(glm::dot(r.normal, ray.dir)) < 1e-6; });
}

struct Count {
  int lanes = 0, roots = 0, several = 0, open = 0, undecided = 0;
};

// Every leaf of the patch, a few groups of lines each.
void compare(const Net& net, std::mt19937& rng, int groups, Count& count) {
  const Made made(as_face(net));
  std::vector<Root> want, got;
  std::vector<LaneRoot> found;
  for (std::size_t k = 0; k < made.set.leaves().size(); ++k) {
    const auto leaf = static_cast<std::int32_t>(k);
    for (int g = 0; g < groups; ++g) {
      const RayLanes rays = grazing_rays(rng, net, made.set.leaves()[k].uv_face);
      RootLanes solved;
      made.set.solve(leaf, rays, solved);
      found.clear();
      made.set.open_roots(leaf, rays, found);
      for (int i = 0; i < kLanes; ++i) {
        want.clear(), got.clear();
        for (const LaneRoot& r : found)
          if (r.lane == i) got.push_back(r.root);
        if ((rays.active >> i & 1u) == 0) {
          EXPECT_TRUE(got.empty());
          continue;
        }
        ++count.lanes;
        count.open += (~(solved.one | solved.none) >> i) & 1u;
        EXPECT_TRUE(made.set.all_roots(leaf, lane(rays, i), want));
        count.roots += static_cast<int>(want.size());
        count.several += want.size() > 1;
        std::sort(want.begin(), want.end(), before), std::sort(got.begin(), got.end(), before);
        const bool equal = std::equal(want.begin(), want.end(), got.begin(), got.end(), same_bits);
        // Two roots closer than rounding can tell may be there for one of the two searches only.
        count.undecided += !equal;
        EXPECT_TRUE(equal || (tangent(want, lane(rays, i)) && tangent(got, lane(rays, i))))
            << want.size() << " roots, got " << got.size() << ", degrees " << net.du << ", " << net.dv
            << ", leaf " << k << ", " << describe(lane(rays, i));
      }
    }
  }
}

Net with_pole(Net net) {
  for (int j = 1; j <= net.dv; ++j) {
    const double w = net.h[j].w;
    net.h[j] = net.h[0] * (w / net.h[0].w);
  }
  return net;
}

// A quarter of a cylinder, rational, bent along u.
Net cylinder(int dv) {
  Net net{2, dv, {}};
  const dvec3 arc[3] = {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= dv; ++j) {
      const double w = i == 1 ? std::sqrt(0.5) : 1.0;
      net.h.push_back(dvec4(w * (arc[i] + dvec3(0, 0, 3.0 * j / dv)), w));
    }
  return net;
}

class PatchOpen : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(PatchOpen, RootsAreThoseOfTheScalarSearch) {
  std::mt19937 rng(31);
  Count count;
  for (int k = 0; k < 4; ++k) compare(random_net(rng, 3, 3, 0.1 + 0.2 * k, k % 2 == 1), rng, 6, count);
  for (const auto& [du, dv] :
       {std::pair(1, 1), std::pair(2, 1), std::pair(1, 3), std::pair(2, 2), std::pair(5, 4)})
    compare(random_net(rng, du, dv, 0.3, du % 2 == 0), rng, 6, count);
  EXPECT_GT(count.open, count.lanes / 10);
  EXPECT_GT(count.roots, count.lanes / 4);
  EXPECT_GT(count.several, count.lanes / 50);
  EXPECT_LT(count.undecided, count.lanes / 500);
}

TEST_P(PatchOpen, HighDegreesToo) {
  std::mt19937 rng(32);
  Count count;
  compare(random_net(rng, 7, 3, 0.3, false), rng, 3, count);
  compare(random_net(rng, 5, 6, 0.3, true), rng, 3, count);
  compare(random_net(rng, 2, 25, 0.2, false), rng, 1, count);
  compare(random_net(rng, 24, 13, 0.5, true), rng, 1, count);
  EXPECT_GT(count.several, count.lanes / 50);
  EXPECT_LT(count.undecided, count.lanes / 500);
}

TEST_P(PatchOpen, CylindersAndFlatPatches) {
  std::mt19937 rng(33);
  Count count;
  compare(cylinder(1), rng, 30, count);
  compare(cylinder(3), rng, 30, count);
  Net flat = random_net(rng, 3, 3, 0.0, false);
  compare(flat, rng, 30, count);
  EXPECT_GT(count.several, 20);
  EXPECT_LT(count.undecided, count.lanes / 500);
}

TEST_P(PatchOpen, CollapsedSides) {
  std::mt19937 rng(34);
  Count count;
  compare(with_pole(random_net(rng, 3, 3, 0.3, false)), rng, 4, count);
  compare(with_pole(random_net(rng, 2, 3, 0.3, true)), rng, 4, count);
  compare(with_pole(random_net(rng, 6, 3, 0.2, true)), rng, 4, count);
  EXPECT_GT(count.roots, count.lanes / 4);
  EXPECT_LT(count.undecided, count.lanes / 500);
}

// Lines in the plane of a flat patch: they cross it nowhere, and the search ends.
TEST_P(PatchOpen, LinesInTheSurface) {
  std::mt19937 rng(35);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Made made(as_face(random_net(rng, 3, 2, 0.0, true)));
  RayLanes rays = {};
  rays.active = 0xff;
  for (int i = 0; i < kLanes; ++i) {
    const dvec3 d = glm::normalize(dvec3(uniform(rng) - 0.5, uniform(rng) - 0.5, 0.0));
    const dvec3 o = dvec3(uniform(rng), uniform(rng), i % 2 ? 0.0 : 1e-3) - 3.0 * d;
    rays.org_x[i] = o.x, rays.org_y[i] = o.y, rays.org_z[i] = o.z;
    rays.dir_x[i] = d.x, rays.dir_y[i] = d.y, rays.dir_z[i] = d.z;
  }
  std::vector<LaneRoot> found;
  int searches = 0;
  for (std::size_t k = 0; k < made.set.leaves().size(); ++k)
    searches += made.set.open_roots(static_cast<std::int32_t>(k), rays, found);
  EXPECT_TRUE(found.empty());
  EXPECT_GT(searches, 0);
  EXPECT_LE(searches, kLanes / 2 * static_cast<int>(made.set.leaves().size()));
}

INSTANTIATE_TEST_SUITE_P(Targets, PatchOpen, testing::ValuesIn(targets()),
                         [](const auto& test) { return "target" + std::to_string(test.param); });

}  // namespace
}  // namespace trimray::trace
