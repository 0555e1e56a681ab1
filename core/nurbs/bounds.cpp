#include "core/nurbs/bounds.h"

#include <cmath>

namespace trimray::nurbs {

Box3 hull_bounds(const SurfaceView& view, const Box2& uv_face) {
  const Surface& f = *view.surface;
  const auto mapped = [](std::span<const double> knots, int degree, ParamMap map, double u) {
    const int span = find_span(knots, degree, u);
    return map_parameter(map, knots[span], knots[span + 1], u).s;
  };
  const Respan u = plan_respan(view.knots_u, f.degree_u, mapped(view.knots_u, f.degree_u, f.map_u, uv_face.lower.x),
                               mapped(view.knots_u, f.degree_u, f.map_u, uv_face.upper.x));
  const Respan v = plan_respan(view.knots_v, f.degree_v, mapped(view.knots_v, f.degree_v, f.map_v, uv_face.lower.y),
                               mapped(view.knots_v, f.degree_v, f.map_v, uv_face.upper.y));
  std::vector<dvec4> rows(static_cast<std::size_t>(f.count_u) * v.count()), column(u.count());
  for (int i = 0; i < f.count_u; ++i)
    apply_respan(v, view.knots_v, f.degree_v, view.ctrl_h + std::ptrdiff_t(i) * f.count_v, 1,
                 &rows[std::size_t(i) * v.count()], 1);
  Box3 box;
  for (int j = 0; j < v.count(); ++j) {
    apply_respan(u, view.knots_u, f.degree_u, &rows[j], v.count(), column.data(), 1);
    for (const dvec4& h : column) box.add(project(h));
  }
  if (box.empty()) return box;
  // Rounding of the insertion, a few ulps of the coordinates.
  const double reach = glm::length(glm::max(glm::abs(box.lower), glm::abs(box.upper)));
  box.dilate(std::abs(f.offset) + 1e-14 * reach);
  return box;
}

}  // namespace trimray::nurbs
