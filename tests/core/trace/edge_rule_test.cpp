#include "core/trace/edge_rule.h"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include "tests/core/trace/edge_rule_solid.h"

namespace trimray::trace {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(EdgeRule, BoxWithExactTrimsIsEven) {
  std::mt19937_64 rng(1);
  expect_even(Solid(box_solid({-1, -2, 0}, {1, 1, 3}, 0.0, rng)), 40000, 1, {0, 2});
}

TEST(EdgeRule, BoxWithGapsAndOverlapsIsEven) {
  std::mt19937_64 rng(2);
  for (const double noise : {1e-6, 1e-3}) {
    const Solid solid(box_solid({-1, -2, 0}, {1, 1, 3}, noise, rng));
    expect_even(solid, 40000, 2, {0, 2});
  }
}

TEST(EdgeRule, SlantedPolyhedraAreEven) {
  std::mt19937_64 rng(3);
  for (int round = 0; round < 4; ++round) {
    std::vector<dvec3> tetra{{0, 0, 0}, {2, 0.1, 0}, {0.3, 2, 0.2}, {0.5, 0.4, 1.7}};
    for (dvec3& p : tetra) p += 0.2 * random_direction(rng) + (round > 1 ? dvec3(1e4, -3e4, 2e4) : dvec3(0));
    // Far from the origin the coordinates themselves carry 1e-11, so the band must cover it.
    const Solid solid(
        polyhedron(tetra, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, round % 2 ? 1e-3 : 1e-9, rng));
    expect_even(solid, 15000, 10 + round, {0, 2});
  }
}

TEST(EdgeRule, CappedCylinderIsEven) {
  for (const double gap : {0.0, 1e-9, 1e-3, -1e-3}) {
    const Solid solid(capped_cylinder(1.5, 4.0, gap));
    expect_even(solid, 20000, 20, {0, 2});
  }
}

// Against closed forms: winding = leaving - entering roots inside the rectangle, away from the edges.
TEST(EdgeRule, WindingCountsSignedHits) {
  std::mt19937_64 rng(5);
  const nurbs::Frame3 frame{{1, 2, 3}, {1, 1, 0}, {0.2, -0.1, 1}};
  const Box2 part{dvec2(0.3, -0.7), dvec2(4.9, 1.1)};
  std::vector<nurbs::FaceSpec> specs;
  for (const bool reversed : {false, true}) {
    specs.push_back({nurbs::make_plane(frame), {dvec2(-1, -2), dvec2(2, 1)}, reversed});
    specs.push_back({nurbs::make_cylinder(frame, 1.3), {dvec2(0, -1), dvec2(2 * kPi, 2)}, reversed});
    specs.push_back({nurbs::make_cylinder(frame, 1.3), part, reversed});
  }
  for (const nurbs::FaceSpec& spec : specs) {
    const Solid solid(nurbs::make_store(std::span(&spec, 1)));
    int nonzero = 0;
    for (int i = 0; i < 20000; ++i) {
      const Ray ray = line_through(frame.location + 2.0 * random_direction(rng), random_direction(rng));
      std::vector<NearEdge> near;
      solid.rule.near_edges(ray, near);
      if (!near.empty()) continue;
      int sum = 0;
      for (const Root& r : closed_form_roots(solid.store, 0, ray))
        if (solid.trims.inside(0, solid.trims.wrap(0, r.uv_face))) sum += r.sign;
      ASSERT_EQ(solid.rule.winding(ray, 0), sum);
      nonzero += sum != 0;
    }
    EXPECT_GT(nonzero, 500);
  }
}

// Spheres: a point projects into the spherical rectangle's boundary as often as signed roots lie on the
// patch.
TEST(EdgeRule, WindingOfSpherePatchesWithSeamsAndPoles) {
  std::mt19937_64 rng(6);
  const Box2 boxes[] = {{dvec2(0, -kPi / 2), dvec2(2 * kPi, kPi / 2)},  // all of it
                        {dvec2(0, 0.4), dvec2(2 * kPi, kPi / 2)},       // a cap with pole and seam
                        {dvec2(0, -0.5), dvec2(2 * kPi, 0.8)},          // a band with a seam
                        {dvec2(0.5, -kPi / 2), dvec2(2.5, kPi / 2)},    // from pole to pole
                        {dvec2(-0.4, -0.3), dvec2(0.9, 1.2)}};
  for (const Box2& box : boxes) {
    const nurbs::FaceSpec spec{nurbs::make_sphere({}, 2.0), box};
    const nurbs::NurbsStore store = nurbs::make_store(std::span(&spec, 1));
    const EdgeRule rule(store, 0);
    for (int i = 0; i < 20000; ++i) {
      const Ray ray =
          line_through(1.9 * std::cbrt((i % 100) / 100.0) * random_direction(rng), random_direction(rng));
      std::vector<NearEdge> near;
      rule.near_edges(ray, near);
      if (!near.empty()) continue;
      const double b = glm::dot(ray.org, ray.dir), root = std::sqrt(b * b - glm::dot(ray.org, ray.org) + 4.0);
      int sum = 0;
      for (const int sign : {-1, 1}) {
        const dvec3 p = ray.org + (-b + sign * root) * ray.dir;
        double u = std::atan2(p.y, p.x);
        if (u < box.lower.x) u += 2 * kPi;
        const double v = std::asin(p.z / 2.0);
        if (u > box.lower.x && u < box.upper.x && v > box.lower.y && v < box.upper.y) sum += sign;
      }
      ASSERT_EQ(rule.winding(ray, 0), sum);
    }
  }
}

TEST(EdgeRule, NearEdgesFindsEveryPassWithinTheBand) {
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const nurbs::NurbsStore store = capped_cylinder(1.5, 4.0, 0.01);  // band 0.04
  const EdgeRule rule(store, 0);
  const double band = store.edges[0].band;
  int found = 0;
  for (int i = 0; i < 20000; ++i) {
    // A place on the upper rim, and a line that passes it at a known distance, at right angles to the rim.
    const double a = 2 * kPi * unit(rng), distance = 2.0 * band * unit(rng);
    const dvec3 rim(1.5 * std::cos(a), 1.5 * std::sin(a), 4.0), tangent(-std::sin(a), std::cos(a), 0.0);
    const dvec3 dir = glm::normalize(glm::cross(tangent, random_direction(rng)));
    const Ray ray = line_through(rim + distance * glm::cross(tangent, dir), dir);
    std::vector<NearEdge> near;
    rule.near_edges(ray, near);
    const NearEdge* here = nullptr;
    for (const NearEdge& n : near) {
      EXPECT_LE(n.distance, band);
      if (n.edge == 1 && std::abs(n.t - 10.0) < 3.0 * band) here = &n;
    }
    if (distance < 0.999 * band) {
      ASSERT_NE(here, nullptr);
      EXPECT_LE(here->distance, distance + 1e-12);  // closest approach
      ++found;
    } else if (distance > 1.02 * band && std::abs(dir.z) > 0.2) {
      EXPECT_EQ(here, nullptr);  // the rim bends away by less than distance^2 / radius
    }
  }
  EXPECT_GT(found, 9000);
}

TEST(EdgeRule, NearEdgesKeepsToTheRaysRange) {
  const nurbs::NurbsStore store = capped_cylinder(1.5, 4.0, 0.0);
  const EdgeRule rule(store, 0);
  Ray ray = line_through({1.5, 0, 4}, {1, 0, 0});  // passes the rim at t = 7 and t = 10
  const auto count = [&](double tmin, double tmax) {
    std::vector<NearEdge> near;
    ray.tmin = tmin, ray.tmax = tmax;
    rule.near_edges(ray, near);
    std::set<int> places;
    for (const NearEdge& n : near) places.insert(static_cast<int>(std::lround(n.t)));
    return places;
  };
  EXPECT_EQ(count(-kInf, kInf), (std::set<int>{7, 10}));
  EXPECT_EQ(count(0, 9.9), (std::set<int>{7}));
  EXPECT_EQ(count(7.1, kInf), (std::set<int>{10}));
  EXPECT_TRUE(count(7.1, 9.9).empty());
  EXPECT_TRUE(count(20, kInf).empty());
}

// A hit that no root can give: it stands on the edge, with the surface's own uv and normal.
TEST(EdgeRule, ResolvePutsAHitOnTheEdge) {
  const Solid solid(capped_cylinder(1.5, 4.0, 1e-3));
  // Just outside the side's surface, within the cap's rim by the path's roundness: the side has no roots
  // here.
  for (const double a : {0.3, 2.0, 4.4}) {
    const dvec3 rim(1.5 * std::cos(a), 1.5 * std::sin(a), 4.0), tangent(-std::sin(a), std::cos(a), 0.0);
    const Ray ray =
        line_through(rim + 1e-4 * dvec3(std::cos(a), std::sin(a), 0), tangent + dvec3(0, 0, 1e-4));
    std::vector<NearEdge> near;
    solid.rule.near_edges(ray, near);
    ASSERT_FALSE(near.empty());
    std::vector<Root> roots;
    const int wanted = solid.rule.winding(ray, 1);
    solid.rule.resolve(ray, 1, near, roots);
    int sum = 0;
    for (const Root& r : roots) {
      sum += r.sign;
      EXPECT_TRUE(r.inside);
      const nurbs::SurfacePoint s =
          nurbs::evaluate(solid.store, solid.store.surfaces[solid.store.faces[1].surface], r.uv_face);
      EXPECT_LT(glm::length(s.p - (ray.org + r.t * ray.dir)), 2.0 * solid.store.edges[1].band);
      EXPECT_NEAR(r.normal.z, 1.0, 1e-12);
    }
    EXPECT_EQ(sum, wanted);
  }
}

}  // namespace
}  // namespace trimray::trace
