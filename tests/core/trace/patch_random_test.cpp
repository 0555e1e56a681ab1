// The patch kernel on patches without closed form, against a search that shares nothing with it: own
// evaluation by de Casteljau, Newton from every cell of a fine grid.
#include <gtest/gtest.h>

#include <hwy/targets.h>

#include "core/trace/newton.h"
#include "tests/core/trace/patch_nets.h"

namespace trimray::trace {
namespace {

// Roots within [0, 1]^2 that Newton with difference quotients reaches from any cell of the grid.
struct Grid {
  static constexpr int kCells = 24;
  const Net& net;
  std::vector<dvec3> points;
  explicit Grid(const Net& n) : net(n) {
    for (int i = 0; i <= kCells; ++i)
      for (int j = 0; j <= kCells; ++j) points.push_back(point(n, double(i) / kCells, double(j) / kCells));
  }

  std::vector<dvec2> roots(const Ray& ray) const {
    std::vector<dvec2> found;
    for (int i = 0; i < kCells; ++i)
      for (int j = 0; j < kCells; ++j) {
        Box3 box;
        for (int k = 0; k < 4; ++k) box.add(points[(i + k / 2) * (kCells + 1) + j + k % 2]);
        if (glm::length(glm::cross(box.center() - ray.org, ray.dir)) > 0.8 * box.diagonal()) continue;
        dvec2 x((i + 0.5) / kCells, (j + 0.5) / kCells);
        if (newton(ray, x) && std::none_of(found.begin(), found.end(),
                                           [&](const dvec2& f) { return glm::length(f - x) < 1e-6; }))
          found.push_back(x);
      }
    return found;
  }

  bool newton(const Ray& ray, dvec2& x) const {
    const double h = 1e-6;
    for (int k = 0; k < 20; ++k) {
      const dvec3 p = point(net, x.x, x.y);
      const dvec3 pu = (point(net, x.x + h, x.y) - point(net, x.x - h, x.y)) / (2 * h);
      const dvec3 pv = (point(net, x.x, x.y + h) - point(net, x.x, x.y - h)) / (2 * h);
      const dvec3 g = glm::cross(p - ray.org, ray.dir);
      const dvec2 step = dvec2(glm::dot(g, pv), -glm::dot(g, pu)) / glm::dot(glm::cross(pu, pv), ray.dir);
      x += step;
      if (!(glm::length(x - dvec2(0.5)) < 1.0)) return false;
      if (glm::length(step) < 1e-10) return x.x >= 1e-6 && x.x <= 1 - 1e-6 && x.y >= 1e-6 && x.y <= 1 - 1e-6;
    }
    return false;
  }
};

void compare(const Net& net, std::mt19937& rng, int rays) {
  const Made made(as_face(net));
  const Grid grid(net);
  std::uniform_real_distribution<double> uniform(-0.1, 1.1);
  for (int k = 0; k < rays; ++k) {
    // Half of the rays run along the sheet and meet it several times.
    const double steep = k % 2 ? 1.0 : 0.1;
    const dvec3 a(uniform(rng), uniform(rng), steep * (uniform(rng) - 0.5)),
        b(uniform(rng), uniform(rng), -0.5 * steep);
    const Ray ray{a + 3.0 * (a - b), glm::normalize(b - a)};
    const std::vector<Root> roots = every_root(made.set, ray, 1.5);
    for (const Root& r : roots) {
      const double u = r.uv_face.x, v = r.uv_face.y, h = 1e-9;
      const dvec3 p = point(net, u, v);
      // Where tiny weights make the surface run fast, the last bit of u and v is worth more.
      const double speed =
          (glm::length(point(net, u + h, v) - p) + glm::length(point(net, u, v + h) - p)) / h;
      EXPECT_LT(glm::length(p - (ray.org + r.t * ray.dir)), 1e-11 + 1e-15 * speed) << describe(ray);
    }
    // Neighbouring crossings of one sheet go opposite ways only where it is closed; in uv they are distinct.
    for (const dvec2& x : grid.roots(ray)) {
      const bool known = std::any_of(roots.begin(), roots.end(),
                                     [&](const Root& r) { return glm::length(r.uv_face - x) < 1e-6; });
      EXPECT_TRUE(known) << describe(ray) << " root at " << x.x << ", " << x.y;
    }
    for (std::size_t i = 0; i < roots.size(); ++i)
      for (std::size_t j = i + 1; j < roots.size(); ++j)
        EXPECT_TRUE(glm::length(roots[i].uv_face - roots[j].uv_face) > 1e-9 ||
                    roots[i].sign != roots[j].sign);
  }
}

TEST(PatchRandom, FindsWhatADenseSearchFinds) {
  std::mt19937 rng(11);
  for (int k = 0; k < 6; ++k) compare(random_net(rng, 3, 3, 0.4, k % 2 == 1), rng, 120);
  for (const auto& [du, dv] :
       {std::pair(1, 1), std::pair(2, 4), std::pair(5, 1), std::pair(13, 1), std::pair(6, 10)})
    compare(random_net(rng, du, dv, 0.4, du % 2 == 0), rng, 60);
}

TEST(PatchRandom, TinyWeightsKeepTheirRoots) {
  std::mt19937 rng(21);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int k = 0; k < 4; ++k) {
    Net net = random_net(rng, 3, 3, 0.4, false);
    for (dvec4& h : net.h)
      if (uniform(rng) < 0.3) h *= std::pow(10.0, -6.0 * uniform(rng));
    net.h[5] *= 1e-6;
    compare(net, rng, 60);
  }
}

TEST(PatchRandom, DegreesUpToTheHighest) {
  std::mt19937 rng(22);
  compare(random_net(rng, 25, 2, 0.6, false), rng, 10);
  compare(random_net(rng, 3, 25, 0.6, true), rng, 10);
  compare(random_net(rng, 25, 25, 0.8, true), rng, 3);
}

RayLanes lanes_at(std::mt19937& rng, const Box3& box) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  RayLanes rays = {};
  for (int k = 0; k < kLanes; ++k) {
    const auto inside = [&] {
      return box.lower + dvec3(uniform(rng), uniform(rng), uniform(rng)) * (1.2 * box.extent()) -
             0.1 * box.extent();
    };
    const dvec3 a = inside(), d = glm::normalize(inside() - a), o = a - 5.0 * d;
    rays.org_x[k] = o.x, rays.org_y[k] = o.y, rays.org_z[k] = o.z;
    rays.dir_x[k] = d.x, rays.dir_y[k] = d.y, rays.dir_z[k] = d.z;
  }
  return rays;
}

