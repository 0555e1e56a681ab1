// Nearest points of segments and triangles.
#pragma once

#include <algorithm>

#include "core/base/types.h"

namespace trimray {

inline dvec3 closest_on_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 d = b - a;
  const double length = glm::dot(d, d);
  const double x = length > 0.0 ? std::clamp(glm::dot(p - a, d) / length, 0.0, 1.0) : 0.0;
  return x < 1.0 ? a + x * d : b;
}

struct TrianglePoint {
  dvec3 p{0.0};
  double weight_b = 0.0, weight_c = 0.0;  // of the second and the third corner
};

// Voronoi regions of the triangle's features; section 5.1.5, C. Ericson, "Real-Time Collision Detection".
// A needle counts as its sides.
inline TrianglePoint closest_on_triangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 ab = b - a, ac = c - a, n = glm::cross(ab, ac);
  const double area = glm::dot(n, n);
  if (area > 1e-24 * glm::dot(ab, ab) * glm::dot(ac, ac)) {
    const double wb = glm::dot(glm::cross(p - a, ac), n), wc = glm::dot(glm::cross(ab, p - a), n);
    if (wb >= 0.0 && wc >= 0.0 && wb + wc <= area) {
      const dvec3 foot = p - glm::dot(p - a, n) / area * n;
      return {foot, wb / area, wc / area};
    }
  }
  TrianglePoint best;
  double least = kInf;
  const auto side = [&](const dvec3& from, const dvec3& to, int which) {
    const dvec3 q = closest_on_segment(p, from, to);
    const double d = glm::dot(q - p, q - p);
    if (!(d < least)) return;
    least = d;
    const double length = glm::distance(from, to), x = length > 0.0 ? glm::distance(from, q) / length : 0.0;
    best = {q, which == 0 ? x : which == 1 ? 1.0 - x : 0.0, which == 1 ? x : which == 2 ? 1.0 - x : 0.0};
  };
  side(a, b, 0), side(b, c, 1), side(c, a, 2);
  return best;
}

}  // namespace trimray
