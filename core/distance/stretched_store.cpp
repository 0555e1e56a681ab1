#include "core/distance/stretched_store.h"

#include <cmath>
#include <utility>

#include "core/nurbs/surface_form.h"

namespace trimray::distance {

bool stretch_prototype(const nurbs::NurbsStore& store, std::int32_t prototype, const Transform& placement,
                       nurbs::NurbsStore& out) {
  const double determinant = glm::determinant(placement.linear);
  if (!(std::abs(determinant) > 1e-30) || !std::isfinite(determinant)) return false;
  out = store;
  const nurbs::Prototype& p = out.prototypes[prototype];
  const auto place = [&](dvec4& h) {
    const dvec3 q = placement.linear * dvec3(h) + h.w * placement.translation;
    h = dvec4(q, h.w);
  };
  const auto place_pieces = [&](const nurbs::Range& pieces) {
    for (std::int32_t i = pieces.begin; i < pieces.end; ++i)
      for (std::int32_t k = out.edge_pieces[i].ctrl.begin; k < out.edge_pieces[i].ctrl.end; ++k)
        place(out.edge_ctrl_h[k]);
  };
  for (std::int32_t v = p.vertices.begin; v < p.vertices.end; ++v)
    out.vertices[v].point = placement.point(out.vertices[v].point);
  for (std::int32_t e = p.edges.begin; e < p.edges.end; ++e) place_pieces(out.edges[e].pieces);
  std::vector<char> placed(out.surfaces.size(), 0), moved(out.mesh_vertices.size(), 0);
  for (std::int32_t f = p.faces.begin; f < p.faces.end; ++f) {
    nurbs::Face& face = out.faces[f];
    for (std::int32_t t = face.triangles.begin; t < face.triangles.end; ++t)
      for (const std::int32_t v : out.mesh_triangles[t])
        if (!std::exchange(moved[v], 1)) out.mesh_vertices[v] = placement.point(out.mesh_vertices[v]);
    if (face.surface < 0 || face.is_mesh()) continue;
    nurbs::Surface& surface = out.surfaces[face.surface];
    if (surface.kind == nurbs::SurfaceKind::kOffset) {
      face.status = nurbs::FaceStatus::kUnsupported;
    } else if (!std::exchange(placed[face.surface], 1)) {
      if (nurbs::has_closed_form(surface.kind)) surface.kind = nurbs::SurfaceKind::kBspline;
      for (std::int32_t k = surface.ctrl.begin; k < surface.ctrl.end; ++k) place(out.ctrl_h[k]);
    }
  }
  Box3 bounds;
  const Box3& old = store.prototypes[prototype].bounds;
  for (int corner = 0; corner < 8 && !old.empty(); ++corner)
    bounds.add(
        placement.point({(corner & 1 ? old.upper : old.lower).x, (corner & 2 ? old.upper : old.lower).y,
                         (corner & 4 ? old.upper : old.lower).z}));
  out.prototypes[prototype].bounds = bounds;
  return true;
}

}  // namespace trimray::distance
