// The torus: a quartic, solved by isolating its roots between the extrema of the polynomial and refining each
// on the product of distances, which keeps its digits where the expanded polynomial has lost them.
#include <algorithm>
#include <cmath>

#include "core/trace/closed_form_local.h"

namespace trimray::trace {
namespace {

// Unit: r1 + r2. The line is centred at its closest approach to the torus's centre, so
//   P(s) = (s^2 + k)^2 - 4 r1^2 rho(s)^2 = s^4 + ...,   P'(s) = 4 (s^3 + p s + q).
struct Quartic {
  double ox, oy, oz, dx, dy, dz, r1, r2, p, q;

  // P as (h- - r2)(h- + r2)(h+ - r2)(h+ + r2), h-+ = distance from the tube's centre line, of the near
  // and of the opposite side. The second sheet (h+ = r2) exists on spindle tori only.
  double value(double s) const {
    const double x = ox + s * dx, y = oy + s * dy, z = oz + s * dz;
    const double rho = std::sqrt(x * x + y * y);
    const double near = std::sqrt((rho - r1) * (rho - r1) + z * z);
    const double far = std::sqrt((rho + r1) * (rho + r1) + z * z);
    return (near - r2) * (near + r2) * (far - r2) * (far + r2);
  }
  double slope(double s) const { return 4.0 * ((s * s + p) * s + q); }
};

// Real roots of s^3 + p s + q, ascending.
int cubic_roots(double p, double q, double* out) {
  const double half = 0.5 * q, third = p / 3.0;
  const double disc = half * half + third * third * third;
  int count = 0;
  if (disc > 0.0) {
    const double root = std::sqrt(disc);
    const double u = std::cbrt(half > 0.0 ? -half - root : -half + root);
    out[count++] = u == 0.0 ? 0.0 : u - third / u;
  } else if (third == 0.0) {
    out[count++] = 0.0;
  } else {
    const double m = std::sqrt(-third);
    const double phi = std::acos(std::clamp(-half / (m * m * m), -1.0, 1.0)) / 3.0;
    for (int k = 2; k >= 0; --k) out[count++] = 2.0 * m * std::cos(phi + (kTwoPi / 3.0) * k);
    std::sort(out, out + count);
  }
  for (int i = 0; i < count; ++i) {
    for (int step = 0; step < 2; ++step) {
      const double slope = 3.0 * out[i] * out[i] + p;
      const double move = ((out[i] * out[i] + p) * out[i] + q) / slope;
      if (std::isfinite(move) && std::abs(move) < 0.1) out[i] -= move;
    }
  }
  std::sort(out, out + count);
  return count;
}

// The one root in (a, b) where value(a) and value(b) differ in sign: Newton's steps kept inside the
// bracket, halving where they leave it or converge slowly.
double refine(const Quartic& f, double a, double b, bool negative_at_a) {
  double s = 0.5 * (a + b), last = b - a;
  for (int step = 0; step < 100; ++step) {
    const double value = f.value(s);
    if (value == 0.0) return s;
    if ((value < 0.0) == negative_at_a)
      a = s;
    else
      b = s;
    const double move = value / f.slope(s);
    double next = s - move;
    if (!(next > a && next < b) || std::abs(move) > 0.5 * last) next = 0.5 * (a + b);
    last = std::abs(next - s);
    s = next;
    if (last <= 4e-17 + 2e-16 * std::abs(s)) break;
  }
  return s;
}

}  // namespace

int torus_roots(const ClosedForm& form, const LocalRay& ray, LocalRoot* out) {
  const double unit = form.r1 + form.r2;
  const double shift = -(ray.ox * ray.dx + ray.oy * ray.dy + ray.oz * ray.dz);
  Quartic f;
  f.ox = (ray.ox + shift * ray.dx) / unit, f.oy = (ray.oy + shift * ray.dy) / unit;
  f.oz = (ray.oz + shift * ray.dz) / unit;
  f.dx = ray.dx, f.dy = ray.dy, f.dz = ray.dz;
  f.r1 = form.r1 / unit, f.r2 = form.r2 / unit;
  const double distance2 = f.ox * f.ox + f.oy * f.oy + f.oz * f.oz;
  // The torus lies inside the unit ball; outside of it P > 0.
  const double end = std::sqrt(std::max(0.0, 1.0 + 1e-6 - distance2));
  if (end == 0.0) return 0;
  const double k = distance2 + f.r1 * f.r1 - f.r2 * f.r2;
  f.p = k - 2.0 * f.r1 * f.r1 * (f.dx * f.dx + f.dy * f.dy);
  f.q = -2.0 * f.r1 * f.r1 * (f.ox * f.dx + f.oy * f.dy);

  // Between two neighbouring extrema the polynomial is monotone: one root where the sign changes. Near a
  // tangent ray the sign at one extremum decides for both roots at once.
  double stops[5] = {-end};
  double extrema[3];
  int n = 1;
  const int extremum_count = cubic_roots(f.p, f.q, extrema);
  for (int i = 0; i < extremum_count; ++i)
    if (extrema[i] > -end && extrema[i] < end) stops[n++] = extrema[i];
  stops[n++] = end;
  int count = 0;
  bool negative = false;
  for (int i = 1; i < n; ++i) {
    const bool next_negative = i + 1 < n && f.value(stops[i]) < 0.0;
    if (next_negative != negative) {
      const double s = refine(f, stops[i - 1], stops[i], negative);
      out[count++] = {shift + unit * s, unit * (f.ox + s * f.dx), unit * (f.oy + s * f.dy),
                      unit * (f.oz + s * f.dz)};
    }
    negative = next_negative;
  }
  return count;
}

}  // namespace trimray::trace
