#include "core/nurbs/surface_over.h"

#include <cmath>
#include <numbers>

#include "core/nurbs/curve_form.h"

namespace trimray::nurbs {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMargin = 0.01;       // of the uv box's width
constexpr double kSplineReach = 0.05;  // of the end span, that a spline is continued at most without need
constexpr double kMaxTurns = 16.0;
constexpr double kMaxSwell = 10.0;  // how much larger than its poles' box a spline may grow beyond its ends

using Kind = brep::SurfaceKind;

// [lo, hi] with its margin, kept within the natural range where it may not be left.
void widen(double& lo, double& hi, double natural_lo, double natural_hi, double period) {
  const double width = hi - lo;
  if (period > 0.0) {
    if (width >= period * (1.0 - 1e-12)) return;  // all of it is there
    const double margin = std::min(kMargin * width, 0.5 * (period - width));
    lo -= margin, hi += margin;
    return;
  }
  const double wide_lo = lo - kMargin * width, wide_hi = hi + kMargin * width;
  lo = std::min(lo, std::max(wide_lo, natural_lo)), hi = std::max(hi, std::min(wide_hi, natural_hi));
}

// Part of an end span that a spline may be continued: beyond [-1, 1] a polynomial grows at most like the
// Chebyshev polynomial T_p, so that it stays within twice its bound on the span where T_p(1 + 2 reach) <= 2.
double spline_reach(int degree) {
  return std::min(kSplineReach, 0.5 * (std::cosh(std::acosh(2.0) / std::max(degree, 1)) - 1.0));
}

// For splines: a margin beyond the natural end that does not strain the end span.
void widen_spline(double& lo, double& hi, const CurveDomain& d, std::span<const double> distinct,
                  int degree) {
  const double width = hi - lo;
  widen(lo, hi, d.lower, d.upper, d.period);
  if (d.period > 0.0 || distinct.size() < 2) return;
  const double first = distinct[1] - distinct[0],
               last = distinct[distinct.size() - 1] - distinct[distinct.size() - 2];
  if (lo <= d.lower) lo = std::min(lo, d.lower - std::min(kMargin * width, spline_reach(degree) * first));
  if (hi >= d.upper) hi = std::max(hi, d.upper + std::min(kMargin * width, spline_reach(degree) * last));
}

// Did continuing the spline beyond its ends (the loops may ask for that) blow it up? Within them it lies in
// the box of its poles.
bool swollen(const brep::Surface& b, const SurfaceForm& form) {
  Box3 poles, form_box;
  for (const dvec3& p : b.poles) poles.add(p);
  for (const dvec4& h : form.ctrl_h) {
    if (!(h.w > 0.0)) return true;
    form_box.add(project(h));
  }
  return !(form_box.diagonal() <= kMaxSwell * poles.diagonal());
}

bool spline_over(const brep::Surface& b, const SurfaceSource& source, Box2 box, SurfaceForm& out) {
  Surface& f = out.surface;
  FlatKnots u, v;
  if (b.kind == Kind::kBezier) {
    f.degree_u = b.count_u - 1, f.degree_v = b.count_v - 1;
    const std::vector<double> ends = {0.0, 1.0};
    u = flatten_knots(ends, std::vector<std::int32_t>(2, b.count_u), f.degree_u, b.count_u, false, 0, 0);
    v = flatten_knots(ends, std::vector<std::int32_t>(2, b.count_v), f.degree_v, b.count_v, false, 0, 0);
    widen_spline(box.lower.x, box.upper.x, {0.0, 1.0, 0.0}, ends, f.degree_u);
    widen_spline(box.lower.y, box.upper.y, {0.0, 1.0, 0.0}, ends, f.degree_v);
  } else {
    f.degree_u = b.degree_u, f.degree_v = b.degree_v;
    widen_spline(box.lower.x, box.upper.x, {source.natural.lower.x, source.natural.upper.x, f.period_u},
                 b.knots_u, f.degree_u);
    widen_spline(box.lower.y, box.upper.y, {source.natural.lower.y, source.natural.upper.y, f.period_v},
                 b.knots_v, f.degree_v);
    const auto far = [](double t, double first, double period) {
      return period > 0.0 && !(std::abs(t - first) <= kMaxTurnsAway * period);
    };
    if (far(box.lower.x, b.knots_u.front(), f.period_u) || far(box.lower.y, b.knots_v.front(), f.period_v))
      return false;
    u = flatten_knots(b.knots_u, b.multiplicities_u, f.degree_u, b.count_u, b.periodic_u, box.lower.x,
                      box.upper.x);
    v = flatten_knots(b.knots_v, b.multiplicities_v, f.degree_v, b.count_v, b.periodic_v, box.lower.y,
                      box.upper.y);
  }
  // Further off than half the surface's width its polynomials mean nothing.
  const dvec2 begin(u.knots[f.degree_u], v.knots[f.degree_v]),
      end(u.knots[u.wrap.size()], v.knots[v.wrap.size()]);
  const dvec2 slack = 0.5 * (end - begin);
  for (int d = 0; d < 2; ++d)
    if (box.lower[d] < begin[d] - slack[d] || box.upper[d] > end[d] + slack[d] || box.lower[d] >= end[d] ||
        box.upper[d] <= begin[d])
      return false;
  out.knots_u = std::move(u.knots), out.knots_v = std::move(v.knots);
  f.count_u = static_cast<std::int32_t>(u.wrap.size()), f.count_v = static_cast<std::int32_t>(v.wrap.size());
  out.ctrl_h.clear();
  for (const int i : u.wrap)
    for (const int j : v.wrap) {
      const std::size_t k = static_cast<std::size_t>(i) * b.count_v + j;
      const double w = b.weights.empty() ? 1.0 : b.weights[k];
      out.ctrl_h.emplace_back(w * b.poles[k], w);
    }
  respan_surface(out, box);
  return !swollen(b, out);
}

bool swept_over(const brep::Model& model, const brep::Surface& b, const SurfaceSource& source, Box2 box,
                SurfaceForm& out) {
  const bool extrusion = b.kind == Kind::kExtrusion;
  const int axis = extrusion ? 0 : 1;  // of the curve
  CurveDomain d = curve_domain<3>(model.curves3, b.basis_curve);
  std::int32_t basis = b.basis_curve;
  while (model.curves3[basis].kind == brep::CurveKind::kTrimmed) basis = model.curves3[basis].basis;
  if (model.curves3[basis].kind != brep::CurveKind::kBspline &&
      model.curves3[basis].kind != brep::CurveKind::kBezier)
    d.lower = -kInf, d.upper = kInf;
  widen(box.lower[axis], box.upper[axis], d.lower, d.upper, d.period);
  const int other = 1 - axis;
  widen(box.lower[other], box.upper[other], -kInf, kInf, extrusion ? 0.0 : source.form.surface.period_u);
  const auto curve = curve_form<3>(model.curves3, b.basis_curve, box.lower[axis], box.upper[axis]);
  if (!curve) return false;
  if (extrusion)
    set_extrusion_nurbs(out, *curve, b.z_axis, box.lower.y, box.upper.y);
  else
    set_revolution_nurbs(out, *curve, b.location, glm::normalize(b.z_axis), box.lower.x, box.upper.x);
  return true;
}

}  // namespace

