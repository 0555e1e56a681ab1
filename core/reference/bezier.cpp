#include "core/reference/bezier.h"

#include <algorithm>
#include <cmath>

namespace trimray::reference {
namespace {

// Value of the blossom of a B-spline's polynomial over span k at the given arguments (generalised de Boor).
Vec4 blossom(std::span<const double> knots, std::span<const Vec4> ctrl, int degree, int k,
             std::span<const Real> args, std::vector<Vec4>& work) {
  work.assign(ctrl.begin() + (k - degree), ctrl.begin() + (k + 1));
  for (int r = 1; r <= degree; ++r) {
    for (int j = degree; j >= r; --j) {
      const int i = k - degree + j;
      const Real left = knots[i], right = knots[i + degree - r + 1];
      const Real a = (args[r - 1] - left) / (right - left);
      work[j] = (Real(1) - a) * work[j - 1] + a * work[j];
    }
  }
  return work[degree];
}

// Bezier points of one row of control points over [lower, upper] by the polynomial of span k.
std::vector<Vec4> bezier_points(std::span<const double> knots, std::span<const Vec4> ctrl, int degree,
                                const Span& span, std::vector<Vec4>& work) {
  std::vector<Vec4> out(degree + 1);
  std::vector<Real> args(degree);
  for (int j = 0; j <= degree; ++j) {
    for (int i = 0; i < degree; ++i) args[i] = i < degree - j ? span.lower : span.upper;
    out[j] = blossom(knots, ctrl, degree, span.index, args, work);
  }
  return out;
}

// Index i of the distinct knot span [knots[i], knots[i + 1]] that holds u; the first or last when beyond.
std::size_t span_of(std::span<const double> knots, double u) {
  auto it = std::upper_bound(knots.begin(), knots.end(), u);
  if (it == knots.end()) it = std::lower_bound(knots.begin(), knots.end(), knots.back());
  if (it == knots.begin()) it = std::upper_bound(knots.begin(), knots.end(), knots.front());
  return static_cast<std::size_t>(it - knots.begin()) - 1;
}

// De Casteljau: the point and the derivative of one row.
void casteljau(std::vector<Vec4>& row, Real x, Vec4& point, Vec4& derivative) {
  const int degree = static_cast<int>(row.size()) - 1;
  if (degree == 0) {
    point = row[0], derivative = Vec4(0);
    return;
  }
  for (int r = 1; r < degree; ++r)
    for (int i = 0; i <= degree - r; ++i) row[i] = (Real(1) - x) * row[i] + x * row[i + 1];
  point = (Real(1) - x) * row[0] + x * row[1];
  derivative = Real(degree) * (row[1] - row[0]);
}

}  // namespace

std::vector<Span> spans_over(std::span<const double> knots, int degree, double lower, double upper) {
  std::vector<Span> spans;
  const int last = static_cast<int>(knots.size()) - degree - 1;
  for (int k = degree; k < last; ++k)
    if (knots[k] < knots[k + 1]) spans.push_back({k, knots[k], knots[k + 1]});
  if (spans.empty()) return spans;
  spans.front().lower = std::min(spans.front().lower, lower);
  spans.back().upper = std::max(spans.back().upper, upper);
  std::vector<Span> out;
  for (Span s : spans) {
    s.lower = std::max(s.lower, lower), s.upper = std::min(s.upper, upper);
    if (s.lower < s.upper) out.push_back(s);
  }
  return out;
}

Patch extract(const nurbs::NurbsStore& store, const nurbs::Surface& surface, const Span& u, const Span& v,
              const Vec3& origin) {
  const std::span<const double> knots_u(&store.knots[surface.knots_u.begin], surface.knots_u.size());
  const std::span<const double> knots_v(&store.knots[surface.knots_v.begin], surface.knots_v.size());
  const int p = surface.degree_u, q = surface.degree_v;
  Patch patch{p, q, u.lower, u.upper, v.lower, v.upper, {}};
  patch.ctrl.resize((p + 1) * (q + 1));
  std::vector<Vec4> work;

  // Along v first, only for the rows of control points that span u needs, then along u.
  std::vector<std::vector<Vec4>> rows;
  for (int iu = u.index - p; iu <= u.index; ++iu) {
    std::vector<Vec4> ctrl(surface.count_v, Vec4(0));
    for (int iv = v.index - q; iv <= v.index; ++iv) {
      const Vec4 h(store.ctrl_h[surface.ctrl.begin + iu * surface.count_v + iv]);
      ctrl[iv] = Vec4(Vec3(h) - h.w * origin, h.w);
    }
    rows.push_back(bezier_points(knots_v, ctrl, q, v, work));
  }
  for (int j = 0; j <= q; ++j) {
    std::vector<Vec4> column(surface.count_u, Vec4(0));
    for (int i = 0; i <= p; ++i) column[u.index - p + i] = rows[i][j];
    const std::vector<Vec4> points = bezier_points(knots_u, column, p, u, work);
    for (int i = 0; i <= p; ++i) patch.ctrl[i * (q + 1) + j] = points[i];
  }
  return patch;
}

PatchPoint evaluate(const Patch& patch, Real x, Real y) {
  std::vector<Vec4> points(patch.p + 1), slopes(patch.p + 1), row;
  for (int i = 0; i <= patch.p; ++i) {
    row.assign(patch.ctrl.begin() + i * (patch.q + 1), patch.ctrl.begin() + (i + 1) * (patch.q + 1));
    casteljau(row, y, points[i], slopes[i]);
  }
  PatchPoint out;
  Vec4 unused;
  casteljau(points, x, out.h, out.hx);
  casteljau(slopes, x, out.hy, unused);
  return out;
}

double to_nurbs(std::span<const double> knots, nurbs::ParamMap map, double u) {
  if (map == nurbs::ParamMap::kIdentity) return u;
  const std::size_t i = span_of(knots, u);
  const Real a = knots[i], d = knots[i + 1] - a, m = a + d / 2;
  const Real ratio = map == nurbs::ParamMap::kCircular ? std::tan((u - m) / 2) / std::tan(d / 4)
                                                       : std::tanh((u - m) / 2) / std::tanh(d / 4);
  return static_cast<double>(a + d / 2 * (1 + ratio));
}

double to_face(std::span<const double> knots, nurbs::ParamMap map, double s) {
  if (map == nurbs::ParamMap::kIdentity) return s;
  const std::size_t i = span_of(knots, s);
  const Real a = knots[i], d = knots[i + 1] - a, m = a + d / 2;
  const Real x = 2 * (s - a) / d - 1;
  return static_cast<double>(map == nurbs::ParamMap::kCircular ? m + 2 * std::atan(x * std::tan(d / 4))
                                                               : m + 2 * std::atanh(x * std::tanh(d / 4)));
}

}  // namespace trimray::reference
