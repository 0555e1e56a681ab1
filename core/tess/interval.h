// Interval arithmetic on numbers and on vectors, as far as bounds on derivatives need it. Rounding is not
// directed: what it can add is 1e-15 of the numbers, far below the tolerances that are compared with.
#pragma once

#include <algorithm>

#include "core/base/box.h"

namespace trimray::tess {

struct Interval {
  double lo = 0.0, hi = 0.0;
  double magnitude() const { return std::max(-lo, hi); }
};

inline Interval operator+(Interval a, Interval b) { return {a.lo + b.lo, a.hi + b.hi}; }
inline Interval operator-(Interval a) { return {-a.hi, -a.lo}; }
inline Interval operator*(double s, Interval a) {
  return s < 0.0 ? Interval{s * a.hi, s * a.lo} : Interval{s * a.lo, s * a.hi};
}
inline Interval operator*(Interval a, Interval b) {
  const double p = a.lo * b.lo, q = a.lo * b.hi, r = a.hi * b.lo, s = a.hi * b.hi;
  return {std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s))};
}

inline Box3 operator+(const Box3& a, const Box3& b) { return {a.lower + b.lower, a.upper + b.upper}; }
inline Box3 operator-(const Box3& a, const Box3& b) { return {a.lower - b.upper, a.upper - b.lower}; }
inline Box3 operator*(double s, const Box3& a) {
  return s < 0.0 ? Box3{s * a.upper, s * a.lower} : Box3{s * a.lower, s * a.upper};
}
inline Box3 operator*(Interval s, const Box3& a) {
  const dvec3 p = s.lo * a.lower, q = s.lo * a.upper, r = s.hi * a.lower, t = s.hi * a.upper;
  return {glm::min(glm::min(p, q), glm::min(r, t)), glm::max(glm::max(p, q), glm::max(r, t))};
}
inline Box3 operator*(Interval s, const dvec3& a) {
  return {glm::min(s.lo * a, s.hi * a), glm::max(s.lo * a, s.hi * a)};
}

// n . x for x in the box.
inline Interval along(const dvec3& n, const Box3& box) {
  const double middle = glm::dot(n, box.center()), half = glm::dot(glm::abs(n), 0.5 * box.extent());
  return {middle - half, middle + half};
}

// The largest length of a vector in the box.
inline double largest(const Box3& box) {
  return glm::length(glm::max(glm::abs(box.lower), glm::abs(box.upper)));
}

}  // namespace trimray::tess
