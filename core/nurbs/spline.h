// B-spline curves with homogeneous control points, and the one operation behind knot insertion, clamping,
// restriction and extension: the blossom of a span's polynomial (Ramshaw 1987).
//
// H is the homogeneous vector: dvec4 (w x, w y, w z, w) in space, dvec3 (w u, w v, w) in a uv plane.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/nurbs/knot_vector.h"

namespace trimray::nurbs {

// knots: flat, size ctrl.size() + degree + 1.
template <typename H>
struct SplineCurve {
  int degree = 1;
  std::vector<double> knots;
  std::vector<H> ctrl;
  ParamMap map = ParamMap::kIdentity;
  double begin() const { return knots[degree]; }
  double end() const { return knots[ctrl.size()]; }
};

inline dvec3 project(const dvec4& h) { return dvec3(h.x, h.y, h.z) / h.w; }
inline dvec2 project(const dvec3& h) { return dvec2(h.x, h.y) / h.z; }

// The multi-affine form of the polynomial on `span` at degree arguments x, symmetric in exact arithmetic. In
// the order of sort_arguments every step that counts is a convex combination, unless an argument lies
// outside the knots, and a control point comes out bit-exact when the arguments are its knots.
template <typename H>
H blossom(const double* knots, int degree, int span, const H* ctrl, std::ptrdiff_t stride, const double* x) {
  H d[kMaxDegree + 1];
  for (int i = 0; i <= degree; ++i) d[i] = ctrl[(span - degree + i) * stride];
  for (int r = 1; r <= degree; ++r) {
    const double at = x[r - 1];
    for (int i = degree; i >= r; --i) {
      const double lo = knots[span - degree + i], hi = knots[span + i - r + 1];
      if (at == lo)
        d[i] = d[i - 1];
      else if (at != hi)
        d[i] = ((hi - at) * d[i - 1] + (at - lo) * d[i]) / (hi - lo);
    }
  }
  return d[degree];
}

// The order for blossom: arguments at or behind the span's end descending, those at or before its begin
// ascending, the ones inside last. In any other order uneven knots make far extrapolations that cancel.
void sort_arguments(std::span<const double> knots, int degree, int span, double* x);

// Bezier control points of every non-empty span, degree + 1 each, appended to out.
template <typename H>
void append_bezier(std::span<const double> knots, int degree, const H* ctrl, std::ptrdiff_t stride,
                   std::vector<H>& out) {
  const int count = static_cast<int>(knots.size()) - degree - 1;
  double x[kMaxDegree];
  for (int span = degree; span < count; ++span) {
    const double a = knots[span], b = knots[span + 1];
    if (!(b > a)) continue;
    const bool bezier = knots[span - degree + 1] == a && knots[span + degree] == b;
    for (int i = 0; i <= degree; ++i) {
      if (bezier) {
        out.push_back(ctrl[(span - degree + i) * stride]);
        continue;
      }
      for (int k = 0; k < degree; ++k) x[k] = k < degree - i ? a : b;
      out.push_back(blossom(knots.data(), degree, span, ctrl, stride, x));
    }
  }
}

// How the control points of a spline over [a, b] come from those of the same spline over its own knots.
struct Respan {
  std::vector<double> knots;  // clamped, over exactly [a, b]
  std::vector<int> spans;     // per new control point: the old span whose blossom gives it, or
  std::vector<int> copies;    // the old control point that it equals (-1: use the blossom)
  int count() const { return static_cast<int>(spans.size()); }
};

// [a, b] may be larger than the natural domain: the end spans' polynomials continue. Inner knots of
// multiplicity above degree are the caller's to refuse.
Respan plan_respan(std::span<const double> knots, int degree, double a, double b);

template <typename H>
void apply_respan(const Respan& plan, std::span<const double> knots, int degree, const H* ctrl,
                  std::ptrdiff_t stride, H* out, std::ptrdiff_t out_stride) {
  double x[kMaxDegree];
  for (int i = 0; i < plan.count(); ++i) {
    if (plan.copies[i] >= 0) {
      out[i * out_stride] = ctrl[plan.copies[i] * stride];
      continue;
    }
    std::copy_n(&plan.knots[i + 1], degree, x);
    sort_arguments(knots, degree, plan.spans[i], x);
    out[i * out_stride] = blossom(knots.data(), degree, plan.spans[i], ctrl, stride, x);
  }
}

// The curve over [a, b], clamped.
template <typename H>
SplineCurve<H> respan_curve(const SplineCurve<H>& c, double a, double b) {
  const Respan plan = plan_respan(c.knots, c.degree, a, b);
  SplineCurve<H> r;
  r.degree = c.degree, r.map = c.map, r.knots = plan.knots;
  r.ctrl.resize(plan.count());
  apply_respan(plan, c.knots, c.degree, c.ctrl.data(), 1, r.ctrl.data(), 1);
  return r;
}

// Flat knots of a spline from distinct ones; a periodic spline is unrolled so that [a, b] lies in the natural
// domain. wrap[i]: which pole control point i is.
struct FlatKnots {
  std::vector<double> knots;
  std::vector<int> wrap;
};
FlatKnots flatten_knots(std::span<const double> distinct, std::span<const std::int32_t> multiplicities,
                        int degree, int poles, bool periodic, double a, double b);

// de Casteljau in [0, 1]; t may lie outside.
template <typename H>
H bezier_point(const H* ctrl, int degree, double t) {
  H d[kMaxDegree + 1];
  for (int i = 0; i <= degree; ++i) d[i] = ctrl[i];
  for (int r = 1; r <= degree; ++r)
    for (int i = 0; i + r <= degree; ++i) d[i] = (1.0 - t) * d[i] + t * d[i + 1];
  return d[0];
}

}  // namespace trimray::nurbs
