// Are derivatives within the ranges that are claimed for them?
#pragma once

#include <gtest/gtest.h>

#include "core/tess/derivative_range.h"
#include "tests/core/tess/random_surfaces.h"

namespace trimray::tess {

inline bool range_holds(Box3 range, const dvec3& value, double scale) {
  range.dilate(1e-5 * (1.0 + scale));
  return range.contains(value);
}

// Every derivative found at random places of the box is within the range.
inline void expect_holds(nurbs::Random& random, const nurbs::RandomSurface& s, const Chart& chart,
                         const Box2& box, const DerivativeRange& range) {
  SCOPED_TRACE(s.name);
  const double scale = largest(range.uu) + largest(range.uv) + largest(range.vv);
  for (int k = 0; k < 20; ++k) {
    const dvec2 p = nurbs::uv_in(random, box);
    if (!chart.closed_form() && nurbs::near_knot(s, p)) continue;
    const auto second = nurbs::second_derivatives(chart, p);
    ASSERT_TRUE(range_holds(range.uu, second.uu, scale));
    ASSERT_TRUE(range_holds(range.uv, second.uv, scale));
    ASSERT_TRUE(range_holds(range.vv, second.vv, scale));
    const auto at = chart.at(p);
    ASSERT_LE(glm::length(at.du), range.su * (1 + 1e-12));
    ASSERT_LE(glm::length(at.dv), range.sv * (1 + 1e-12));
  }
}

}  // namespace trimray::tess
