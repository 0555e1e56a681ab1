// Ranges of derivatives against derivatives at random places.
#include "core/tess/derivative_range.h"

#include <gtest/gtest.h>

#include "tests/core/tess/derivative_checks.h"

namespace trimray::tess {
namespace {

using nurbs::Random;

TEST(DerivativeRange, ClosedFormsHoldTheirDerivatives) {
  Random random(2);
  for (int k = 0; k < 500; ++k) {
    const auto s = nurbs::random_closed_form(random, k % 5);
    const Chart chart(s.store, s.surface());
    const Box2 box = nurbs::box_in(random, s.box);
    expect_holds(random, s, chart, box, closed_form_range(s.surface(), box));
  }
}

TEST(DerivativeRange, PatchesHoldTheirDerivatives) {
  Random random(3);
  for (int k = 0; k < 400; ++k) {
    const int p = 1 + static_cast<int>(random() % 5), q = 1 + static_cast<int>(random() % 5);
    const bool rational = k % 2 == 0;
    const auto form = nurbs::random_patch(random, p, q, nurbs::uniform(random, 0.0, 2.0), rational);
    const auto s = nurbs::in_store(form, {{0, 0}, {1, 1}}, std::to_string(p) + " x " + std::to_string(q));
    const Chart chart(s.store, s.surface());
    expect_holds(random, s, chart, s.box, patch_range(form.ctrl_h.data(), p, q, {1.0, 1.0}, rational));
  }
}

// N / w has a pole where w does: there is no bound, and none must be claimed.
TEST(DerivativeRange, WeightsThatAreNotPositiveLeaveNothingKnown) {
  Random random(5);
  for (const double weight : {0.0, -0.5}) {
    auto form = nurbs::random_patch(random, 3, 2, 1.0, true);
    form.ctrl_h[4].w = weight;
    const DerivativeRange r = patch_range(form.ctrl_h.data(), 3, 2, {1.0, 1.0}, true);
    for (const Box3& box : {r.uu, r.uv, r.vv})
      for (int d = 0; d < 3; ++d) EXPECT_TRUE(box.lower[d] == -kInf && box.upper[d] == kInf);
    EXPECT_EQ(r.su, kInf);
    EXPECT_EQ(r.sv, kInf);
  }
}

// The extent is what a unit of the patch's own [0, 1]^2 measures in the chart.
TEST(DerivativeRange, ScalesWithTheExtent) {
  Random random(4);
  const auto form = nurbs::random_patch(random, 3, 2, 1.0, true);
  const auto unit = patch_range(form.ctrl_h.data(), 3, 2, {1.0, 1.0}, true),
             wide = patch_range(form.ctrl_h.data(), 3, 2, {2.0, 4.0}, true);
  EXPECT_NEAR(wide.uu.upper.z, unit.uu.upper.z / 4.0, 1e-12);
  EXPECT_NEAR(wide.uv.lower.x, unit.uv.lower.x / 8.0, 1e-12);
  EXPECT_NEAR(wide.vv.upper.y, unit.vv.upper.y / 16.0, 1e-12);
  EXPECT_NEAR(wide.su, unit.su / 2.0, 1e-12);
  EXPECT_NEAR(wide.sv, unit.sv / 4.0, 1e-12);
}

// Weights that are all the same change nothing.
TEST(DerivativeRange, RationalFormOfAPolynomialIsAsTight) {
  Random random(5);
  const auto form = nurbs::random_patch(random, 3, 3, 1.0, false);
  const auto a = patch_range(form.ctrl_h.data(), 3, 3, {1, 1}, false),
             b = patch_range(form.ctrl_h.data(), 3, 3, {1, 1}, true);
  EXPECT_LT(glm::length(a.uu.lower - b.uu.lower) + glm::length(a.uv.upper - b.uv.upper), 1e-11);
}

}  // namespace
}  // namespace trimray::tess
