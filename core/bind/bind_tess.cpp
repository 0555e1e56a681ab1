// Meshes of a store's prototypes.
#include "core/base/error.h"
#include "core/bind/mesh_arrays.h"
#include "core/tess/tessellate.h"

namespace trimray::bind {

namespace {

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
  return {mesh_arrays(t.mesh), issues_of(t)};
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
