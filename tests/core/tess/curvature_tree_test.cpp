// Bounds over any box of a chart against derivatives at random places.
#include "core/tess/curvature_tree.h"

#include <gtest/gtest.h>

#include "tests/core/tess/derivative_checks.h"

namespace trimray::tess {
namespace {

using nurbs::Random;

TEST(CurvatureTree, HoldsTheDerivativesOverAnyBox) {
  Random random(6);
  for (int k = 0; k < 150; ++k) {
    const auto s = k % 3 == 0 ? nurbs::random_closed_form(random, k / 3 % 5)
                              : nurbs::random_bspline(random, k % 3 == 1, k % 2 == 0);
    const Chart chart(s.store, s.surface());
    const UniformTolerance tolerance(std::pow(10.0, nurbs::uniform(random, -4.0, 0.0)));
    const CurvatureTree tree(s.store, chart, s.box, tolerance, kInf);
    for (int i = 0; i < 8; ++i) {
      const Box2 box = nurbs::box_in(random, s.box);
      const CurvatureRange sharp = tree.over(box), blunt = tree.over(box, false);
      expect_holds(random, s, chart, box, sharp.second);
      expect_holds(random, s, chart, box, blunt.second);
      EXPECT_EQ(sharp.kinks, blunt.kinks);
    }
  }
}

// What second derivatives and kinks together say of a straight interpolation along u or v.
TEST(CurvatureTree, KinksAreNoMoreThanCounted) {
  Random random(7);
  int kinked = 0;
  for (int k = 0; k < 150; ++k) {
    const auto s = nurbs::random_bspline(random, k % 2 == 0, true);
    SCOPED_TRACE(s.name);
    const Chart chart(s.store, s.surface());
    const UniformTolerance tolerance(0.05);
    const CurvatureTree tree(s.store, chart, s.box, tolerance, kInf);
    for (int i = 0; i < 20; ++i) {
      const Box2 box = nurbs::box_in(random, s.box);
      const int d = i % 2;
      dvec2 a = box.center(), b = a;
      a[d] = box.lower[d], b[d] = box.upper[d];
      Box2 line;
      line.add(a), line.add(b);
      const CurvatureRange range = tree.over(line);
      kinked += range.kinks > 0;
      const dvec3 n = glm::normalize(dvec3(nurbs::uniform(random, -1, 1), nurbs::uniform(random, -1, 1), 1));
      const double length = b[d] - a[d];
      const double bound =
          0.125 * length * length * along(n, d == 0 ? range.second.uu : range.second.vv).magnitude() +
          (range.kinks > 0 ? range.kinks * along(n, range.kink).magnitude() : 0.0);
      for (int j = 1; j < 10; ++j) {
        const double t = j / 10.0;
        const dvec3 gap = chart.point(a + t * (b - a)) - ((1.0 - t) * chart.point(a) + t * chart.point(b));
        ASSERT_LE(std::abs(glm::dot(n, gap)), bound * (1.0 + 1e-9) + 1e-12);
      }
    }
  }
  EXPECT_GT(kinked, 100);
}

TEST(CurvatureTree, LeavesCoverTheFaceWithoutOverlap) {
  Random random(8);
  for (int k = 0; k < 100; ++k) {
    const auto s = k % 2 == 0 ? nurbs::random_closed_form(random, k / 2 % 5)
                              : nurbs::random_bspline(random, k % 4 == 1, true);
    SCOPED_TRACE(s.name);
    const Chart chart(s.store, s.surface());
    const UniformTolerance tolerance(std::pow(10.0, nurbs::uniform(random, -3.0, 0.0)));
    const CurvatureTree tree(s.store, chart, s.box, tolerance, kInf);
    double area = 0.0;
    for (const GridLeaf& leaf : tree.leaves()) {
      area += leaf.box.extent().x * leaf.box.extent().y;
      EXPECT_GE(leaf.count_u, 1);
      EXPECT_GE(leaf.count_v, 1);
    }
    EXPECT_NEAR(area, s.box.extent().x * s.box.extent().y, 1e-9 * area);
  }
}

}  // namespace
}  // namespace trimray::tess
