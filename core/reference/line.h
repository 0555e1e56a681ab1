// A ray's whole line in long double, with the two planes whose intersection it is.
#pragma once

#include "core/reference/bezier.h"
#include "core/trace/ray.h"

namespace trimray::reference {

// dir, n1, n2 are orthonormal and right-handed (n1 x n2 = dir), so that a boundary seen counterclockwise in
// (n1, n2) belongs to a surface which the line leaves through its front.
struct Line {
  Vec3 org, dir, n1, n2;
  Real length;  // of the direction as the caller gave it

  Line(const dvec3& o, const dvec3& d) : org(o), dir(d) {
    length = glm::length(dir);
    dir /= length;
    const Vec3 a = glm::abs(dir);
    const Vec3 axis = a.x <= a.y && a.x <= a.z ? Vec3(1, 0, 0) : a.y <= a.z ? Vec3(0, 1, 0) : Vec3(0, 0, 1);
    n1 = glm::normalize(glm::cross(axis, dir));
    n2 = glm::cross(dir, n1);
  }

  // (across 1, across 2, along, weight), each times the weight: the point as the line sees it.
  dvec4 project(const Vec4& h) const {
    const Vec3 p = Vec3(h) - h.w * org;
    return dvec4(glm::dot(n1, p), glm::dot(n2, p), glm::dot(dir, p), h.w);
  }

  // Does the line come within margin of the box? Separating axes would be exact; the slabs suffice here.
  bool meets(const Box3& box, double margin) const {
    Real enter = -kInf, leave = kInf;
    for (int k = 0; k < 3; ++k) {
      const Real lower = Real(box.lower[k]) - margin - org[k], upper = Real(box.upper[k]) + margin - org[k];
      if (std::abs(dir[k]) < 1e-17L) {
        if (lower > 0 || upper < 0) return false;
        continue;
      }
      const Real a = lower / dir[k], b = upper / dir[k];
      enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
  }
};

}  // namespace trimray::reference
