#include "core/mass/surface_row.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trimray::mass {
namespace {

using nurbs::SurfaceKind;

// Angles are cut so that low rules will do.
constexpr double kWidestAngle = 0.5 * std::numbers::pi;
// Faces that go round more often than this are damaged, and cut no further.
constexpr double kMostTurns = 1000.0;

void cut_angle(double lower, double upper, std::vector<double>& lines) {
  const int parts = static_cast<int>(std::ceil(std::min((upper - lower) / kWidestAngle, kMostTurns) - 1e-9));
  for (int i = 1; i < parts; ++i) lines.push_back(lower + (upper - lower) * i / parts);
}

// Lines of a periodic direction beyond the domain, and those where one turn ends and the next begins.
void repeat(const Box2& domain, dvec2 low, dvec2 high, int axis, double period, std::vector<double>& lines) {
  const double far = std::max(std::abs(low[axis]), std::abs(high[axis]));
  if (period <= 0.0 || !(period > 1e-9 * far) || high[axis] - low[axis] > kMostTurns * period ||
      (low[axis] >= domain.lower[axis] && high[axis] <= domain.upper[axis]))
    return;
  std::vector<double> turn = std::move(lines);
  turn.push_back(domain.center()[axis] + 0.5 * period);
  lines.clear();
  for (const double x : turn)
    for (double at = x + period * std::ceil((low[axis] - x) / period); at < high[axis]; at += period)
      lines.push_back(at);
}

void tidy(double lower, double upper, std::vector<double>& lines) {
  std::erase_if(lines, [&](double x) { return !(x > lower && x < upper); });
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
}

// Bernstein polynomials of the degree at x, and their derivatives.
void bernstein(int degree, double x, double* value, double* slope) {
  value[0] = 1.0, slope[0] = 0.0;
  for (int n = 1; n <= degree; ++n) {
    if (n == degree)
      for (int i = 0; i <= n; ++i) slope[i] = n * ((i > 0 ? value[i - 1] : 0.0) - (i < n ? value[i] : 0.0));
    double left = 0.0;
    for (int i = 0; i < n; ++i) {
      const double old = value[i];
      value[i] = left + (1.0 - x) * old;
      left = x * old;
    }
    value[n] = left;
  }
}

}  // namespace

SmoothCells smooth_cells(const nurbs::NurbsStore& store, const nurbs::Surface& surface, const Box2& box) {
  SmoothCells cells;
  const dvec2 low = box.lower, high = box.upper;
  if (nurbs::has_closed_form(surface.kind)) {
    if (surface.kind != SurfaceKind::kPlane) cut_angle(low.x, high.x, cells.u);
    const double apex_sine = std::sin(surface.semi_angle);
    if (surface.kind == SurfaceKind::kCone && apex_sine != 0.0) cells.v.push_back(-surface.r1 / apex_sine);
    if (surface.kind == SurfaceKind::kSphere || surface.kind == SurfaceKind::kTorus)
      cut_angle(low.y, high.y, cells.v);
    // A torus that meets its axis has poles there.
    if (surface.kind == SurfaceKind::kTorus && surface.r2 >= surface.r1 &&
        std::max(std::abs(low.y), std::abs(high.y)) < kMostTurns) {
      const double at = std::acos(-surface.r1 / surface.r2), turn = 2.0 * std::numbers::pi;
      for (const double pole : {at, -at})
        for (double v = pole + turn * std::ceil((low.y - pole) / turn); v < high.y; v += turn)
          cells.v.push_back(v);
    }
  } else {
    const nurbs::SurfaceView view = nurbs::view(store, surface);
    cells.u = nurbs::distinct_knots(view.knots_u, surface.degree_u);
    cells.v = nurbs::distinct_knots(view.knots_v, surface.degree_v);
    // The outer spans continue.
    for (auto* lines : {&cells.u, &cells.v}) lines->pop_back(), lines->erase(lines->begin());
    repeat(surface.domain, low, high, 0, surface.period_u, cells.u);
    repeat(surface.domain, low, high, 1, surface.period_v, cells.v);
  }
  tidy(low.x, high.x, cells.u), tidy(low.y, high.y, cells.v);
  return cells;
}

