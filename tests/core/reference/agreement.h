// Rays that are hard to agree on, and the comparison of the fast tracer with the reference.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "core/base/tolerance.h"
#include "core/nurbs/surface.h"
#include "core/reference/model.h"
#include "core/trace/scene.h"

namespace trimray::reference_test {

struct RayMaker {
  const nurbs::NurbsStore& store;
  Box3 box;  // of the world
  double diagonal = 1.0;
  std::mt19937_64 engine;

  RayMaker(const nurbs::NurbsStore& s, unsigned seed) : store(s), engine(seed) {
    for (const nurbs::Instance& instance : s.instances) {
      const Box3& b = s.prototypes[instance.prototype].bounds;
      for (int k = 0; k < 8 && !b.empty(); ++k)
        box.add(instance.placement.point(
            {k & 1 ? b.upper.x : b.lower.x, k & 2 ? b.upper.y : b.lower.y, k & 4 ? b.upper.z : b.lower.z}));
    }
    diagonal = box.diagonal();
  }

  double unit() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine); }
  dvec3 direction() {
    std::normal_distribution<double> normal;
    return glm::normalize(dvec3(normal(engine), normal(engine), normal(engine)));
  }
  const nurbs::Instance& instance() { return store.instances[engine() % store.instances.size()]; }
  trace::Ray through(const dvec3& p, const dvec3& d) { return {p - 2.0 * diagonal * d, d, 0.0, kInf}; }
  double small() { return diagonal * std::pow(10.0, -10.0 + 7.0 * unit()); }

  trace::Ray random() {
    const dvec3 p = box.lower + box.extent() * dvec3(unit(), unit(), unit());
    // Every fourth one along an axis: seen flat on, as drawings are.
    dvec3 d = direction();
    if (engine() % 4 == 0) d = dvec3(0.0), d[engine() % 3] = engine() % 2 ? 1.0 : -1.0;
    return through(p, d);
  }

  // At a point of an edge's path or at a vertex, a little beside it.
  trace::Ray at_edge() {
    const nurbs::Instance& placed = instance();
    const nurbs::Range edges = store.prototypes[placed.prototype].edges;
    if (edges.size() == 0) return random();
    const reference::EdgePath path =
        reference::edge_path(store, edges.begin + static_cast<std::int32_t>(engine() % edges.size()));
    if (path.curves.empty()) return random();
    std::vector<dvec4> c = path.curves[engine() % path.curves.size()];
    const double x = engine() % 8 == 0 ? 0.0 : unit();
    for (std::size_t r = 1; r < c.size(); ++r)
      for (std::size_t i = 0; i + r < c.size(); ++i) c[i] = (1.0 - x) * c[i] + x * c[i + 1];
    return through(placed.placement.point(dvec3(c[0]) / c[0].w) + small() * direction(), direction());
  }

  // At a corner or a point of a side of a triangle, exactly or a little beside it.
  trace::Ray at_corner(const nurbs::Instance& placed, const nurbs::Face& face) {
    const auto count = static_cast<std::uint64_t>(face.triangles.size());
    const nurbs::Triangle& t =
        store.mesh_triangles[face.triangles.begin + static_cast<std::int32_t>(engine() % count)];
    const double x = engine() % 2 ? unit() : 0.0;
    dvec3 p = (1.0 - x) * store.mesh_vertices[t[0]] + x * store.mesh_vertices[t[1]];
    if (engine() % 2) p += small() * direction();
    return through(placed.placement.point(p), direction());
  }

  // Along a tangent of a surface, a little above or below it.
  trace::Ray at_silhouette() {
    const nurbs::Instance& placed = instance();
    const nurbs::Range faces = store.prototypes[placed.prototype].faces;
    const nurbs::Face& face = store.faces[faces.begin + static_cast<std::int32_t>(engine() % faces.size())];
    if (face.status != nurbs::FaceStatus::kOk) return random();
    if (face.is_mesh()) return at_corner(placed, face);
    const dvec2 uv = face.uv_box.lower + face.uv_box.extent() * dvec2(unit(), unit());
    const nurbs::SurfacePoint s = nurbs::evaluate(store, store.surfaces[face.surface], uv);
    const dvec3 n = glm::cross(s.du, s.dv);
    if (!(glm::length(n) > 1e-9 * glm::length(s.du) * glm::length(s.dv))) return random();
    const double turn = 6.2831853 * unit();
    const dvec3 d = std::cos(turn) * glm::normalize(s.du) + std::sin(turn) * glm::normalize(s.dv);
    const double gap = diagonal * std::pow(10.0, -7.0 + 5.0 * unit()) * (engine() % 2 ? 1.0 : -1.0);
    return through(placed.placement.point(s.p + gap * glm::normalize(n)),
                   glm::normalize(placed.placement.vector(d)));
  }
};

// Empty when both tracers say the same: equally many hits, the same faces, |dt| within kHitTol of the
// diagonal. Hits that lie closer together than that may stand in another order.
inline std::string difference(std::vector<trace::Hit> fast, std::vector<trace::Hit> slow, double diagonal) {
  const double same = kHitTol * diagonal;
  std::string text;
  auto list = [&](const char* name, const std::vector<trace::Hit>& hits) {
    text += std::string("  ") + name + ":";
    char line[200];
    for (const trace::Hit& h : hits) {
      std::snprintf(line, sizeof line, " [t %.12g face %d inst %d uv %.9g %.9g n %.3g %.3g %.3g]", h.t,
                    h.face, h.instance, h.uv_face.x, h.uv_face.y, h.normal.x, h.normal.y, h.normal.z);
      text += line;
    }
    text += "\n";
  };
  bool equal = fast.size() == slow.size();
  std::vector<char> used(slow.size(), 0);
  for (const trace::Hit& f : fast) {
    bool found = false;
    for (std::size_t k = 0; k < slow.size() && !found; ++k) {
      if (used[k] || slow[k].face != f.face || slow[k].instance != f.instance ||
          !(std::abs(slow[k].t - f.t) <= same))
        continue;
      used[k] = 1, found = true;
    }
    equal = equal && found;
  }
  if (equal) return {};
  list("fast", fast), list("slow", slow);
  return text;
}

}  // namespace trimray::reference_test
