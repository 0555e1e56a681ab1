// The check of a mesh.
#include <cstring>

#include "core/base/error.h"
#include "core/bind/bind.h"
#include "core/tess/mesh_check.h"

namespace trimray::bind {

namespace {

nb::typed<nb::dict, nb::str, nb::any> check_mesh(const In2<double, 3>& vertices,
                                                 const In2<std::int32_t, 3>& triangles) {
  static_assert(sizeof(dvec3) == 3 * sizeof(double));
  tess::MeshCheck c;
  {
    const std::span points(reinterpret_cast<const dvec3*>(vertices.data()), vertices.shape(0));
    const std::span corners(reinterpret_cast<const std::array<std::int32_t, 3>*>(triangles.data()),
                            triangles.shape(0));
    nb::gil_scoped_release release;
    c = tess::check(points, corners);
  }
  nb::dict d;
  d["open_edges"] = c.open_edges, d["non_manifold_edges"] = c.non_manifold_edges;
  d["non_manifold_vertices"] = c.non_manifold_vertices;
  d["degenerate_triangles"] = c.degenerate_triangles;
  d["volume"] = c.volume, d["area"] = c.area;
  return d;
}

}  // namespace

void bind_mesh_check(nb::module_& m) {
  m.def("check_mesh", &check_mesh, nb::arg("vertices"), nb::arg("triangles"),
        "Open and non-manifold edges, non-manifold vertices, degenerate triangles, volume (mm^3) and area "
        "(mm^2) of the mesh. ArgumentError: a triangle names a vertex that does not exist.");
}

}  // namespace trimray::bind
