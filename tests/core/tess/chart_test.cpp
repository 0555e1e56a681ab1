#include "core/tess/chart.h"

#include <gtest/gtest.h>

#include "tests/core/tess/random_surfaces.h"

namespace trimray::tess {
namespace {

using nurbs::Random;

nurbs::RandomSurface any_surface(Random& random, int k) {
  return k % 3 == 0 ? nurbs::random_closed_form(random, k / 3 % 10)
                    : nurbs::random_bspline(random, k % 3 == 1, k % 2 == 0);
}

TEST(Chart, MapsToTheFaceAndBack) {
  Random random(31);
  for (int k = 0; k < 90; ++k) {
    const auto s = any_surface(random, k);
    SCOPED_TRACE(s.name);
    const Chart chart(s.store, s.surface());
    for (int i = 0; i < 30; ++i) {
      const dvec2 p = nurbs::uv_in(random, s.box), uv = chart.to_face(p), back = chart.from_face(uv);
      ASSERT_LT(glm::distance(back, p), 1e-12 * (1.0 + glm::length(p)));
      ASSERT_LT(glm::distance(chart.point(p), nurbs::evaluate(s.store, s.surface(), uv).p), 1e-12);
    }
  }
}

// Derivatives are with respect to the chart, whatever the parameter map.
TEST(Chart, DerivativesAreThoseOfItsPoints) {
  Random random(32);
  for (int k = 0; k < 90; ++k) {
    const auto s = any_surface(random, k);
    SCOPED_TRACE(s.name);
    const Chart chart(s.store, s.surface());
    for (int i = 0; i < 20; ++i) {
      const dvec2 p = nurbs::uv_in(random, s.box);
      if (!chart.closed_form() && nurbs::near_knot(s, p)) continue;
      constexpr double h = 1e-5;
      const auto at = chart.at(p);
      const dvec3 du = (chart.point(p + dvec2(h, 0)) - chart.point(p - dvec2(h, 0))) / (2 * h),
                  dv = (chart.point(p + dvec2(0, h)) - chart.point(p - dvec2(0, h))) / (2 * h);
      ASSERT_LT(glm::distance(at.p, chart.point(p)), 1e-12);
      ASSERT_LT(glm::distance(at.du, du), 1e-6 * (1.0 + glm::length(du)));
      ASSERT_LT(glm::distance(at.dv, dv), 1e-6 * (1.0 + glm::length(dv)));
    }
  }
}

// A point of the surface, or one a little above it, is put where it came from.
TEST(Chart, ProjectsToTheFoot) {
  Random random(33);
  for (int k = 0; k < 120; ++k) {
    const auto s = any_surface(random, k);
    SCOPED_TRACE(s.name);
    const Chart chart(s.store, s.surface());
    for (int i = 0; i < 20; ++i) {
      const dvec2 p = s.box.lower + (0.05 + 0.9 * nurbs::uv_in(random, {{0, 0}, {1, 1}})) * s.box.extent();
      const auto at = chart.at(p);
      if (!chart.closed_form() && nurbs::near_knot(s, p)) continue;
      const dvec3 n = glm::normalize(glm::cross(at.du, at.dv));
      const double above = i % 2 == 0 ? 0.0 : nurbs::uniform(random, -1e-4, 1e-4);
      const dvec2 guess = p + 1e-3 * nurbs::uv_in(random, {{-1, -1}, {1, 1}});
      const dvec2 foot = chart.project(at.p + above * n, guess);
      ASSERT_LT(glm::distance(chart.point(foot), at.p), 1e-9);
    }
  }
}

// At a pole the guess says where around it.
TEST(Chart, KeepsTheGuessAtAPole) {
  const auto s = nurbs::in_store(nurbs::make_sphere({}, 2.0), {{0, -1.5}, {6, 1.5}}, "sphere");
  const Chart chart(s.store, s.surface());
  const dvec2 foot = chart.project({0, 0, 2}, {4.0, 1.5});
  EXPECT_EQ(foot.x, 4.0);
  EXPECT_NEAR(foot.y, 0.5 * std::numbers::pi, 1e-12);
}

// Around a period the foot is the one near the guess.
TEST(Chart, StaysOnTheGuesssTurn) {
  const auto s = nurbs::in_store(nurbs::make_cylinder({}, 2.0), {{0, -1}, {6, 1}}, "cylinder");
  const Chart chart(s.store, s.surface());
  const double turn = 2.0 * std::numbers::pi;
  for (const double u : {-0.1, 0.1, turn - 0.1, turn + 0.1, 3 * turn})
    EXPECT_NEAR(chart.project(chart.point({u, 0.5}), {u + 0.05, 0.4}).x, u, 1e-12);
}

}  // namespace
}  // namespace trimray::tess
