// A solid of planes, cylinders, cones and spheres, cast with the trim loops and the edge rule as the tracer
// does it.
#pragma once

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/nurbs/trim.h"
#include "core/nurbs/trim_bezier.h"
#include "core/trace/edge_rule.h"
#include "tests/core/trace/edge_rule_stores.h"

namespace trimray::trace {

inline dvec3 random_direction(std::mt19937_64& rng) {
  std::normal_distribution<double> n;
  const double x = n(rng), y = n(rng), z = n(rng);
  return glm::normalize(dvec3(x, y, z));
}

// The whole line through a point, from far away.
inline Ray line_through(dvec3 point, dvec3 dir) {
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
    std::vector<Root> hits;    // sorted by t
    int sum = 0, changed = 0;  // of signs; faces that the rule looked at
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
// along axes and edges. hits: how many places a line may meet on this solid.
inline void expect_even(const Solid& solid, int rays, std::uint64_t seed, const std::set<std::size_t>& hits) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double offsets[] = {0.0, 0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3};
  std::map<std::size_t, int> counts;
  for (int i = 0; i < rays; ++i) {
    const nurbs::Edge& edge = solid.store.edges[rng() % solid.store.edges.size()];
    dvec3 target = solid.store.vertices[edge.vertex[rng() % 2]].point;
    if (i % 3 && edge.pieces.size() > 0) {
      const nurbs::CurvePiece& piece =
          solid.store.edge_pieces[edge.pieces.begin + rng() % edge.pieces.size()];
      const std::span<const dvec4> ctrl_h(&solid.store.edge_ctrl_h[piece.ctrl.begin],
                                          static_cast<std::size_t>(piece.ctrl.size()));
      const dvec4 h = nurbs::evaluate_bezier<dvec4>(ctrl_h, i % 5 ? unit(rng) : 0.5);
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
    // Through a vertex to the last bit, three of its faces may be met at one point, in and out and in.
    std::vector<Root> apart;
    for (const Root& r : out.hits) {
      if (!apart.empty() && apart.back().sign != r.sign && r.t - apart.back().t < 1e-12 * std::abs(r.t))
        apart.pop_back();
      else
        apart.push_back(r);
    }
    ++counts[apart.size()];
    for (std::size_t k = 0; k + 1 < apart.size(); k += 2) EXPECT_NE(apart[k].sign, apart[k + 1].sign);
  }
  for (const auto& [count, times] : counts)
    EXPECT_TRUE(hits.count(count)) << count << " hits, " << times << " times";
}

}  // namespace trimray::trace
