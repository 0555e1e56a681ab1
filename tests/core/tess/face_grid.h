// A mesh of a store's only face by a uv grid over its uv_box.
#pragma once

#include <utility>

#include "core/nurbs/surface.h"
#include "tests/core/tess/meshes.h"

namespace trimray::tess {

// wrap_u, wrap_v: the sides of the box meet in space and share their vertices.
inline TriMesh face_grid(const nurbs::NurbsStore& store, int nu, int nv, bool wrap_u, bool wrap_v = false) {
  const Box2 box = store.faces[0].uv_box;
  const auto uv_of = [&](dvec2 ij) { return box.lower + ij / dvec2(nu, nv) * box.extent(); };
  TriMesh mesh = grid(nu, nv, wrap_u, wrap_v, [&](int i, int j) {
    return nurbs::evaluate(store, store.surfaces[0], uv_of(dvec2(i, j))).p;
  });
  for (auto& corners : mesh.corner_uv)
    for (dvec2& uv : corners) uv = uv_of(uv);
  if (store.faces[0].reversed) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
      std::swap(mesh.corner_uv[i][0], mesh.corner_uv[i][1]);
    }
  }
  return mesh;
}

}  // namespace trimray::tess
