#include "core/trace/edge_rule.h"

#include <cstdio>
#include <ctime>
#include <set>

#include <gtest/gtest.h>

#include "core/nurbs/trim.h"
#include "core/nurbs/trim_bezier.h"
#include "tests/core/trace/edge_rule_stores.h"

namespace trimray::trace {
namespace {

constexpr double kPi = std::numbers::pi;

dvec3 random_direction(std::mt19937_64& rng) {
  std::normal_distribution<double> n;
  const double x = n(rng), y = n(rng), z = n(rng);
  return glm::normalize(dvec3(x, y, z));
}

// The whole line through a point, from far away.
Ray line_through(dvec3 point, dvec3 dir) {
  Ray ray;
  ray.dir = glm::normalize(dir);
  ray.org = point - 10.0 * ray.dir;
  ray.tmin = -kInf;
  return ray;
}

// A solid as the tracer sees it: closed-form roots, the p-curves' test, then the edge rule for near faces.
struct Solid {
  explicit Solid(nurbs::NurbsStore s) : store(std::move(s)), trims(store, 1), rule(store, 0) {}
  nurbs::NurbsStore store;
  nurbs::TrimIndex trims;
  EdgeRule rule;

  struct Outcome {
    std::vector<Root> hits;      // sorted by t
    int sum = 0, changed = 0;    // of signs; faces that the rule looked at
  };
  Outcome cast(const Ray& ray) const {
    Outcome out;
    std::vector<NearEdge> near;
    rule.near_edges(ray, near);
    EXPECT_TRUE(near.empty() || rule.may_be_near(ray));
    std::set<std::int32_t> near_faces;
    for (const NearEdge& n : near)
      for (std::int32_t c = store.edges[n.edge].coedges.begin; c < store.edges[n.edge].coedges.end; ++c)
        near_faces.insert(store.coedges[store.edge_coedges[c]].face);
    for (std::int32_t f = 0; f < size_of(store.faces); ++f) {
      std::vector<Root> roots = closed_form_roots(store, f, ray);
      for (Root& r : roots) r.inside = trims.inside(f, r.uv_face = trims.wrap(f, r.uv_face));
      if (near_faces.count(f)) {
        rule.resolve(ray, f, near, roots);
        ++out.changed;
      }
      int sum = 0;
      for (const Root& r : roots) {
        if (!r.inside) continue;
        sum += r.sign;
        out.hits.push_back(r);
      }
      EXPECT_EQ(sum, rule.winding(ray, f)) << "face " << f;
      out.sum += sum;
    }
    std::sort(out.hits.begin(), out.hits.end(), [](const Root& a, const Root& b) { return a.t < b.t; });
    return out;
  }
};

// Rays aimed at points of edges and at vertices with offsets from nothing to a band, in all directions and
// along axes and edges. hits: what a line may count on this solid.
void expect_even(const Solid& solid, int rays, std::uint64_t seed, const std::set<std::size_t>& hits) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double offsets[] = {0.0, 0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3};
  std::map<std::size_t, int> counts;
  for (int i = 0; i < rays; ++i) {
    const nurbs::Edge& edge = solid.store.edges[rng() % solid.store.edges.size()];
    dvec3 target = solid.store.vertices[edge.vertex[rng() % 2]].point;
    if (i % 3) {
      const nurbs::CurvePiece& piece = solid.store.edge_pieces[edge.pieces.begin + rng() % edge.pieces.size()];
      const dvec4* c = &solid.store.edge_ctrl_h[piece.ctrl.begin];
      const double t = i % 5 ? unit(rng) : 0.5;
      const dvec4 h = piece.ctrl.size() == 2 ? c[0] * (1 - t) + c[1] * t
                                             : c[0] * (1 - t) * (1 - t) + c[1] * 2.0 * t * (1 - t) + c[2] * t * t;
      target = dvec3(h) / h.w;
    }
    target += offsets[rng() % std::size(offsets)] * random_direction(rng);
    dvec3 dir = random_direction(rng);
    if (i % 7 == 0) dir = dvec3((i % 21) / 7 == 0, (i % 21) / 7 == 1, (i % 21) / 7 == 2);
    if (i % 11 == 0) dir = dvec3(dir.x, dir.y, 0.0);
    if (i % 13 == 0) dir = solid.store.vertices[rng() % solid.store.vertices.size()].point - target;
    if (!(glm::length(dir) > 1e-2)) continue;
    const Solid::Outcome out = solid.cast(line_through(target, dir));
    EXPECT_EQ(out.sum, 0);
    EXPECT_EQ(out.hits.size() % 2, 0u) << i;
    ++counts[out.hits.size()];
    for (std::size_t k = 0; k + 1 < out.hits.size(); k += 2)
      EXPECT_NE(out.hits[k].sign, out.hits[k + 1].sign);
  }
  for (const auto& [count, times] : counts) EXPECT_TRUE(hits.count(count)) << count << " hits, " << times << " times";
}

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
    const Solid solid(polyhedron(tetra, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, round % 2 ? 1e-3 : 1e-9, rng));
    expect_even(solid, 15000, 10 + round, {0, 2});
  }
}

