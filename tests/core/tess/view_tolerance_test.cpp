#include "core/tess/view_tolerance.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace trimray::tess {
namespace {

using view::Camera;

class Draw {
 public:
  explicit Draw(int seed) : engine_(seed) {}
  double in(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine_); }
  int whole(int a, int b) { return std::uniform_int_distribution<int>(a, b)(engine_); }
  dvec3 vec(double r) { return {in(-r, r), in(-r, r), in(-r, r)}; }
  dvec3 unit() {
    for (;;) {
      const dvec3 v = vec(1.0);
      const double l = glm::length(v);
      if (l > 0.1 && l < 1.0) return v / l;
    }
  }
  dvec3 within(const Box3& box) { return box.lower + dvec3(in(0, 1), in(0, 1), in(0, 1)) * box.extent(); }

  Camera camera(bool perspective) {
    Camera c = view::look(in(0, 360), in(-90, 90), view::UpAxis::kZ);
    c.perspective = perspective;
    c.eye = vec(20.0);
    c.width_px = whole(1, 800), c.height_px = whole(1, 800);
    c.pixel = std::pow(10.0, perspective ? in(-4.0, -2.5) : in(-3.0, -1.0));
    return c;
  }
  Transform placement() {
    Transform t;
    t.translation = vec(5.0);
    switch (whole(0, 3)) {
      case 0:
        break;
      case 1:  // mirrored, scaled
        t.linear = dmat3(in(0.1, 3.0)), t.linear[0] = -t.linear[0];
        break;
      default:
        t.linear = dmat3(vec(1.0), vec(1.0), vec(1.0));
    }
    return t;
  }
  Box3 box(double reach) {
    const dvec3 centre = vec(reach), half = glm::abs(vec(1.0)) * std::pow(10.0, in(-3.0, 1.0));
    return {centre - half, centre + half};
  }

 private:
  std::mt19937_64 engine_;
};

struct Seen {
  dvec2 px;
  double depth;
  bool in_picture(const Camera& c) const {
    return depth > 0.0 && px.x >= 0.0 && px.y >= 0.0 && px.x <= c.width_px && px.y <= c.height_px;
  }
};

Seen project(const Camera& c, const dvec3& world) {
  const dvec3 d = world - c.eye;
  const double z = glm::dot(d, c.forward), scale = 1.0 / (c.pixel * (c.perspective ? z : 1.0));
  return {{0.5 * c.width_px + glm::dot(d, c.right) * scale, 0.5 * c.height_px - glm::dot(d, c.up) * scale},
          z};
}

constexpr double kNear = 1e-3;

class ViewToleranceOf : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Projections, ViewToleranceOf, testing::Bool());

