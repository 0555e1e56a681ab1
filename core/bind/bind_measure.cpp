// What benchmarks and verification ask: pure casting time with counters, and points on edges.
#include <array>
#include <chrono>

#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>

#include "core/bind/bind.h"
#include "core/trace/scene.h"

namespace trimray::bind {

namespace {

using nurbs::CurvePiece;
using nurbs::NurbsStore;

// Seconds of Scene::cast alone, and its counters.
nb::typed<nb::dict, nb::str, nb::any> measure_cast(const trace::Scene& scene, const In2<double, 3>& org,
                                                   const In2<double, 3>& dir, int threads) {
  const std::size_t n = std::min(org.shape(0), dir.shape(0));
  std::vector<trace::Ray> rays(n);
  for (std::size_t i = 0; i < n; ++i) {
    rays[i].org = dvec3(org(i, 0), org(i, 1), org(i, 2));
    rays[i].dir = glm::normalize(dvec3(dir(i, 0), dir(i, 1), dir(i, 2)));
  }
  std::vector<trace::Hit> hits(n);
  trace::TraceStats stats;
  double seconds = 0.0;
  {
    nb::gil_scoped_release release;
    const auto start = std::chrono::steady_clock::now();
    scene.cast(rays, hits, threads, &stats);
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  std::int64_t covered = 0;
  for (const trace::Hit& h : hits) covered += h.face != kNoFace;
  nb::dict d;
  d["seconds"] = seconds, d["rays"] = n, d["covered"] = covered;
  d["nodes"] = stats.nodes, d["leaves"] = stats.leaves, d["newton_steps"] = stats.newton_steps;
  d["certified"] = stats.certified, d["fallbacks"] = stats.fallbacks;
  d["trim_tests"] = stats.trim_tests, d["edge_rays"] = stats.edge_rays;
  d["given_up"] = stats.given_up;
  return d;
}

// A point of a rational Bezier piece, x in [0, 1], by de Casteljau.
dvec3 piece_point(const NurbsStore& store, const CurvePiece& piece, double x) {
  std::vector<dvec4> c(store.edge_ctrl_h.begin() + piece.ctrl.begin,
                       store.edge_ctrl_h.begin() + piece.ctrl.end);
  for (std::size_t n = c.size(); n > 1; --n) {
    for (std::size_t i = 0; i + 1 < n; ++i) c[i] = (1.0 - x) * c[i] + x * c[i + 1];
  }
  return dvec3(c[0]) / c[0].w;
}

Out<double> edge_points(const NurbsStore& store, int per_edge) {
  std::vector<double> values;
  const auto add = [&](const Transform& placement, dvec3 p) {
    p = placement.point(p);
    values.insert(values.end(), {p.x, p.y, p.z});
  };
  for (const nurbs::Instance& instance : store.instances) {
    const nurbs::Prototype& part = store.prototypes[instance.prototype];
    for (std::int32_t v = part.vertices.begin; v < part.vertices.end; ++v)
      add(instance.placement, store.vertices[v].point);
    for (std::int32_t e = part.edges.begin; e < part.edges.end; ++e) {
      const nurbs::Range pieces = store.edges[e].pieces;
      for (int k = 0; pieces.size() > 0 && k < per_edge; ++k) {
        const double at = pieces.size() * (k + 0.5) / per_edge;
        const int piece = std::min(static_cast<int>(at), pieces.size() - 1);
        add(instance.placement, piece_point(store, store.edge_pieces[pieces.begin + piece], at - piece));
      }
    }
    for (std::int32_t f = part.faces.begin; f < part.faces.end; ++f) {
      const nurbs::Range triangles = store.faces[f].triangles;
      for (std::int32_t t = triangles.begin; t < triangles.end; ++t) {
        const nurbs::Triangle& corners = store.mesh_triangles[t];
        const dvec3 &a = store.mesh_vertices[corners[0]], &b = store.mesh_vertices[corners[1]];
        add(instance.placement, a), add(instance.placement, 0.5 * (a + b));
      }
    }
  }
  const std::size_t count = values.size() / 3;
  return array(std::move(values), {count, 3});
}

}  // namespace

void bind_measure(nb::module_& m) {
  m.def(
      "near_edge",
      [](const trace::Scene& scene, std::array<double, 3> org, std::array<double, 3> dir, double tmax) {
        const trace::Ray ray{
            {org[0], org[1], org[2]}, glm::normalize(dvec3(dir[0], dir[1], dir[2])), 0.0, tmax};
        return scene.near_edge(ray);
      },
      nb::arg("scene"), nb::arg("org"), nb::arg("dir"), nb::arg("tmax"),
      "Does the ray pass an edge within its band before tmax (mm)?");
  m.def("measure_cast", &measure_cast, nb::arg("scene"), nb::arg("org"), nb::arg("dir"),
        nb::arg("threads") = 0,
        "Seconds of casting alone, without any copying, and the counters of the call.");
  m.def("edge_points", &edge_points, nb::arg("store"), nb::arg("per_edge") = 2,
        "(n, 3) float64, mm, world: every vertex, and per_edge points of every edge, of every instance; of "
        "mesh "
        "faces, a corner and a point on a side of every triangle.");
}

}  // namespace trimray::bind
