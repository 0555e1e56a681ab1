// Nearest points of segments and triangles, and distances from them.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/types.h"

namespace trimray {

inline dvec3 closest_on_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 d = b - a;
  const double length = glm::dot(d, d);
  const double x = length > 0.0 ? std::clamp(glm::dot(p - a, d) / length, 0.0, 1.0) : 0.0;
  return x < 1.0 ? a + x * d : b;
}

// The foot of a point in a triangle's plane, by the signs of section 5.1.5, C. Ericson, "Real-Time Collision
// Detection".
struct PlaneFoot {
  bool within = false;  // the triangle. Of a needle the normal is noise: never, its sides say it all
  dvec3 n{0.0};         // across the plane
  double nn = 0.0;      // dot(n, n), of which b and c are the shares of the second and the third corner
  double b = 0.0, c = 0.0;
};

inline PlaneFoot foot_in_plane(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 ab = b - a, ac = c - a, n = glm::cross(ab, ac);
  PlaneFoot foot{false, n, glm::dot(n, n)};
  if (!(foot.nn > 1e-24 * glm::dot(ab, ab) * glm::dot(ac, ac))) return foot;
  foot.b = glm::dot(glm::cross(p - a, ac), n), foot.c = glm::dot(glm::cross(ab, p - a), n);
  foot.within = foot.b >= 0.0 && foot.c >= 0.0 && foot.b + foot.c <= foot.nn;
  return foot;
}

struct TrianglePoint {
  dvec3 p{0.0};
  double weight_b = 0.0, weight_c = 0.0;  // of the second and the third corner
};

inline TrianglePoint closest_on_triangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const PlaneFoot foot = foot_in_plane(p, a, b, c);
  if (foot.within)
    return {p - glm::dot(p - a, foot.n) / foot.nn * foot.n, foot.b / foot.nn, foot.c / foot.nn};
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

// Exact to rounding of the distance itself, however small that is beside the coordinates.
inline double distance_to_triangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const PlaneFoot foot = foot_in_plane(p, a, b, c);
  if (foot.within) return std::abs(glm::dot(p - a, foot.n)) / std::sqrt(foot.nn);
  const auto side = [&](const dvec3& from, const dvec3& to) {
    return glm::distance(p, closest_on_segment(p, from, to));
  };
  return std::min({side(a, b), side(b, c), side(c, a)});
}

}  // namespace trimray