// Every claim of solve() against the exhaustive search of the same leaf, and its bits against all_roots().
TEST(PatchSolve, ClaimsOnlyWhatTheExhaustiveSearchConfirms) {
  std::mt19937 rng(12);
  int one = 0, none = 0, lanes = 0, same_bits = 0;
  std::vector<Root> roots;
  for (int n = 0; n < 8; ++n) {
    const Made made(as_face(random_net(rng, n < 6 ? 3 : 7, 3, 0.3, n % 2 == 1)));
    for (std::size_t leaf = 0; leaf < made.set.leaves().size(); ++leaf)
      for (int k = 0; k < 20; ++k) {
        RayLanes rays = lanes_at(rng, made.set.leaves()[leaf].box);
        rays.active = 0xff;
        RootLanes out;
        made.set.solve(static_cast<std::int32_t>(leaf), rays, out);
        ASSERT_EQ(out.one & out.none, 0u);
        for (int i = 0; i < kLanes; ++i) {
          roots.clear();
          made.set.all_roots(static_cast<std::int32_t>(leaf), lane(rays, i), roots);
          const bool is_one = out.one >> i & 1u, is_none = out.none >> i & 1u;
          ++lanes, one += is_one, none += is_none;
          if (is_one) {
            ASSERT_EQ(roots.size(), 1u) << describe(lane(rays, i));
            EXPECT_NEAR(roots[0].t, out.t[i], 1e-12);
            same_bits += roots[0].t == out.t[i] && roots[0].uv_face == dvec2(out.u[i], out.v[i]);
          }
          if (is_none) {
            ASSERT_EQ(roots.size(), 0u) << describe(lane(rays, i));
          }
        }
      }
  }
  EXPECT_GT(one, lanes / 20);
  EXPECT_GT(none, lanes / 5);
  EXPECT_GE(same_bits, one - 1);  // kRootGrid's promise
}

TEST(PatchSolve, ALanesBitsDependOnNothingElse) {
  std::mt19937 rng(13);
  for (int n = 0; n < 4; ++n) {
    const Made made(as_face(random_net(rng, n == 3 ? 8 : 3, 3, 0.2, n % 2 == 1)));
    for (std::size_t leaf = 0; leaf < made.set.leaves().size(); ++leaf) {
      RayLanes rays = lanes_at(rng, made.set.leaves()[leaf].box);
      rays.active = 0xff;
      RootLanes all;
      made.set.solve(static_cast<std::int32_t>(leaf), rays, all);
      for (const std::int64_t target :
           {std::int64_t{0}, std::int64_t{HWY_AVX2}, std::int64_t{HWY_STATIC_TARGET}})
        for (int i = 0; i < kLanes; ++i) {
          // Alone in its register, and on every instruction set.
          if (target != 0 && (hwy::SupportedTargets() & target) == 0) continue;
          hwy::SetSupportedTargetsForTest(target);
          RootLanes alone;
          rays.active = 1u << i;
          made.set.solve(static_cast<std::int32_t>(leaf), rays, alone);
          hwy::SetSupportedTargetsForTest(0);
          EXPECT_EQ(alone.one, all.one & rays.active);
          EXPECT_EQ(alone.none, all.none & rays.active);
          if (alone.one == 0) continue;
          EXPECT_EQ(alone.t[i], all.t[i]);
          EXPECT_EQ(alone.u[i], all.u[i]);
          EXPECT_EQ(alone.v[i], all.v[i]);
          EXPECT_EQ(alone.normal_x[i], all.normal_x[i]);
        }
    }
  }
}

