#include "core/tess/polygon.h"

#include <cmath>

namespace trimray::tess {

namespace {

// Looks at a corner that clipping may take: quadratic time as a rule, cubic at worst.
constexpr std::size_t kMaxLooks = std::size_t{1} << 27;

double cross(const dvec2& a, const dvec2& b, const dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Newell: twice the area, as a vector.
dvec3 area_vector(std::span<const dvec3> points, std::span<const std::int32_t> corners) {
  dvec3 sum{0.0};
  const dvec3& origin = points[corners[0]];
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    sum += glm::cross(points[corners[i]] - origin, points[corners[i + 1]] - origin);
  return sum;
}

struct Flat {
  std::vector<dvec2> at;          // by corner, counter-clockwise
  std::vector<std::size_t> left;  // corners not yet cut off

  // Is the corner at place i of `left` convex, and no other corner inside its triangle?
  bool is_ear(std::size_t i) const {
    const std::size_t n = left.size();
    const std::size_t ia = left[(i + n - 1) % n], ib = left[i], ic = left[(i + 1) % n];
    const dvec2 a = at[ia], b = at[ib], c = at[ic];
    if (!(cross(a, b, c) > 0.0)) return false;
    for (const std::size_t k : left) {
      if (k == ia || k == ib || k == ic) continue;
      const dvec2 p = at[k];
      if (p == a || p == b || p == c) continue;
      if (cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0) return false;
    }
    return true;
  }
};

// Projected along the axis nearest to the normal.
Flat flatten(std::span<const dvec3> points, std::span<const std::int32_t> corners, const dvec3& normal) {
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::fabs(normal[k]) > std::fabs(normal[axis])) axis = k;
  }
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0.0) std::swap(u, v);
  Flat flat;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    flat.at.push_back({points[corners[i]][u], points[corners[i]][v]});
    flat.left.push_back(i);
  }
  return flat;
}

}  // namespace

void triangulate_polygon(std::span<const dvec3> points, std::span<const std::int32_t> corners,
                         std::vector<std::array<std::int32_t, 3>>& triangles) {
  const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    if (a != b && b != c && a != c) triangles.push_back({a, b, c});
  };
  if (corners.size() == 3) return add(corners[0], corners[1], corners[2]);
  const dvec3 normal = area_vector(points, corners);
  if (glm::dot(normal, normal) > 0.0) {
    Flat flat = flatten(points, corners, normal);
    std::size_t i = 0, tried = 0, looks = 0;
    while (flat.left.size() > 3 && tried < flat.left.size() && looks < kMaxLooks) {
      const std::size_t n = flat.left.size();
      looks += n;
      i %= n;
      if (!flat.is_ear(i)) {
        ++i, ++tried;
        continue;
      }
      add(corners[flat.left[(i + n - 1) % n]], corners[flat.left[i]], corners[flat.left[(i + 1) % n]]);
      flat.left.erase(flat.left.begin() + static_cast<std::ptrdiff_t>(i));
      ++i, tried = 0;  // the ears are spread over the polygon rather than cut from one corner
    }
    // What is left has no ear when it crosses itself.
    for (std::size_t k = 1; k + 1 < flat.left.size(); ++k)
      add(corners[flat.left[0]], corners[flat.left[k]], corners[flat.left[k + 1]]);
    return;
  }
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) add(corners[0], corners[k], corners[k + 1]);
}

}  // namespace trimray::tess
