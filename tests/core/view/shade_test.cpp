#include "core/view/shade.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "core/view/frame.h"
#include "core/view/sampling.h"

namespace trimray::view {
namespace {

TEST(Shade, FloatsOfSrgbAreThoseOfTheExactCurve) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto expect_same = [](double x) {
    const float want = static_cast<float>(srgb_from_linear(x)), got = srgb_float_from_linear(x);
    ASSERT_TRUE(want == got) << x;
  };
  for (int i = 0; i < 300000; ++i) expect_same(unit(random)), expect_same(0.02 * unit(random));
  for (const double x : {-1.0, 0.0, 1e-300, 0.0031308, std::nextafter(0.0031308, 1.0), 1.0 / 256, 1.0 / 512,
                         std::nextafter(1.0, 0.0), 1.0, 2.0, std::numeric_limits<double>::quiet_NaN()})
    expect_same(x);
  // Floats and the middles between them, where the rounding turns.
  for (int i = 2; i < 4000; ++i) {
    const float encoded = static_cast<float>(i) / 4000.0f;
    const double middle = 0.5 * (static_cast<double>(encoded) + std::nextafter(encoded, 1.0f));
    const double x = linear_from_srgb(middle);
    expect_same(x), expect_same(std::nextafter(x, 0.0)), expect_same(std::nextafter(x, 1.0));
  }
}

TEST(Shade, SrgbMatchesItsPublishedValuesAndInverts) {
  EXPECT_NEAR(linear_from_srgb(0.5), 0.21404114048223255, 1e-15);
  EXPECT_NEAR(srgb_from_linear(0.18), 0.46135612950044164, 1e-14);
  EXPECT_EQ(srgb_from_linear(0.0), 0.0);
  EXPECT_EQ(srgb_from_linear(1.0), 1.0);
  for (int i = 0; i <= 255; ++i) EXPECT_NEAR(srgb_from_linear(linear_from_srgb(i / 255.0)), i / 255.0, 1e-7);
}

TEST(Shade, BothSidesOfAFaceAreLitAlikeAndNoneIsBlack) {
  const Lighting lighting({1, 0, 0}, {0, 0, 1}, {0, 1, 0});
  const dvec3 grey(0.5), dir(0, 1, 0);
  for (int i = 1; i < 1000; ++i) {  // i = 0 is edge-on: neither side
    const double z = 2.0 * (i + 0.5) / 1000 - 1.0, a = 2.399963229728653 * i, r = std::sqrt(1 - z * z);
    const dvec3 n(r * std::cos(a), r * std::sin(a), z);
    const dvec3 c = shade(lighting, n, dir, grey, false);
    EXPECT_EQ(c, shade(lighting, -n, dir, grey, false));
    EXPECT_GT(srgb_from_linear(c.x), 0.10);
    EXPECT_LT(c.x, 0.75);
    EXPECT_EQ(c.x, c.y);  // grey stays grey
    EXPECT_EQ(c.x, c.z);
  }
}

TEST(Shade, OrientationTintsInnerSidesOnly) {
  const Lighting lighting({1, 0, 0}, {0, 0, 1}, {0, 1, 0});
  const dvec3 grey(0.5), dir(0, 1, 0), outward(0, -1, 0);
  EXPECT_EQ(shade(lighting, outward, dir, grey, true), shade(lighting, outward, dir, grey, false));
  const dvec3 inner = shade(lighting, -outward, dir, grey, true);
  EXPECT_GT(inner.x, 1.5 * inner.y);
}

TEST(Shade, BackgroundRunsFromTopToBottom) {
  Background b;
  b.top[0] = 0.2f, b.bottom[0] = 0.8f;
  EXPECT_NEAR(b.at(0).rgb.x, linear_from_srgb(0.2f), 1e-12);
  EXPECT_NEAR(b.at(1).rgb.x, linear_from_srgb(0.8f), 1e-12);
  EXPECT_NEAR(b.at(0.5).rgb.x, linear_from_srgb(0.5), 1e-6);
  EXPECT_EQ(b.at(0.3).alpha, 1.0);
}

TEST(Sampling, PatternsAreCentredWithinThePixelAndSpread) {
  for (const int count : {1, 2, 3, 4, 5, 8, 16, 64, 100}) {
    const auto points = sample_pattern(count);
    ASSERT_EQ(points.size(), static_cast<std::size_t>(count));
    dvec2 mean(0.0);
    for (const dvec2& p : points) {
      EXPECT_GE(p.x, 0.0);
      EXPECT_LE(p.x, 1.0);
      EXPECT_GE(p.y, 0.0);
      EXPECT_LE(p.y, 1.0);
      mean += p / static_cast<double>(count);
    }
    EXPECT_NEAR(mean.x, 0.5, 0.02);
    EXPECT_NEAR(mean.y, 0.5, 1e-12);
    // One point a row, and quarter by quarter the share of its area to within two points.
    for (int quarter = 0; quarter < 4; ++quarter) {
      int inside = 0;
      for (const dvec2& p : points) inside += (p.x >= 0.5) == (quarter & 1) && (p.y >= 0.5) == (quarter >> 1);
      EXPECT_NEAR(inside, count / 4.0, 2.0);
    }
  }
}

TEST(Frame, PlanesNotAskedForStayEmptyAndBackgroundValuesAreSet) {
  const Frame f(3, 2, {.color = false, .depth = true, .normal = true, .face = true});
  EXPECT_TRUE(f.color.empty() && f.position.empty() && f.uv.empty() && f.instance.empty());
  ASSERT_EQ(f.depth.size(), 6u);
  EXPECT_EQ(f.depth[5], kInf);
  ASSERT_EQ(f.normal.size(), 18u);
  EXPECT_EQ(f.normal[17], 0.0);
  EXPECT_EQ(f.face[0], kNoFace);
}

}  // namespace
}  // namespace trimray::view
