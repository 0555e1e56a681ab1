// Axis-aligned boxes.
#pragma once

#include "core/base/types.h"

namespace trimray {

// Closed box; empty when any lower bound exceeds the upper one (the state after construction).
template <typename Vec>
struct Box {
  Vec lower{kInf};
  Vec upper{-kInf};

  bool empty() const { return glm::any(glm::greaterThan(lower, upper)); }
  void add(const Vec& p) { lower = glm::min(lower, p), upper = glm::max(upper, p); }
  void add(const Box& b) { lower = glm::min(lower, b.lower), upper = glm::max(upper, b.upper); }
  void dilate(double margin) { lower -= Vec(margin), upper += Vec(margin); }
  Vec center() const { return 0.5 * (lower + upper); }
  Vec extent() const { return upper - lower; }
  double diagonal() const { return empty() ? 0.0 : glm::length(extent()); }
  bool contains(const Vec& p) const {
    for (int a = 0; a < Vec::length(); ++a)
      if (!(lower[a] <= p[a] && p[a] <= upper[a])) return false;
    return true;
  }
};

using Box2 = Box<dvec2>;
using Box3 = Box<dvec3>;

// The parallelepiped {center + x axis[0] + y axis[1] + z axis[2] : |x|, |y|, |z| <= 1}.
struct OrientedBox {
  dvec3 center{0.0}, axis[3] = {dvec3(0.0), dvec3(0.0), dvec3(0.0)};
};

}  // namespace trimray
