#include "core/nurbs/bezier.h"

#include "core/nurbs/surface_form.h"

namespace trimray::nurbs {

BezierPatches bezier_patches(const NurbsStore& store, const Surface& surface) {
  BezierPatches r;
  if (surface.kind == SurfaceKind::kMesh || surface.kind == SurfaceKind::kNone) return r;
  const SurfaceView s = view(store, surface);
  r.degree_u = surface.degree_u, r.degree_v = surface.degree_v;
  const std::vector<double> us = distinct_knots(s.knots_u, r.degree_u),
                            vs = distinct_knots(s.knots_v, r.degree_v);
  r.spans_u = static_cast<int>(us.size()) - 1, r.spans_v = static_cast<int>(vs.size()) - 1;

  // Rows along v first, then columns along u; the rows now hold (degree_v + 1) points a span.
  const int pv = r.degree_v + 1, pu = r.degree_u + 1, width = r.spans_v * pv, height = r.spans_u * pu;
  std::vector<dvec4> rows;
  rows.reserve(static_cast<std::size_t>(surface.count_u) * width);
  for (int i = 0; i < surface.count_u; ++i)
    append_bezier(s.knots_v, r.degree_v, s.ctrl_h + std::ptrdiff_t(i) * surface.count_v, 1, rows);

  r.ctrl_h.resize(static_cast<std::size_t>(width) * height);
  std::vector<dvec4> column;
  column.reserve(height);
  for (int c = 0; c < width; ++c) {
    column.clear();
    append_bezier(s.knots_u, r.degree_u, rows.data() + c, width, column);
    for (int i = 0; i < height; ++i) {
      const std::size_t patch = static_cast<std::size_t>(i / pu) * r.spans_v + c / pv;
      r.ctrl_h[patch * r.points() + static_cast<std::size_t>(i % pu) * pv + c % pv] = column[i];
    }
  }
  for (int i = 0; i < r.spans_u; ++i)
    for (int j = 0; j < r.spans_v; ++j) r.uv_face.push_back({{us[i], vs[j]}, {us[i + 1], vs[j + 1]}});
  return r;
}

}  // namespace trimray::nurbs
