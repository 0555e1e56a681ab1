#include <cstdio>
#include <ctime>
#include <map>

#include "core/nurbs/trim_bezier.h"
#include "tests/core/trace/edge_rule_solid.h"

namespace trimray::trace {
namespace {

constexpr double kPi = std::numbers::pi;

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
      for (int f = 0; f < 2; ++f)
        plain += solid.trims.inside(f, closed_form_roots(solid.store, f, ray)[0].uv_face);
      plain_misses += plain == 0, plain_doubles += plain == 2;
      // The second face of a polyhedron is stored reversed, so its outward normal is (0, 0, 1) like the
      // first's.
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

// A square with a curved hole, and the piece that fills the hole: a line meets one of the two, wherever it
// passes the curve, whichever way the file runs the hole's loop and however rough both p-curves are.
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
    for (const dvec3 p : {dvec3(-2, -2, 0), dvec3(2, -2, 0), dvec3(2, 2, 0), dvec3(-2, 2, 0)})
      maker.vertex(p);
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
      for (int k = 1; k < degree; ++k)
        c.push_back((rational ? 1.5 + unit(rng) : 1.0) * dvec4(ring(i * degree + k), 1));
      c.push_back(dvec4(maker.store.vertices[v1].point, 1));
      curves.push_back(c);
      rims.push_back(maker.edge(v0, v1, {c}));
    }
    const auto rough = [&](std::vector<dvec4> c, bool reversed) {
      if (reversed) std::reverse(c.begin(), c.end());
      std::vector<dvec3> out;
      for (const dvec4& h : c)
        out.push_back({h.x + noise * h.w * unit(rng), h.y + noise * h.w * unit(rng), h.w});
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
      outer.push_back({edges[i],
                       false,
                       {rough({dvec4(maker.store.vertices[i].point, 1),
                               dvec4(maker.store.vertices[(i + 1) % 4].point, 1)},
                              false)}});
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
      for (int f = 0; f < 2; ++f)
        uv_only += solid.trims.inside(f, closed_form_roots(solid.store, f, ray)[0].uv_face);
      ++plain[uv_only];
      const Solid::Outcome out = solid.cast(ray);
      ASSERT_EQ(out.hits.size(), 1u) << round << " " << i;
      EXPECT_EQ(out.hits[0].sign, dir.z > 0 ? 1 : -1);
    }
  }
  EXPECT_GT(plain[0], 1000);
  EXPECT_GT(plain[2], 1000);
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
    std::printf("%-16s %7.1f ns (%lld)\n", what, ns / (repeat * static_cast<double>(rays.size())),
                static_cast<long long>(sum));
    return sum;
  };
  EXPECT_EQ(time("near_edges, miss", 5,
                 [&](const Ray& r) {
                   rule.near_edges(r, near);
                   return 0;
                 }),
            0);
  time("may_be_near", 5, [&](const Ray& r) { return static_cast<int>(rule.may_be_near(r)); });
  const auto sum = time("winding", 5, [&](const Ray& r) { return rule.winding(r, 17); });
  EXPECT_EQ(time("winding again", 5, [&](const Ray& r) { return rule.winding(r, 17); }), sum);
}

}  // namespace
}  // namespace trimray::trace
