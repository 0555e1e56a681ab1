// Meshes of a store's prototypes.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "core/base/error.h"
#include "core/bind/bind.h"
#include "core/tess/tessellate.h"

namespace trimray::bind {

namespace {

// vertices (n, 3), triangles (m, 3), corner_uv (m, 3, 2), face (m,), deviation (m,).
using MeshArrays = std::tuple<Out<double>, Out<std::int32_t>, Out<double>, Out<std::int32_t>, Out<double>>;
using Issues = std::vector<std::pair<std::int32_t, std::string>>;

MeshArrays mesh_arrays(tess::TriMesh&& mesh) {
  const std::size_t n = mesh.vertices.size(), m = mesh.triangles.size();
  std::vector<double> vertices, uv;
  std::vector<std::int32_t> triangles;
  vertices.reserve(3 * n), uv.reserve(6 * m), triangles.reserve(3 * m);
  for (const dvec3& v : mesh.vertices) vertices.insert(vertices.end(), {v.x, v.y, v.z});
  for (const auto& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  for (const auto& t : mesh.corner_uv)
    for (const dvec2& p : t) uv.insert(uv.end(), {p.x, p.y});
  return {array(std::move(vertices), {n, 3}), array(std::move(triangles), {m, 3}),
          array(std::move(uv), {m, 3, 2}), array(std::move(mesh.face), {m}),
          array(std::move(mesh.deviation), {m})};
}

std::pair<MeshArrays, Issues> tessellate(const nurbs::NurbsStore& store, std::int32_t prototype,
                                         double deviation, double angle, int threads) {
  if (prototype < 0 || prototype >= static_cast<std::int32_t>(store.prototypes.size()))
    throw ArgumentError("no prototype " + std::to_string(prototype));
  if (!(deviation > 0.0)) throw ArgumentError("deviation must be above 0");
  if (!(angle > 0.0)) throw ArgumentError("angle must be above 0");
  tess::Tessellation t;
  {
    nb::gil_scoped_release release;
    t = tess::tessellate(store, prototype, tess::UniformTolerance(deviation),
                         {.angle = angle, .threads = threads});
  }
  Issues issues;
  for (const tess::TessIssue& issue : t.issues) issues.push_back({issue.face, issue.reason});
  return {mesh_arrays(std::move(t.mesh)), std::move(issues)};
}

}  // namespace

void bind_tess(nb::module_& m) {
  m.def("tessellate", &tessellate, nb::arg("store"), nb::arg("prototype"), nb::arg("deviation"),
        nb::arg("angle"), nb::arg("threads") = 0,
        "Watertight mesh of a prototype, deviation in mm (inf: the model's turns alone), angle in rad (inf: "
        "none): "
        "(vertices (n, 3), triangles (m, 3), corner_uv (m, 3, 2), face (m,), deviation (m,)) and "
        "[(face, why nothing is proven)].");
}

}  // namespace trimray::bind
