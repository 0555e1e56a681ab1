// Intervals that hold what rounding adds: enough arithmetic to enclose an offset surface over a box.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/types.h"

namespace trimray::trace {

struct Interval {
  double lo = 0.0, hi = 0.0;
  // Widened by more than the one rounding that made it.
  static Interval outward(double lo, double hi) {
    return {lo - 4e-16 * std::fabs(lo) - 1e-300, hi + 4e-16 * std::fabs(hi) + 1e-300};
  }
  bool has_zero() const { return !(lo > 0.0) && !(hi < 0.0); }  // NaN: true
  double magnitude() const { return std::max(std::fabs(lo), std::fabs(hi)); }
};
inline Interval operator+(const Interval& a, const Interval& b) {
  return Interval::outward(a.lo + b.lo, a.hi + b.hi);
}
inline Interval operator-(const Interval& a, const Interval& b) {
  return Interval::outward(a.lo - b.hi, a.hi - b.lo);
}
inline Interval operator*(const Interval& a, const Interval& b) {
  const double x = a.lo * b.lo, y = a.lo * b.hi, z = a.hi * b.lo, w = a.hi * b.hi;
  return Interval::outward(std::min(std::min(x, y), std::min(z, w)),
                           std::max(std::max(x, y), std::max(z, w)));
}
inline Interval operator*(double s, const Interval& a) { return Interval{s, s} * a; }
// 1 / a for a > 0.
inline Interval inverse(const Interval& a) { return Interval::outward(1.0 / a.hi, 1.0 / a.lo); }
inline Interval square(const Interval& a) {
  const double x = a.lo * a.lo, y = a.hi * a.hi;
  return Interval::outward(a.has_zero() ? 0.0 : std::min(x, y), std::max(x, y));
}

struct Interval3 {
  Interval x, y, z;
};
inline Interval3 operator+(const Interval3& a, const Interval3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Interval3 operator-(const Interval3& a, const Interval3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Interval3 operator*(const Interval& s, const Interval3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Interval3 operator*(double s, const Interval3& a) { return Interval{s, s} * a; }
inline Interval dot(const Interval3& a, const Interval3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Interval dot(const dvec3& a, const Interval3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Interval3 cross(const Interval3& a, const Interval3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace trimray::trace
