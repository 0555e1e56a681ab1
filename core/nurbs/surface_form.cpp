#include "core/nurbs/surface_form.h"

#include <cmath>
#include <numbers>

#include "core/nurbs/curve_form.h"

namespace trimray::nurbs {
namespace {

constexpr double kCircleSpan = 100.0 * std::numbers::pi / 180.0;
constexpr double kHyperbolaSpan = 1.0;

// f(at) = (cos, sin) or (cosh, sinh); the middle control point of a span of half width h is
// (f(m), c(h)) in homogeneous form for both conics.
template <typename F, typename W>
SplineCurve<dvec3> conic_basis(double a, double b, double widest, ParamMap map, const F& f, const W& weight) {
  const int spans = std::max(1, static_cast<int>(std::ceil((b - a) / widest - 1e-9)));
  SplineCurve<dvec3> r;
  r.degree = 2, r.map = map;
  r.knots = {a};
  const auto knot = [&](int i) { return i == spans ? b : a + (b - a) * i / spans; };
  for (int i = 0; i < spans; ++i) {
    const double lo = knot(i), hi = knot(i + 1), half = 0.5 * (hi - lo), m = lo + half;
    r.knots.insert(r.knots.end(), 2, lo);
    r.ctrl.push_back(dvec3(f(lo), 1.0));
    r.ctrl.push_back(dvec3(f(m), weight(half)));
  }
  r.ctrl.push_back(dvec3(f(b), 1.0));
  r.knots.insert(r.knots.end(), 3, b);
  return r;
}

SplineCurve<dvec3> line_basis(dvec3 p0, dvec3 p1, double a, double b) {
  SplineCurve<dvec3> r;
  r.degree = 1, r.knots = {a, a, b, b}, r.ctrl = {p0, p1};
  return r;
}

void set_axis_u(SurfaceForm& form, const auto& curve) {
  form.surface.degree_u = curve.degree, form.surface.map_u = curve.map;
  form.surface.count_u = static_cast<std::int32_t>(curve.ctrl.size());
  form.knots_u = curve.knots;
}

void set_axis_v(SurfaceForm& form, const auto& curve) {
  form.surface.degree_v = curve.degree, form.surface.map_v = curve.map;
  form.surface.count_v = static_cast<std::int32_t>(curve.ctrl.size());
  form.knots_v = curve.knots;
}

void finish(SurfaceForm& form) {
  Surface& f = form.surface;
  f.domain.lower = {form.knots_u.front(), form.knots_v.front()};
  f.domain.upper = {form.knots_u.back(), form.knots_v.back()};
  f.rational = false;
  for (const dvec4& h : form.ctrl_h) f.rational = f.rational || h.w != 1.0;
}

}  // namespace

SplineCurve<dvec3> circle_basis(double a, double b) {
  return conic_basis(
      a, b, kCircleSpan, ParamMap::kCircular, [](double t) { return dvec2(std::cos(t), std::sin(t)); },
      [](double h) { return std::cos(h); });
}

SplineCurve<dvec3> hyperbola_basis(double a, double b) {
  return conic_basis(
      a, b, kHyperbolaSpan, ParamMap::kHyperbolic, [](double t) { return dvec2(std::cosh(t), std::sinh(t)); },
      [](double h) { return std::cosh(h); });
}

bool has_closed_form(SurfaceKind kind) {
  return kind == SurfaceKind::kPlane || kind == SurfaceKind::kCylinder || kind == SurfaceKind::kCone ||
         kind == SurfaceKind::kSphere || kind == SurfaceKind::kTorus;
}

void set_closed_form_nurbs(SurfaceForm& form, const Box2& domain) {
  Surface& f = form.surface;
  const double v0 = domain.lower.y, v1 = domain.upper.y;
  form.ctrl_h.clear();
  if (f.kind == SurfaceKind::kPlane) {
    set_axis_u(form, line_basis({}, {}, domain.lower.x, domain.upper.x));
    set_axis_v(form, line_basis({}, {}, v0, v1));
    for (const double u : {domain.lower.x, domain.upper.x})
      for (const double v : {v0, v1}) form.ctrl_h.emplace_back(f.location + u * f.x_axis + v * f.y_axis, 1.0);
    return finish(form);
  }
  // Profile (r, z, w) in the half plane of the axis.
  SplineCurve<dvec3> profile;
  if (f.kind == SurfaceKind::kCylinder) {
    profile = line_basis({f.r1, v0, 1.0}, {f.r1, v1, 1.0}, v0, v1);
  } else if (f.kind == SurfaceKind::kCone) {
    const double s = std::sin(f.semi_angle), c = std::cos(f.semi_angle);
    profile = line_basis({f.r1 + v0 * s, v0 * c, 1.0}, {f.r1 + v1 * s, v1 * c, 1.0}, v0, v1);
  } else {
    profile = circle_basis(v0, v1);
    const bool torus = f.kind == SurfaceKind::kTorus;
    for (dvec3& h : profile.ctrl) {
      const double tube = torus ? f.r2 : f.r1;
      h = dvec3(tube * h.x + (torus ? f.r1 * h.z : 0.0), tube * h.y, h.z);
    }
  }
  const SplineCurve<dvec3> circle = circle_basis(domain.lower.x, domain.upper.x);
  set_axis_u(form, circle);
  set_axis_v(form, profile);
  for (const dvec3& c : circle.ctrl)
    for (const dvec3& p : profile.ctrl)
      form.ctrl_h.emplace_back(
          p.x * (c.x * f.x_axis + c.y * f.y_axis) + c.z * (p.y * f.z_axis + p.z * f.location), c.z * p.z);
  finish(form);
}

void set_extrusion_nurbs(SurfaceForm& form, const SplineCurve<dvec4>& curve, dvec3 direction, double v0,
                         double v1) {
  form.ctrl_h.clear();
  set_axis_u(form, curve);
  set_axis_v(form, line_basis({}, {}, v0, v1));
  for (const dvec4& h : curve.ctrl)
    for (const double v : {v0, v1}) form.ctrl_h.push_back(h + dvec4(h.w * v * direction, 0.0));
  finish(form);
}

void set_revolution_nurbs(SurfaceForm& form, const SplineCurve<dvec4>& curve, dvec3 location, dvec3 axis,
                          double u0, double u1) {
  form.ctrl_h.clear();
  const SplineCurve<dvec3> circle = circle_basis(u0, u1);
  set_axis_u(form, circle);
  set_axis_v(form, curve);
  for (const dvec3& c : circle.ctrl) {
    for (const dvec4& h : curve.ctrl) {
      const dvec3 arm = dvec3(h.x, h.y, h.z) - h.w * location;  // times the weight
      const dvec3 along = glm::dot(arm, axis) * axis;
      const dvec3 turned = c.x * (arm - along) + c.y * glm::cross(axis, arm);
      form.ctrl_h.emplace_back(turned + c.z * (along + h.w * location), c.z * h.w);
    }
  }
  finish(form);
}

void respan_surface(SurfaceForm& form, const Box2& domain) {
  Surface& f = form.surface;
  const Respan u = plan_respan(form.knots_u, f.degree_u, domain.lower.x, domain.upper.x);
  const Respan v = plan_respan(form.knots_v, f.degree_v, domain.lower.y, domain.upper.y);
  std::vector<dvec4> rows(static_cast<std::size_t>(f.count_u) * v.count());
  for (int i = 0; i < f.count_u; ++i)
    apply_respan(v, form.knots_v, f.degree_v, &form.ctrl_h[std::size_t(i) * f.count_v], 1,
                 &rows[std::size_t(i) * v.count()], 1);
  form.ctrl_h.assign(static_cast<std::size_t>(u.count()) * v.count(), dvec4(0.0));
  for (int j = 0; j < v.count(); ++j)
    apply_respan(u, form.knots_u, f.degree_u, &rows[j], v.count(), &form.ctrl_h[j], v.count());
  form.knots_u = u.knots, form.knots_v = v.knots;
  f.count_u = u.count(), f.count_v = v.count();
  finish(form);
}

SplineCurve<dvec4> iso_curve(const SurfaceView& view, bool fixed_u, double at) {
  const Surface& f = *view.surface;
  const auto knots = fixed_u ? view.knots_u : view.knots_v;
  const int degree = fixed_u ? f.degree_u : f.degree_v;
  const int span = find_span(knots, degree, at);
  const double s = map_parameter(fixed_u ? f.map_u : f.map_v, knots[span], knots[span + 1], at).s;
  Basis basis;
  basis_functions(knots, degree, span, s, 0, basis);

  const auto other = fixed_u ? view.knots_v : view.knots_u;
  SplineCurve<dvec4> r;
  r.degree = fixed_u ? f.degree_v : f.degree_u;
  r.map = fixed_u ? f.map_v : f.map_u;
  r.knots.assign(other.begin(), other.end());
  r.ctrl.assign(fixed_u ? f.count_v : f.count_u, dvec4(0.0));
  for (std::size_t k = 0; k < r.ctrl.size(); ++k)
    for (int i = 0; i <= degree; ++i) {
      const std::ptrdiff_t iu = fixed_u ? span - degree + i : k, iv = fixed_u ? k : span - degree + i;
      r.ctrl[k] += basis.value[0][i] * view.ctrl_h[iu * f.count_v + iv];
    }
  return r;
}

std::int32_t append_surface(NurbsStore& store, const SurfaceForm& form) {
  Surface f = form.surface;
  const auto append = [](auto& to, const auto& from) {
    const Range r{static_cast<std::int32_t>(to.size()), static_cast<std::int32_t>(to.size() + from.size())};
    to.insert(to.end(), from.begin(), from.end());
    return r;
  };
  f.knots_u = append(store.knots, form.knots_u);
  f.knots_v = append(store.knots, form.knots_v);
  f.ctrl = append(store.ctrl_h, form.ctrl_h);
  f.conic = append_conic(store, form.conic);
  if (f.basis == SurfaceKind::kNone) f.basis = f.kind;
  store.surfaces.push_back(f);
  return static_cast<std::int32_t>(store.surfaces.size()) - 1;
}

}  // namespace trimray::nurbs