// Lines that touch the surface, or pass beside it by 1e-1 ... 1e-8 of its size: misses are seen in lanes,
// without a scalar search, and roots never denied.
TEST(PatchSolve, GrazingLinesAreProvenToMiss) {
  std::mt19937 rng(14);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int misses = 0, proven = 0;
  std::vector<Root> roots;
  std::vector<LaneRoot> found;
  for (int n = 0; n < 8; ++n) {
    const Net net = random_net(rng, n < 4 ? 3 : n < 6 ? 2 : 7, n < 4 ? 3 : 5, 0.3, n % 2 == 1);
    const Made made(as_face(net));
    for (int k = 0; k < 600; ++k) {
      const double u = uniform(rng), v = uniform(rng), h = 1e-5;
      const dvec3 p = point(net, u, v), pu = point(net, u + h, v) - p, pv = point(net, u, v + h) - p;
      const double turn = 6.3 * uniform(rng), aside = std::pow(10.0, -1.0 - 7.0 * uniform(rng));
      const dvec3 d =
          glm::normalize(std::cos(turn) * glm::normalize(pu) + std::sin(turn) * glm::normalize(pv));
      const dvec3 normal = glm::normalize(glm::cross(pu, pv));
      const Ray ray{p + (k % 2 ? aside : -aside) * normal - 3.0 * d, d};
      RayLanes lanes = {};
      lanes.org_x[0] = ray.org.x, lanes.org_y[0] = ray.org.y, lanes.org_z[0] = ray.org.z;
      lanes.dir_x[0] = d.x, lanes.dir_y[0] = d.y, lanes.dir_z[0] = d.z;
      lanes.active = 1;
      for (std::size_t leaf = 0; leaf < made.set.leaves().size(); ++leaf) {
        if (!near_box(made.set.leaves()[leaf].box, ray)) continue;
        RootLanes out;
        made.set.solve(static_cast<std::int32_t>(leaf), lanes, out);
        roots.clear();
        EXPECT_TRUE(made.set.all_roots(static_cast<std::int32_t>(leaf), ray, roots));
        const bool is_one = out.one & 1u, is_none = out.none & 1u;
        EXPECT_TRUE(!is_none || roots.empty()) << describe(ray);
        EXPECT_TRUE(!is_one || roots.size() == 1) << describe(ray);
        if (!roots.empty()) continue;
        ++misses;
        found.clear();
        proven += is_none ||
                  (made.set.open_roots(static_cast<std::int32_t>(leaf), lanes, found) == 0 && found.empty());
      }
    }
  }
  EXPECT_GT(misses, 1000);
  EXPECT_GT(proven, 0.98 * misses);
}

// Counts the leaves whose search is given up.
int given_up(const PatchSet& set, const Ray& ray, std::size_t& roots) {
  int count = 0;
  std::vector<Root> found;
  for (std::size_t k = 0; k < set.leaves().size(); ++k)
    count += !set.all_roots(static_cast<std::int32_t>(k), ray, found);
  for (const Root& r : found) EXPECT_TRUE(std::isfinite(r.t));
  roots = found.size();
  return count;
}

TEST(PatchSearch, ARayInsideAFlatPatchCrossesItNowhere) {
  std::mt19937 rng(15);
  for (const bool rational : {false, true}) {
    Net net = random_net(rng, 3, 3, 0.0, rational);
    const Made made(as_face(net));
    std::size_t roots = 0;
    EXPECT_EQ(given_up(made.set, {{-1.0, 0.4, 0.0}, glm::normalize(dvec3(1.0, 0.1, 0.0))}, roots), 0);
    EXPECT_EQ(roots, 0u);
  }
}

TEST(PatchSearch, ARayInsideACurvedPatchEndsAndSaysSo) {
  // z = x y over the square turned by 45 degrees: no ruling runs along u or v, and x = 0.37 is one.
  Net net{2, 2, {}};
  const auto at = [](double s, double t) { return dvec2(0.5 + (s - t) / 2, (s + t) / 2); };
  for (int i = 0; i <= 2; ++i)
    for (int j = 0; j <= 2; ++j) {
      const dvec2 p = at(i / 2.0, j / 2.0);
      // Blossom of x y: with x = 1/2 + (s - t) / 2 and y = (s + t) / 2, x y = (s + t) / 4 + (s^2 - t^2) / 4.
      const double ss = i == 2 ? 1.0 : 0.0, tt = j == 2 ? 1.0 : 0.0;
      net.h.push_back(dvec4(p.x, p.y, (i / 2.0 + j / 2.0) / 4 + (ss - tt) / 4, 1.0));
    }
  const Made made(as_face(net));
  const double x = 0.37;
  EXPECT_NEAR(point(net, 0.3, 0.6).z, point(net, 0.3, 0.6).x * point(net, 0.3, 0.6).y, 1e-15);
  const dvec3 d = glm::normalize(dvec3(0.0, 1.0, x));
  std::size_t roots = 0;
  EXPECT_GT(given_up(made.set, {dvec3(x, 0.0, 0.0) - 2.0 * d, d}, roots), 0);
}

}  // namespace
}  // namespace trimray::trace