bool surface_over(const brep::Model& model, const SurfaceSource& source, const Box2& uv_box,
                  SurfaceForm& out) {
  out = source.form;
  Box2 box = uv_box;
  for (int d = 0; d < 2; ++d) {
    if (!(box.upper[d] > box.lower[d]) || !(std::abs(box.lower[d]) < kMaxCoordinate) ||
        !(std::abs(box.upper[d]) < kMaxCoordinate))
      return false;
    const double period = d == 0 ? out.surface.period_u : out.surface.period_v;
    if (period > 0.0 &&
        (box.upper[d] - box.lower[d] > kMaxTurns * period || std::abs(box.lower[d]) > 1e6 * period))
      return false;
  }
  const SurfaceKind kind = out.surface.kind;
  if (has_closed_form(source.basis_kind)) {
    const bool sphere = source.basis_kind == SurfaceKind::kSphere;
    // A latitude of more than half a turn is damage; as an angle it would ask for a span every quarter turn.
    if (sphere && (box.lower.y < -kPi || box.upper.y > kPi)) return false;
    widen(box.lower.x, box.upper.x, -kInf, kInf, out.surface.period_u);
    widen(box.lower.y, box.upper.y, sphere ? -kPi / 2 : -kInf, sphere ? kPi / 2 : kInf, out.surface.period_v);
    out.surface.kind = source.basis_kind;
    set_closed_form_nurbs(out, box);
    out.surface.kind = kind;
  } else if (source.basis_kind == SurfaceKind::kBezier || source.basis_kind == SurfaceKind::kBspline) {
    if (!spline_over(*source.definition, source, box, out)) return false;
  } else if (!swept_over(model, *source.definition, source, box, out)) {
    return false;
  }
  if (source.transformed) transform_ctrl(out.ctrl_h, source.placement);
  for (const dvec4& h : out.ctrl_h) {
    if (!(h.w > 0.0) || !std::isfinite(h.w)) return false;
    for (int i = 0; i < 3; ++i)
      if (!(std::abs(h[i]) <= kMaxCoordinate * h.w)) return false;
  }
  return true;
}

}  // namespace trimray::nurbs
