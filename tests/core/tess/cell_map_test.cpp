#include "core/tess/cell_map.h"

#include <gtest/gtest.h>

#include "tests/core/tess/random_surfaces.h"

namespace trimray::tess {
namespace {

using nurbs::Random;

void expect_one_to_one(Random& random, const CellMap& map, const Box2& box) {
  const dvec2 size = glm::max(glm::abs(box.lower), glm::abs(box.upper));
  for (int k = 0; k < 200; ++k) {
    // A little outside, too: polygons of samples reach beyond the box.
    const dvec2 p = box.lower + dvec2(nurbs::uniform(random, -0.1, 1.1), nurbs::uniform(random, -0.1, 1.1)) *
                                    box.extent();
    const dvec2 back = map.to_chart(map.to_cells(p));
    ASSERT_NEAR(back.x, p.x, 1e-12 * size.x);
    ASSERT_NEAR(back.y, p.y, 1e-12 * size.y);
  }
  for (int d = 0; d < 2; ++d) {
    dvec2 p = box.lower - 0.1 * box.extent();
    double before = map.to_cells(p)[d];
    for (int k = 0; k < 300; ++k) {
      p[d] += 1.2 * box.extent()[d] / 300;
      const double here = map.to_cells(p)[d];
      ASSERT_GT(here, before);
      before = here;
    }
  }
}

TEST(CellMap, IsStrictlyIncreasingAndInvertible) {
  Random random(21);
  for (int k = 0; k < 120; ++k) {
    const auto s = k % 3 == 0 ? nurbs::random_closed_form(random, 1 + k / 3 % 4)
                              : nurbs::random_bspline(random, k % 3 == 1, k % 2 == 0);
    SCOPED_TRACE(s.name);
    const Chart chart(s.store, s.surface());
    const UniformTolerance tolerance(std::pow(10.0, nurbs::uniform(random, -4.0, 0.0)));
    const CurvatureTree tree(s.store, chart, s.box, tolerance, kInf);
    CellMap map(tree, s.box);
    expect_one_to_one(random, map, s.box);
    map.make_even();
    expect_one_to_one(random, map, s.box);
    // Even: the middle stays the middle.
    const dvec2 middle = map.to_cells(s.box.center()),
                mean = 0.5 * (map.to_cells(s.box.lower) + map.to_cells(s.box.upper));
    EXPECT_NEAR(middle.x, mean.x, 1e-9 * std::abs(mean.x));
    EXPECT_NEAR(middle.y, mean.y, 1e-9 * std::abs(mean.y));
  }
}

TEST(CellMap, DefaultLeavesAllAsItIs) {
  const CellMap map;
  EXPECT_EQ(map.to_cells({3.0, -2.0}), dvec2(3.0, -2.0));
  EXPECT_EQ(map.to_chart({3.0, -2.0}), dvec2(3.0, -2.0));
}

TEST(CellMap, OfAPlaneKeepsShapes) {
  const CellMap map(Box2{{1, 1}, {5, 3}});
  EXPECT_EQ(map.to_cells({5, 3}), dvec2(1.0, 0.5));
  EXPECT_EQ(map.to_cells({1, 1}), dvec2(0.0, 0.0));
}

TEST(CellMap, OfAnEmptyBoxIsTheIdentity) {
  const CellMap map(Box2{{1, 1}, {1, 1}});
  EXPECT_EQ(map.to_cells({7, 8}), dvec2(7, 8));
}

}  // namespace
}  // namespace trimray::tess
