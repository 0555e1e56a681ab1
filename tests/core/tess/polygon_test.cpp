#include "core/tess/polygon.h"

#include <gtest/gtest.h>

#include "tests/core/tess/random_loops.h"

namespace trimray::tess {
namespace {

using nurbs::Random;
using Triangles = std::vector<std::array<std::int32_t, 3>>;

dvec3 area_vector(const std::vector<dvec3>& p, const std::array<std::int32_t, 3>& t) {
  return 0.5 * glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
}

std::vector<std::int32_t> all_of(const std::vector<dvec3>& points) {
  std::vector<std::int32_t> corners;
  for (std::size_t i = 0; i < points.size(); ++i) corners.push_back(static_cast<std::int32_t>(i));
  return corners;
}

// Every triangle runs round as the polygon does, and together they have its area: it is covered once.
TEST(Polygon, ConcaveOnesAreCoveredOnce) {
  Random random(61);
  for (int k = 0; k < 200; ++k) {
    const dvec3 x = glm::normalize(dvec3(1, nurbs::uniform(random, -1, 1), nurbs::uniform(random, -1, 1)));
    const dvec3 n = glm::normalize(glm::cross(x, dvec3(0.3, 1, nurbs::uniform(random, -1, 1))));
    const dvec3 y = glm::cross(n, x);
    const auto star = nurbs::star(random, {3, 4}, 2.0, 3 + static_cast<int>(random() % 30), 0.2);
    std::vector<dvec3> points;
    double area = 0.0;
    for (std::size_t i = 0; i < star.size(); ++i) {
      const dvec2 a = star[i], b = star[(i + 1) % star.size()];
      points.push_back(a.x * x + a.y * y + 5.0 * n);
      area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    Triangles triangles;
    triangulate_polygon(points, all_of(points), triangles);
    ASSERT_EQ(triangles.size(), points.size() - 2);
    double sum = 0.0;
    for (const auto& t : triangles) {
      const double along = glm::dot(area_vector(points, t), n);
      EXPECT_GT(along, -1e-12);
      sum += along;
    }
    EXPECT_NEAR(sum, area, 1e-12 * area);
  }
}

// The area's vector is kept, whatever the polygon is like: its rim is the sum of the triangles' rims.
TEST(Polygon, EvenTwistedOnesKeepTheirRim) {
  Random random(62);
  for (int k = 0; k < 200; ++k) {
    std::vector<dvec3> points;
    for (int i = 0; i < 3 + k % 12; ++i)
      points.emplace_back(nurbs::uniform(random, -1, 1), nurbs::uniform(random, -1, 1),
                          nurbs::uniform(random, -1, 1));
    Triangles triangles;
    triangulate_polygon(points, all_of(points), triangles);
    ASSERT_EQ(triangles.size(), points.size() - 2);
    dvec3 sum(0.0), rim(0.0);
    for (const auto& t : triangles) sum += area_vector(points, t);
    for (std::size_t i = 0; i < points.size(); ++i)
      rim += 0.5 * glm::cross(points[i], points[(i + 1) % points.size()]);
    EXPECT_LT(glm::distance(sum, rim), 1e-12);
  }
}

TEST(Polygon, CornersThatCoincideMakeFewerTriangles) {
  const std::vector<dvec3> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  Triangles triangles;
  triangulate_polygon(points, std::vector<std::int32_t>{0, 1, 1, 2, 3}, triangles);
  for (const auto& t : triangles) EXPECT_TRUE(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
  double area = 0.0;
  for (const auto& t : triangles) area += area_vector(points, t).z;
  EXPECT_DOUBLE_EQ(area, 1.0);
}

}  // namespace
}  // namespace trimray::tess