TEST(EdgeRule, CappedCylinderIsEven) {
  for (const double gap : {0.0, 1e-9, 1e-3, -1e-3}) {
    const Solid solid(capped_cylinder(1.5, 4.0, gap));
    expect_even(solid, 20000, 20, {0, 2});
  }
}

// Two squares of one plane that stop short of their common edge, or overlap: a line through it meets one.
TEST(EdgeRule, ARayThroughAGapHitsOneFace) {
  std::mt19937_64 rng(4);
  std::uniform_real_distribution<double> unit(-0.9, 0.9);
  int plain_misses = 0, plain_doubles = 0;
  for (int round = 0; round < 200; ++round) {
    const Solid solid(polyhedron({{-1, -1, 0}, {0, -1, 0}, {1, -1, 0}, {1, 1, 0}, {0, 1, 0}, {-1, 1, 0}},
                                 {{0, 1, 4, 5}, {1, 2, 3, 4}}, 1e-3, rng));
    for (int i = 0; i < 100; ++i) {
      const dvec3 target(0.002 * unit(rng), unit(rng), 0.0);
      dvec3 dir = random_direction(rng);
      if (std::abs(dir.z) < 1e-2) continue;
      const Ray ray = line_through(target, dir);
      int plain = 0;
      for (int f = 0; f < 2; ++f) plain += solid.trims.inside(f, closed_form_roots(solid.store, f, ray)[0].uv_face);
      plain_misses += plain == 0, plain_doubles += plain == 2;
      // The second face of a polyhedron is stored reversed, so its outward normal is (0, 0, 1) like the first's.
      const Solid::Outcome out = solid.cast(ray);
      ASSERT_EQ(out.hits.size(), 1u);
      EXPECT_EQ(out.hits[0].sign, dir.z > 0 ? 1 : -1);
      EXPECT_NEAR(out.hits[0].t, 10.0, 4e-3 / std::abs(dir.z));
      // Left of the shared line x = 0 it is face 0, whatever the p-curves say.
      if (std::abs(target.x) > 1e-12) {
        EXPECT_EQ(out.hits[0].face, target.x < 0.0 ? 0 : 1);
      }
    }
  }
  EXPECT_GT(plain_misses, 1000);  // there was something to mend
  EXPECT_GT(plain_doubles, 1000);
}

