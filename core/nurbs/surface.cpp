#include "core/nurbs/surface.h"

#include <cmath>

#include "core/nurbs/surface_form.h"

namespace trimray::nurbs {
namespace {

// Point and derivatives up to the second of a NURBS form, with respect to uv_face.
struct Jet {
  dvec3 p, du, dv, duu, duv, dvv;
};

struct Axis {
  int span = 0;
  MappedParameter at;
  Basis basis;
};

Axis axis_at(std::span<const double> knots, int degree, ParamMap map, double u, int derivatives) {
  Axis r;
  r.span = find_span(knots, degree, u);  // the map keeps knots, so u and s share their span
  r.at = map_parameter(map, knots[r.span], knots[r.span + 1], u);
  basis_functions(knots, degree, r.span, r.at.s, derivatives, r.basis);
  return r;
}

Jet nurbs_jet(const SurfaceView& view, dvec2 uv, int derivatives) {
  const Surface& f = *view.surface;
  const dvec2 middle = f.domain.center();
  if (f.periodic_u && !(uv.x >= f.domain.lower.x && uv.x <= f.domain.upper.x))
    uv.x = wrap_near(uv.x, middle.x, f.period_u);
  if (f.periodic_v && !(uv.y >= f.domain.lower.y && uv.y <= f.domain.upper.y))
    uv.y = wrap_near(uv.y, middle.y, f.period_v);
  const Axis u = axis_at(view.knots_u, f.degree_u, f.map_u, uv.x, derivatives);
  const Axis v = axis_at(view.knots_v, f.degree_v, f.map_v, uv.y, derivatives);

  dvec4 h[3][3] = {};  // h[a][b]: a-th derivative in s_u, b-th in s_v, a + b <= derivatives
  for (int i = 0; i <= f.degree_u; ++i) {
    const dvec4* row =
        view.ctrl_h + std::ptrdiff_t(u.span - f.degree_u + i) * f.count_v + (v.span - f.degree_v);
    dvec4 along[3] = {};
    for (int b = 0; b <= derivatives; ++b)
      for (int j = 0; j <= f.degree_v; ++j) along[b] += v.basis.value[b][j] * row[j];
    for (int a = 0; a <= derivatives; ++a)
      for (int b = 0; a + b <= derivatives; ++b) h[a][b] += u.basis.value[a][i] * along[b];
  }
  const auto xyz = [](const dvec4& q) { return dvec3(q.x, q.y, q.z); };
  const double w = h[0][0].w;
  Jet r{};
  r.p = xyz(h[0][0]) / w;
  if (derivatives == 0) return r;
  const dvec3 su = (xyz(h[1][0]) - h[1][0].w * r.p) / w, sv = (xyz(h[0][1]) - h[0][1].w * r.p) / w;
  r.du = su * u.at.ds, r.dv = sv * v.at.ds;
  if (derivatives > 1) {
    const dvec3 suu = (xyz(h[2][0]) - 2.0 * h[1][0].w * su - h[2][0].w * r.p) / w;
    const dvec3 svv = (xyz(h[0][2]) - 2.0 * h[0][1].w * sv - h[0][2].w * r.p) / w;
    const dvec3 suv = (xyz(h[1][1]) - h[1][0].w * sv - h[0][1].w * su - h[1][1].w * r.p) / w;
    r.duu = suu * (u.at.ds * u.at.ds) + su * u.at.dds;
    r.dvv = svv * (v.at.ds * v.at.ds) + sv * v.at.dds;
    r.duv = suv * (u.at.ds * v.at.ds);
  }
  return r;
}

// S + offset * n with n = Su x Sv / |Su x Sv|; its derivatives by the quotient rule.
SurfacePoint offset_point(const SurfaceView& view, dvec2 uv) {
  const Surface& f = *view.surface;
  Jet j = nurbs_jet(view, uv, 2);
  dvec3 n = glm::cross(j.du, j.dv);
  double length = glm::length(n);
  // On a pole the normal is the limit from inside the domain.
  if (!(length > 1e-12 * glm::dot(j.du, j.du) + 1e-12 * glm::dot(j.dv, j.dv))) {
    const dvec3 p = j.p;
    j = nurbs_jet(view, uv + 1e-6 * (f.domain.center() - uv), 2);
    j.p = p;
    n = glm::cross(j.du, j.dv);
    length = glm::length(n);
  }
  if (!(length > 0.0)) return {j.p, j.du, j.dv};
  const dvec3 unit = n / length;
  const dvec3 nu = glm::cross(j.duu, j.dv) + glm::cross(j.du, j.duv);
  const dvec3 nv = glm::cross(j.duv, j.dv) + glm::cross(j.du, j.dvv);
  const auto tangential = [&](const dvec3& d) { return (d - glm::dot(d, unit) * unit) / length; };
  return {j.p + f.offset * unit, j.du + f.offset * tangential(nu), j.dv + f.offset * tangential(nv)};
}

SurfacePoint closed_form(const Surface& f, dvec2 uv) {
  const double u = uv.x, v = uv.y;
  if (f.kind == SurfaceKind::kPlane) return {f.location + u * f.x_axis + v * f.y_axis, f.x_axis, f.y_axis};
  const double cu = std::cos(u), su = std::sin(u);
  const dvec3 radial = cu * f.x_axis + su * f.y_axis, around = cu * f.y_axis - su * f.x_axis;
  double r = f.r1, z = v, dr = 0.0, dz = 1.0;  // the profile at v
  if (f.kind == SurfaceKind::kCone) {
    dr = std::sin(f.semi_angle), dz = std::cos(f.semi_angle);
    r = f.r1 + v * dr, z = v * dz;
  } else if (f.kind == SurfaceKind::kSphere || f.kind == SurfaceKind::kTorus) {
    const double cv = std::cos(v), sv = std::sin(v);
    const double tube = f.kind == SurfaceKind::kSphere ? f.r1 : f.r2;
    r = tube * cv + (f.kind == SurfaceKind::kTorus ? f.r1 : 0.0);
    z = tube * sv, dr = -tube * sv, dz = tube * cv;
  }
  return {f.location + r * radial + z * f.z_axis, r * around, dr * radial + dz * f.z_axis};
}

}  // namespace

SurfaceView view(const SurfaceForm& form) {
  return {&form.surface, form.knots_u, form.knots_v, form.ctrl_h.data()};
}

SurfaceView view(const NurbsStore& store, const Surface& surface) {
  const auto part = [&](const Range& r) {
    return std::span<const double>(store.knots.data() + r.begin, static_cast<std::size_t>(r.size()));
  };
  return {&surface, part(surface.knots_u), part(surface.knots_v), store.ctrl_h.data() + surface.ctrl.begin};
}

SurfacePoint evaluate(const SurfaceView& view, dvec2 uv_face) {
  if (has_closed_form(view.surface->kind)) return closed_form(*view.surface, uv_face);
  if (view.surface->kind == SurfaceKind::kOffset) return offset_point(view, uv_face);
  return evaluate_nurbs(view, uv_face);
}

SurfacePoint evaluate_nurbs(const SurfaceView& view, dvec2 uv_face) {
  const Jet j = nurbs_jet(view, uv_face, 1);
  return {j.p, j.du, j.dv};
}

dvec3 evaluate_point(const SurfaceView& view, dvec2 uv_face) {
  if (has_closed_form(view.surface->kind)) return closed_form(*view.surface, uv_face).p;
  if (view.surface->kind == SurfaceKind::kOffset) return offset_point(view, uv_face).p;
  return nurbs_jet(view, uv_face, 0).p;
}

SurfacePoint evaluate(const NurbsStore& store, const Surface& surface, dvec2 uv_face) {
  return evaluate(view(store, surface), uv_face);
}

SurfacePoint evaluate_nurbs(const NurbsStore& store, const Surface& surface, dvec2 uv_face) {
  return evaluate_nurbs(view(store, surface), uv_face);
}

namespace {

// The distinct knots around u; the end spans for u outside.
std::pair<double, double> span_around(const NurbsStore& store, const Range& knots, double u) {
  const double* first = store.knots.data() + knots.begin;
  const double* last = store.knots.data() + knots.end;
  const double* above = std::upper_bound(first, last, u);
  if (above == first) above = std::upper_bound(first, last, *first);
  if (above == last) above = std::lower_bound(first, last, *(last - 1));
  return {*(above - 1), *above};
}

}  // namespace

double nurbs_from_face(const NurbsStore& store, const Range& knots, ParamMap map, double u) {
  if (map == ParamMap::kIdentity) return u;
  const auto [a, b] = span_around(store, knots, u);
  return map_parameter(map, a, b, u).s;
}

double face_from_nurbs(const NurbsStore& store, const Range& knots, ParamMap map, double s) {
  if (map == ParamMap::kIdentity) return s;
  const auto [a, b] = span_around(store, knots, s);
  return unmap_parameter(map, a, b, s);
}

}  // namespace trimray::nurbs
