#include "core/tess/interval.h"

#include <gtest/gtest.h>

#include "tests/core/tess/random_loops.h"

namespace trimray::tess {
namespace {

using nurbs::Random;
using nurbs::uniform;

Interval random_interval(Random& random) {
  const double a = uniform(random, -3.0, 3.0), b = uniform(random, -3.0, 3.0);
  return {std::min(a, b), std::max(a, b)};
}

Box3 random_box(Random& random) {
  Box3 box;
  for (int k = 0; k < 2; ++k)
    box.add(dvec3(uniform(random, -3.0, 3.0), uniform(random, -3.0, 3.0), uniform(random, -3.0, 3.0)));
  return box;
}

double value_in(Random& random, Interval i) { return uniform(random, i.lo, i.hi); }
dvec3 value_in(Random& random, const Box3& b) {
  return {uniform(random, b.lower.x, b.upper.x), uniform(random, b.lower.y, b.upper.y),
          uniform(random, b.lower.z, b.upper.z)};
}

bool holds(Interval i, double x) { return x >= i.lo - 1e-14 && x <= i.hi + 1e-14; }
bool holds(Box3 b, const dvec3& p) {
  b.dilate(1e-14);
  return b.contains(p);
}

TEST(Interval, ResultsHoldEveryResultOfValues) {
  Random random(1);
  for (int k = 0; k < 20000; ++k) {
    const Interval a = random_interval(random), b = random_interval(random);
    const double x = value_in(random, a), y = value_in(random, b), s = uniform(random, -2.0, 2.0);
    ASSERT_TRUE(holds(a + b, x + y));
    ASSERT_TRUE(holds(-a, -x));
    ASSERT_TRUE(holds(s * a, s * x));
    ASSERT_TRUE(holds(a * b, x * y));
    ASSERT_LE(std::abs(x), a.magnitude());
    const Box3 c = random_box(random), d = random_box(random);
    const dvec3 p = value_in(random, c), q = value_in(random, d);
    ASSERT_TRUE(holds(c + d, p + q));
    ASSERT_TRUE(holds(c - d, p - q));
    ASSERT_TRUE(holds(s * c, s * p));
    ASSERT_TRUE(holds(a * c, x * p));
    ASSERT_TRUE(holds(a * q, x * q));
    ASSERT_TRUE(holds(along(q, c), glm::dot(q, p)));
    ASSERT_LE(glm::length(p), largest(c) + 1e-14);
  }
}

TEST(Interval, EndsAreTaken) {
  EXPECT_EQ((Interval{-1, 2} * Interval{-3, 1}).lo, -6.0);
  EXPECT_EQ((Interval{-1, 2} * Interval{-3, 1}).hi, 3.0);
  EXPECT_EQ((-2.0 * Interval{-1, 2}).lo, -4.0);
  const Box3 box{{-1, 0, 2}, {1, 3, 4}};
  EXPECT_EQ(along({1, -1, 0.5}, box).lo, -3.0);
  EXPECT_EQ(along({1, -1, 0.5}, box).hi, 3.0);
  EXPECT_DOUBLE_EQ(largest(box), std::sqrt(26.0));
}

}  // namespace
}  // namespace trimray::tess
