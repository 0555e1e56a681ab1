#include "core/tess/delaunay.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "tests/core/tess/random_loops.h"

namespace trimray::tess {
namespace {

using nurbs::Random;

double turn(dvec2 a, dvec2 b, dvec2 c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

struct Polygons {
  std::vector<dvec2> points;
  std::vector<std::array<int, 2>> sides;
  double area = 0.0;

  void add(const std::vector<dvec2>& loop) {
    const int first = static_cast<int>(points.size()), n = static_cast<int>(loop.size());
    for (int i = 0; i < n; ++i) {
      points.push_back(loop[i]);
      sides.push_back({first + i, first + (i + 1) % n});
      area += 0.5 * (loop[i].x * loop[(i + 1) % n].y - loop[i].y * loop[(i + 1) % n].x);
    }
  }
};

double area_of(const std::vector<dvec2>& points, const Delaunay& d) {
  double area = 0.0;
  for (const auto& t : d.triangles) {
    const double a = 0.5 * turn(points[t[0]], points[t[1]], points[t[2]]);
    EXPECT_GT(a, 0.0);
    area += a;
  }
  return area;
}

// All of the inside once, every side a side of one triangle.
TEST(Delaunay, CoversPolygonsWithHolesAndInnerPoints) {
  Random random(41);
  for (int k = 0; k < 100; ++k) {
    Polygons p;
    p.add(nurbs::star(random, {0, 0}, 1.0, 12 + static_cast<int>(random() % 60), 0.8));
    for (int h = 0; h < k % 4; ++h) {
      auto hole = nurbs::star(random, {0.3 * std::cos(2.1 * h), 0.3 * std::sin(2.1 * h)}, 0.15,
                              3 + static_cast<int>(random() % 20), 0.3);
      std::reverse(hole.begin(), hole.end());
      p.add(hole);
    }
    std::vector<dvec2> points = p.points;
    for (int i = 0; i < k; ++i)  // around the holes
      points.push_back(nurbs::uniform(random, 0.47, 0.55) *
                       dvec2(std::cos(i * 1.0 + 0.01 * k), std::sin(i * 1.0 + 0.01 * k)));
    const Delaunay d = triangulate(points, p.sides);
    ASSERT_EQ(d.outcome, Delaunay::Outcome::kDone);
    EXPECT_NEAR(area_of(points, d), p.area, 1e-12);
    std::set<std::array<int, 2>> sides;
    std::set<int> used;
    for (const auto& t : d.triangles)
      for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(sides.insert({t[i], t[(i + 1) % 3]}).second);
        used.insert(t[i]);
      }
    for (const auto& s : p.sides) EXPECT_TRUE(sides.count(s) && !sides.count({s[1], s[0]}));
    EXPECT_EQ(used.size(), points.size());
  }
}

// Against every pair of sides; on a grid of integers, where products are exact.
TEST(Delaunay, NamesSidesThatCross) {
  Random random(42);
  int crossing = 0;
  for (int k = 0; k < 200; ++k) {
    Polygons p;
    std::vector<dvec2> loop;
    std::set<std::pair<int, int>> taken;
    const int n = 4 + k % 8;
    while (static_cast<int>(loop.size()) < n) {
      const int x = static_cast<int>(random() % 40), y = static_cast<int>(random() % 40);
      if (taken.insert({x, y}).second) loop.emplace_back(x, y);
    }
    p.add(loop);
    std::vector<std::pair<int, int>> expected;
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) {
        const dvec2 a = p.points[p.sides[i][0]], b = p.points[p.sides[i][1]], c = p.points[p.sides[j][0]],
                    d = p.points[p.sides[j][1]];
        if (turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0)
          expected.push_back({i, j});
      }
    const Delaunay d = triangulate(p.points, p.sides);
    if (expected.empty()) continue;
    ++crossing;
    ASSERT_EQ(d.outcome, Delaunay::Outcome::kCrossing);
    // Those that only touch may be named besides.
    EXPECT_TRUE(std::includes(d.crossings.begin(), d.crossings.end(), expected.begin(), expected.end()));
  }
  EXPECT_GT(crossing, 100);
}

TEST(Delaunay, NamesASideThatRunsThroughAPoint) {
  // The spike's tip lies on the opposite side.
  const std::vector<dvec2> points{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}};
  const Delaunay d = triangulate(points, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 0}});
  ASSERT_EQ(d.outcome, Delaunay::Outcome::kCrossing);
  EXPECT_EQ(d.crossings, (std::vector<std::pair<int, int>>{{0, 2}, {0, 3}}));
}

TEST(Delaunay, ASideThatStandsTwiceHasMaterialOnBothSides) {
  // A square with a cut from its corner to its middle.
  const std::vector<dvec2> points{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {2, 2}};
  const Delaunay d = triangulate(points, {{0, 4}, {4, 0}, {0, 1}, {1, 2}, {2, 3}, {3, 0}});
  ASSERT_EQ(d.outcome, Delaunay::Outcome::kDone);
  EXPECT_NEAR(area_of(points, d), 16.0, 1e-12);
}

TEST(Delaunay, MakesPointsWhereSidesCross) {
  // A bow tie: two triangles that meet in the middle.
  std::vector<dvec2> points{{0, 0}, {4, 4}, {4, 0}, {0, 4}};
  const Delaunay d = triangulate_crossing(points, {{0, 1}, {1, 2}, {2, 3}, {3, 0}});
  ASSERT_EQ(d.outcome, Delaunay::Outcome::kDone);
  ASSERT_EQ(points.size(), 5u);
  EXPECT_EQ(points[4], dvec2(2, 2));
  EXPECT_NEAR(area_of(points, d), 8.0, 1e-12);
}

TEST(Delaunay, FailsOnWhatEnclosesNothing) {
  EXPECT_EQ(triangulate({{0, 0}, {1, 0}, {0, 1}}, {}).outcome, Delaunay::Outcome::kFailed);
  EXPECT_EQ(triangulate({{0, 0}, {1, 0}, {2, 0}}, {{0, 1}, {1, 2}}).outcome, Delaunay::Outcome::kFailed);
}

}  // namespace
}  // namespace trimray::tess
