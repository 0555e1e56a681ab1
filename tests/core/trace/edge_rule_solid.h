// A solid of planes and cylinders, cast with the trim loops and the edge rule as the tracer does it.
#pragma once

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "core/nurbs/trim.h"
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

}  // namespace trimray::trace
