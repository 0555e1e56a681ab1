// Rays, stores and searches that the tests of the patch kernel share.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/nurbs/make_store.h"
#include "core/trace/patch.h"

namespace trimray::trace {

// One face as a store and its patches, with a margin of 1e-3 mm.
struct Made {
  nurbs::NurbsStore store;
  PatchSet set;
  explicit Made(const nurbs::FaceSpec& face)
      : store(nurbs::make_store(std::span(&face, 1))), set(make_set()) {}

 private:
  PatchSet make_set() const {
    const double margin = 1e-3;
    return PatchSet(store, 0, std::span(&margin, 1), 1);
  }
};

inline std::string describe(const Ray& r) {
  std::ostringstream s;
  s.precision(17);
  s << "ray " << r.org.x << ", " << r.org.y << ", " << r.org.z << " -> " << r.dir.x << ", " << r.dir.y << ", "
    << r.dir.z;
  return s.str();
}

// Could the line meet the box? A filter for the tests' speed only: generous.
inline bool near_box(const Box3& box, const Ray& ray) {
  return glm::length(glm::cross(box.center() - ray.org, ray.dir)) <= 0.51 * box.diagonal();
}

// All roots of all leaves, deduplicated, sorted.
inline std::vector<Root> every_root(const PatchSet& set, const Ray& ray, double diagonal) {
  std::vector<Root> roots, unique;
  for (std::size_t k = 0; k < set.leaves().size(); ++k)
    if (near_box(set.leaves()[k].box, ray)) set.all_roots(static_cast<std::int32_t>(k), ray, roots);
  std::sort(roots.begin(), roots.end(), [](const Root& a, const Root& b) { return a.t < b.t; });
  for (const Root& r : roots)
    if (std::none_of(unique.begin(), unique.end(), [&](const Root& o) { return same_root(r, o, diagonal); }))
      unique.push_back(r);
  return unique;
}

// Roots as the scene finds them: solve() on every leaf first, all_roots() for what it leaves open.
struct Traced {
  std::vector<Root> roots;
  int one = 0, none = 0, open = 0;  // leaves
  bool complete = true;
};

inline Traced trace_leaves(const PatchSet& set, const Ray& ray, double diagonal) {
  RayLanes lanes;
  for (int k = 0; k < kLanes; ++k) {
    lanes.org_x[k] = ray.org.x, lanes.org_y[k] = ray.org.y, lanes.org_z[k] = ray.org.z;
    lanes.dir_x[k] = ray.dir.x, lanes.dir_y[k] = ray.dir.y, lanes.dir_z[k] = ray.dir.z;
  }
  lanes.active = 1;
  Traced traced;
  std::vector<Root> roots;
  for (std::size_t k = 0; k < set.leaves().size(); ++k) {
    RootLanes out;
    set.solve(static_cast<std::int32_t>(k), lanes, out);
    if (out.none & 1u) {
      ++traced.none;
    } else if (out.one & 1u) {
      ++traced.one;
      Root root;
      root.t = out.t[0], root.uv_face = {out.u[0], out.v[0]};
      root.normal = {out.normal_x[0], out.normal_y[0], out.normal_z[0]};
      root.face = set.leaves()[k].face;
      root.sign = glm::dot(root.normal, ray.dir) > 0.0 ? 1 : -1;
      roots.push_back(root);
    } else {
      ++traced.open;
      traced.complete &= set.all_roots(static_cast<std::int32_t>(k), ray, roots);
    }
  }
  std::sort(roots.begin(), roots.end(), [](const Root& a, const Root& b) { return a.t < b.t; });
  for (const Root& r : roots)
    if (std::none_of(traced.roots.begin(), traced.roots.end(),
                     [&](const Root& o) { return same_root(r, o, diagonal); }))
      traced.roots.push_back(r);
  return traced;
}

// Random lines whose distance from a centre is spread over [0, reach]; a third of them pass a distance
// between 1e-1 and 1e-7 of `rim` within it.
inline Ray random_ray(std::mt19937& rng, const dvec3& center, double reach, double rim) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const dvec3 d = glm::normalize(dvec3(normal(rng), normal(rng), normal(rng)));
  const dvec3 side = glm::normalize(glm::cross(d, dvec3(normal(rng), normal(rng), normal(rng))));
  double distance = reach * uniform(rng);
  if (uniform(rng) < 0.33) distance = rim * (1.0 - std::pow(10.0, -1.0 - 6.0 * uniform(rng)));
  return {center + side * distance - 3.0 * reach * d, d};
}

}  // namespace trimray::trace