// A square with a curved hole, and the piece that fills the hole: a line meets one of the two, wherever it passes
// the curve, whichever way the file runs the hole's loop and however rough both p-curves are.
TEST(EdgeRule, CurvedPartitionIsHitOnce) {
  std::mt19937_64 rng(9);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::map<std::size_t, int> plain;
  for (int round = 0; round < 60; ++round) {
    const double noise = round % 3 ? 1e-3 : 0.0;
    const int degree = 2 + round % 4, pieces = 3 + round % 3;
    const bool rational = round % 2, wrong_way = round % 4 > 1;
    SolidMaker maker;
    maker.band = std::max(8.0 * noise, 1e-8);
    for (const dvec3 p : {dvec3(-2, -2, 0), dvec3(2, -2, 0), dvec3(2, 2, 0), dvec3(-2, 2, 0)}) maker.vertex(p);
    std::vector<std::int32_t> edges, rims;
    for (int i = 0; i < 4; ++i) edges.push_back(maker.edge(i, (i + 1) % 4));
    const auto ring = [&](int i) {
      const double a = 2 * kPi * i / (pieces * degree), r = 1.0 + 0.3 * unit(rng);
      return dvec3(r * std::cos(a), r * std::sin(a), 0.0);
    };
    std::vector<std::vector<dvec4>> curves;
    for (int i = 0; i < pieces; ++i) maker.vertex(ring(i * degree));
    for (int i = 0; i < pieces; ++i) {
      const std::int32_t v0 = 4 + i, v1 = 4 + (i + 1) % pieces;
      std::vector<dvec4> c{dvec4(maker.store.vertices[v0].point, 1)};
      for (int k = 1; k < degree; ++k) c.push_back((rational ? 1.5 + unit(rng) : 1.0) * dvec4(ring(i * degree + k), 1));
      c.push_back(dvec4(maker.store.vertices[v1].point, 1));
      curves.push_back(c);
      rims.push_back(maker.edge(v0, v1, {c}));
    }
    const auto rough = [&](std::vector<dvec4> c, bool reversed) {
      if (reversed) std::reverse(c.begin(), c.end());
      std::vector<dvec3> out;
      for (const dvec4& h : c) out.push_back({h.x + noise * h.w * unit(rng), h.y + noise * h.w * unit(rng), h.w});
      return out;
    };
    const auto loop = [&](bool reversed) {
      std::vector<SolidMaker::Use> uses;
      for (int i = 0; i < pieces; ++i) {
        const int k = reversed ? pieces - 1 - i : i;
        uses.push_back({rims[k], reversed, {rough(curves[k], reversed)}});
      }
      return uses;
    };
    std::vector<SolidMaker::Use> outer;
    for (int i = 0; i < 4; ++i)
      outer.push_back({edges[i], false,
                       {rough({dvec4(maker.store.vertices[i].point, 1), dvec4(maker.store.vertices[(i + 1) % 4].point, 1)}, false)}});
    maker.face(nurbs::make_plane({}), false, {outer, loop(!wrong_way)});
    maker.face(nurbs::make_plane({}), false, {loop(wrong_way)});
    const Solid solid(maker.finish());
    for (int i = 0; i < 1000; ++i) {
      const dvec4 h = nurbs::evaluate_bezier<dvec4>(curves[i % pieces], 0.5 + 0.5 * unit(rng));
      const double offsets[] = {0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 5e-3, 1e-1};
      const dvec3 target = dvec3(h) / h.w + offsets[i % 8] * dvec3(unit(rng), unit(rng), 0.0);
      dvec3 dir = random_direction(rng);
      if (std::abs(dir.z) < 0.02) continue;
      const Ray ray = line_through(target, dir);
      std::size_t uv_only = 0;
      for (int f = 0; f < 2; ++f) uv_only += solid.trims.inside(f, closed_form_roots(solid.store, f, ray)[0].uv_face);
      ++plain[uv_only];
      const Solid::Outcome out = solid.cast(ray);
      ASSERT_EQ(out.hits.size(), 1u) << round << " " << i;
      EXPECT_EQ(out.hits[0].sign, dir.z > 0 ? 1 : -1);
    }
  }
  EXPECT_GT(plain[0], 1000);
  EXPECT_GT(plain[2], 1000);
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

// Spheres: a point projects into the spherical rectangle's boundary as often as signed roots lie on the patch.
TEST(EdgeRule, WindingOfSpherePatchesWithSeamsAndPoles) {
  std::mt19937_64 rng(6);
  const Box2 boxes[] = {{dvec2(0, -kPi / 2), dvec2(2 * kPi, kPi / 2)},   // all of it
                        {dvec2(0, 0.4), dvec2(2 * kPi, kPi / 2)},        // a cap with pole and seam
                        {dvec2(0, -0.5), dvec2(2 * kPi, 0.8)},           // a band with a seam
                        {dvec2(0.5, -kPi / 2), dvec2(2.5, kPi / 2)},     // from pole to pole
                        {dvec2(-0.4, -0.3), dvec2(0.9, 1.2)}};
  for (const Box2& box : boxes) {
    const nurbs::FaceSpec spec{nurbs::make_sphere({}, 2.0), box};
    const nurbs::NurbsStore store = nurbs::make_store(std::span(&spec, 1));
    const EdgeRule rule(store, 0);
    for (int i = 0; i < 20000; ++i) {
      const Ray ray = line_through(1.9 * std::cbrt((i % 100) / 100.0) * random_direction(rng), random_direction(rng));
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
  // Just outside the side's surface, within the cap's rim by the path's roundness: the side has no roots here.
  for (const double a : {0.3, 2.0, 4.4}) {
    const dvec3 rim(1.5 * std::cos(a), 1.5 * std::sin(a), 4.0), tangent(-std::sin(a), std::cos(a), 0.0);
    const Ray ray = line_through(rim + 1e-4 * dvec3(std::cos(a), std::sin(a), 0), tangent + dvec3(0, 0, 1e-4));
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
      const nurbs::SurfacePoint s = nurbs::evaluate(solid.store, solid.store.surfaces[solid.store.faces[1].surface], r.uv_face);
      EXPECT_LT(glm::length(s.p - (ray.org + r.t * ray.dir)), 2.0 * solid.store.edges[1].band);
      EXPECT_NEAR(r.normal.z, 1.0, 1e-12);
    }
    EXPECT_EQ(sum, wanted);
  }
}

// Prints nanoseconds per call; asserts that answers repeat.
TEST(EdgeRule, Cost) {
  std::mt19937_64 rng(8);
  std::vector<nurbs::FaceSpec> specs;
  for (int i = 0; i < 400; ++i) {
    const nurbs::Frame3 frame{3.0 * random_direction(rng), random_direction(rng), random_direction(rng)};
    specs.push_back(nurbs::tube(frame, 0.15, 0.0, 0.3));
  }
  const nurbs::NurbsStore store = nurbs::make_store(specs);
  const EdgeRule rule(store, 0);
  std::vector<Ray> rays;
  std::vector<NearEdge> near;
  while (rays.size() < 20000) {
    const Ray ray = line_through(3.0 * random_direction(rng), random_direction(rng));
    near.clear();
    rule.near_edges(ray, near);
    if (near.empty()) rays.push_back(ray);
  }
  const auto time = [&](const char* what, int repeat, const auto& call) {
    const std::clock_t start = std::clock();  // of this process, however busy the machine
    std::int64_t sum = 0;
    for (int k = 0; k < repeat; ++k)
      for (const Ray& ray : rays) sum += call(ray);
    const double ns = 1e9 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    std::printf("%-16s %7.1f ns (%lld)\n", what, ns / (repeat * static_cast<double>(rays.size())), static_cast<long long>(sum));
    return sum;
  };
  EXPECT_EQ(time("near_edges, miss", 5, [&](const Ray& r) { rule.near_edges(r, near); return 0; }), 0);
  time("may_be_near", 5, [&](const Ray& r) { return static_cast<int>(rule.may_be_near(r)); });
  const auto sum = time("winding", 5, [&](const Ray& r) { return rule.winding(r, 17); });
  EXPECT_EQ(time("winding again", 5, [&](const Ray& r) { return rule.winding(r, 17); }), sum);
}

}  // namespace
}  // namespace trimray::trace