// Brute force: whatever is in the box and in the picture, moved by the tolerance in any direction.
TEST_P(ViewToleranceOf, NothingInTheBoxIsSeenToMoveFarther) {
  Draw draw(1);
  int seen = 0, tight = 0;
  for (int k = 0; k < 4000; ++k) {
    const Camera c = draw.camera(GetParam());
    const Transform placement = draw.placement();
    const double px = std::pow(10.0, draw.in(-2.0, 1.0));
    const ViewTolerance field(c, {.deviation_px = px, .near = kNear}, placement);
    const Box3 box = draw.box(15.0);
    const double tolerance = field.at(box);
    ASSERT_GT(tolerance, 0.0);
    double farthest = 0.0;
    for (int i = 0; i < 60; ++i) {
      const dvec3 p = draw.within(box);
      const Seen before = project(c, placement.point(p));
      if (!before.in_picture(c) || (GetParam() && before.depth < kNear)) continue;
      const Seen after = project(c, placement.point(p + tolerance * draw.unit()));
      farthest = std::max(farthest, glm::distance(before.px, after.px));
      ++seen;
    }
    EXPECT_LE(farthest, px * (1.0 + 1e-9)) << "draw " << k;
    tight += farthest > 0.8 * px;
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(tight, 5);
}

// A surface as far from its triangle as the tolerance allows does not come into the picture from outside.
TEST_P(ViewToleranceOf, WhatIsOutsideStaysOutside) {
  Draw draw(2);
  int outside = 0, coarse = 0;
  for (int k = 0; k < 4000; ++k) {
    const Camera c = draw.camera(GetParam());
    const Transform placement = draw.placement();
    const ViewTolerance field(c, {.deviation_px = 0.3, .near = kNear}, placement);
    const Box3 box = draw.box(15.0);
    if (!field.outside(box)) continue;
    ++outside;
    EXPECT_FALSE(field.inside(box));
    const double tolerance = field.at(box);
    coarse += tolerance > 10.0 * field.most(box);
    for (int i = 0; i < 60; ++i) {
      const dvec3 p = draw.within(box);
      EXPECT_FALSE(project(c, placement.point(p)).in_picture(c)) << "draw " << k;
      EXPECT_FALSE(project(c, placement.point(p + tolerance * draw.unit())).in_picture(c)) << "draw " << k;
    }
  }
  EXPECT_GT(outside, 1000);
  EXPECT_GT(coarse, 500);
}

TEST_P(ViewToleranceOf, InsideMeansWhollyInThePictureOrItsRim) {
  Draw draw(3);
  int inside = 0;
  for (int k = 0; k < 4000; ++k) {
    const Camera c = draw.camera(GetParam());
    const Transform placement = draw.placement();
    const ViewTolerance field(c, {.deviation_px = 0.5, .near = kNear}, placement);
    const Box3 box = draw.box(10.0);
    const double share = field.share(box);
    EXPECT_TRUE(share >= 0.0 && share <= 1.0);
    EXPECT_TRUE(share == 0.0 || !field.outside(box));
    if (!field.inside(box)) continue;
    ++inside;
    EXPECT_EQ(share, 1.0);
    for (int i = 0; i < 30; ++i) {
      const Seen at = project(c, placement.point(draw.within(box)));
      EXPECT_TRUE(at.depth >= -1e-9 && at.px.x >= -1.6 && at.px.y >= -1.6 && at.px.x <= c.width_px + 1.6 &&
                  at.px.y <= c.height_px + 1.6)
          << "draw " << k;
    }
  }
  EXPECT_GT(inside, 10);
}

TEST_P(ViewToleranceOf, SmallerBoxesHaveNoSmallerTolerance) {
  Draw draw(4);
  for (int k = 0; k < 4000; ++k) {
    const ViewTolerance field(draw.camera(GetParam()), {.near = kNear}, draw.placement());
    const Box3 box = draw.box(15.0);
    Box3 part;
    part.add(draw.within(box)), part.add(draw.within(box));
    EXPECT_GE(field.at(part), field.at(box) * (1.0 - 1e-12));
  }
}

TEST(ViewTolerance, OfAPlainCameraIsThePixel) {
  Camera c = view::look(0.0, 0.0, view::UpAxis::kZ);  // along +y
  c.eye = {0, -10, 0}, c.pixel = 0.01;
  Box3 box;
  box.add(dvec3(-0.1)), box.add(dvec3(0.1));
  EXPECT_NEAR(ViewTolerance(c, {.deviation_px = 0.5}, {}).at(box), 0.005, 1e-12);
  Transform twice;
  twice.linear = dmat3(2.0);
  EXPECT_NEAR(ViewTolerance(c, {.deviation_px = 0.5}, twice).at(box), 0.0025, 1e-12);
  Transform sheared;  // its largest stretch is the golden ratio
  sheared.linear[1] = {1, 1, 0};
  EXPECT_NEAR(ViewTolerance(c, {.deviation_px = 0.5}, sheared).at(box), 0.005 / 1.618033988749895, 1e-12);
  c.perspective = true, c.pixel = 1e-3;
  // Of the depth 9.9 the thousandth, less what the border of the picture takes.
  const double near = ViewTolerance(c, {.deviation_px = 1.0}, {}).at(box);
  EXPECT_LT(near, 9.9e-3);
  EXPECT_GT(near, 9.9e-3 * 0.9);
  EXPECT_EQ(ViewTolerance(c, {}, {}).at(Box3{}), kInf);
}

// The promise of serves(): at every place that the other one sees, seen here, and no coarser.
TEST_P(ViewToleranceOf, ServesOnlyWhatIsNowhereFinerAndNowhereWider) {
  Draw draw(5);
  int served = 0, refused = 0, itself = 0;
  for (int k = 0; k < 6000; ++k) {
    Camera a = draw.camera(GetParam());
    a.eye = draw.vec(3.0) - draw.in(0.0, 10.0) * a.forward;
    Camera b = a;
    const double step = std::pow(10.0, draw.in(-3.0, 0.0));
    switch (draw.whole(0, 4)) {
      case 0:
        break;
      case 1:
        b.eye += step * draw.unit();
        break;
      case 2:
        b.pixel *= draw.in(0.7, 1.3);
        break;
      case 3:
        b.width_px = std::max(1, b.width_px - draw.whole(0, 100)), b.eye += step * draw.in(-1, 1) * b.forward;
        break;
      default:
        b = draw.camera(draw.whole(0, 1) == 1);
        b.eye = a.eye + step * draw.unit();
    }
    const Transform placement;
    const double px = draw.in(0.1, 2.0);
    const double ratio = draw.whole(0, 1) == 0 ? 1.0 : draw.in(0.8, 3.0);
    const ViewTolerance mine(a, {.deviation_px = px, .near = 0.1, .guard_px = 3.0 + draw.in(0, 100)},
                             placement);
    const ViewTolerance other(b, {.deviation_px = px * ratio, .near = 0.1}, placement);
    const Box3 box = draw.box(3.0);
    if (other.outside(box)) continue;
    if (mine.serves(mine, box, 1.0 + 1e-9)) ++itself;
    if (!mine.serves(other, box, 2.0)) {
      ++refused;
      continue;
    }
    ++served;
    double least = kInf;
    for (int i = 0; i < 200; ++i) {
      const dvec3 p = draw.within(box);
      const Box3 place{p, p};
      if (!project(b, placement.point(p)).in_picture(b)) continue;
      EXPECT_FALSE(mine.outside(place)) << "draw " << k;
      EXPECT_LE(mine.at(place), other.at(place) * (1.0 + 2e-3)) << "draw " << k;
      least = std::min(least, other.at(place) / mine.at(place));
    }
  }
  EXPECT_GT(served, 200);
  EXPECT_GT(refused, 500);
  EXPECT_GT(itself, 500);
}

TEST_P(ViewToleranceOf, ServesUntilFinerIsWantedOrMuchCoarserWillDo) {
  Camera c = view::look(30.0, 20.0, view::UpAxis::kZ);
  c.perspective = GetParam();
  c.pixel = c.perspective ? 1e-3 : 1e-2;
  c.eye = -10.0 * c.forward;
  Box3 box;
  box.add(dvec3(-20.0)), box.add(dvec3(20.0));  // around the eye
  const auto field = [&](double px, double guard = 5.0, double moved = 0.0) {
    Camera at = c;
    at.eye += moved * c.right;
    return ViewTolerance(at, {.deviation_px = px, .near = 0.01, .guard_px = guard}, {});
  };
  EXPECT_TRUE(field(0.3).serves(field(0.3, 0.0), box, 2.0));
  EXPECT_TRUE(field(0.3).serves(field(0.59, 0.0), box, 2.0));
  EXPECT_FALSE(field(0.3).serves(field(0.62, 0.0), box, 2.0));
  EXPECT_FALSE(field(0.3).serves(field(0.29, 0.0), box, 2.0));
  EXPECT_FALSE(field(0.3).serves(field(0.3, 0.0, 1.0), box, 2.0)) << "the picture shows more on one side";
  EXPECT_EQ(field(0.3).serves(field(0.3, 0.0, 0.03), box, 2.0), !c.perspective) << "less than the guard";
}

}  // namespace
}  // namespace trimray::tess