SurfacePatches::SurfacePatches(const nurbs::NurbsStore& store, const nurbs::Surface& surface)
    : view_(nurbs::view(store, surface)),
      direct_(nurbs::has_closed_form(surface.kind) || surface.kind == SurfaceKind::kOffset) {
  if (!direct_) patches_ = nurbs::bezier_patches(store, surface);
}

SurfaceRow::SurfaceRow(const SurfacePatches& surface, dvec2 inside) : surface_(surface) {
  if (surface.direct_) return;
  const nurbs::Surface& f = *surface.view_.surface;
  const dvec2 middle = f.domain.center();
  const auto turn = [&](int axis, double period) {
    const bool beyond = inside[axis] < f.domain.lower[axis] || inside[axis] > f.domain.upper[axis];
    return beyond ? nurbs::wrap_near(inside[axis], middle[axis], period) - inside[axis] : 0.0;
  };
  turn_ = {turn(0, f.period_u), turn(1, f.period_v)};
  inside += turn_;
  const nurbs::BezierPatches& p = surface.patches_;
  int i = 0, j = 0;
  while (i + 1 < p.spans_u && inside.x >= p.uv_face[static_cast<std::size_t>(i) * p.spans_v].upper.x) ++i;
  while (j + 1 < p.spans_v && inside.y >= p.uv_face[j].upper.y) ++j;
  const std::size_t k = static_cast<std::size_t>(i) * p.spans_v + j;
  box_ = p.uv_face[k], ctrl_ = &p.ctrl_h[k * p.points()];
}

void SurfaceRow::set_v(double v) {
  v_ = v;
  if (surface_.direct_) return;
  const nurbs::BezierPatches& p = surface_.patches_;
  const double a = box_.lower.y, b = box_.upper.y;
  const nurbs::MappedParameter at = nurbs::map_parameter(surface_.view_.surface->map_v, a, b, v + turn_.y);
  double value[nurbs::kMaxDegree + 1], slope[nurbs::kMaxDegree + 1];
  bernstein(p.degree_v, (at.s - a) / (b - a), value, slope);
  const double stretch = at.ds / (b - a);
  const dvec4* c = ctrl_;
  for (int i = 0; i <= p.degree_u; ++i) {
    dvec4 sum(0.0), rise(0.0);
    for (int j = 0; j <= p.degree_v; ++j, ++c) sum += value[j] * *c, rise += slope[j] * *c;
    row_[i] = sum, across_[i] = stretch * rise;
  }
}

nurbs::SurfacePoint SurfaceRow::at(double u) const {
  if (surface_.direct_) return nurbs::evaluate(surface_.view_, {u, v_});
  const int degree = surface_.patches_.degree_u;
  const double a = box_.lower.x, b = box_.upper.x;
  const nurbs::MappedParameter at = nurbs::map_parameter(surface_.view_.surface->map_u, a, b, u + turn_.x);
  double value[nurbs::kMaxDegree + 1], slope[nurbs::kMaxDegree + 1];
  bernstein(degree, (at.s - a) / (b - a), value, slope);
  dvec4 h(0.0), hu(0.0), hv(0.0);
  for (int i = 0; i <= degree; ++i)
    h += value[i] * row_[i], hu += slope[i] * row_[i], hv += value[i] * across_[i];
  const double inverse = 1.0 / h.w;
  const dvec3 point = inverse * dvec3(h.x, h.y, h.z);
  const double stretch = at.ds / (b - a);
  return {point, stretch * inverse * (dvec3(hu.x, hu.y, hu.z) - hu.w * point),
          inverse * (dvec3(hv.x, hv.y, hv.z) - hv.w * point)};
}

}  // namespace trimray::mass
