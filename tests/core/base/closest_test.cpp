#include "core/base/closest.h"

#include <random>

#include <gtest/gtest.h>

namespace trimray {
namespace {

TEST(Closest, EveryFeatureOfATriangleIsTheNearestSomewhere) {
  const dvec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, 1, 3}, a, b, c), 3.0);
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, -2, 0}, a, b, c), 2.0);
  EXPECT_DOUBLE_EQ(distance_to_triangle({-3, 1, 4}, a, b, c), 5.0);
  EXPECT_DOUBLE_EQ(distance_to_triangle({4, 4, 0}, a, b, c), std::sqrt(8.0));
  EXPECT_DOUBLE_EQ(distance_to_triangle({-3, -4, 0}, a, b, c), 5.0);
  EXPECT_DOUBLE_EQ(distance_to_triangle({7, 0, 0}, a, b, c), 3.0);
  EXPECT_DOUBLE_EQ(distance_to_triangle({0, 3, 1}, a, a, {0, 2, 1}), 1.0) << "no area";
}

TEST(Closest, ThePointOfATriangleIsThatOfItsWeightsAndItsDistance) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto point = [&] {
    const double x = unit(random), y = unit(random);
    return dvec3(x, y, unit(random));
  };
  for (int i = 0; i < 100; ++i) {
    const dvec3 p = point(), a = point(), b = point(), c = point();
    const TrianglePoint t = closest_on_triangle(p, a, b, c);
    EXPECT_LE(glm::distance(t.p, a + t.weight_b * (b - a) + t.weight_c * (c - a)), 1e-12);
    EXPECT_NEAR(glm::distance(t.p, p), distance_to_triangle(p, a, b, c), 1e-14);
    EXPECT_GE(t.weight_b, 0.0);
    EXPECT_GE(t.weight_c, 0.0);
    EXPECT_LE(t.weight_b + t.weight_c, 1.0 + 1e-12);
  }
}

}  // namespace
}  // namespace trimray
