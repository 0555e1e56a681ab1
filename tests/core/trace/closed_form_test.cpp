// Closed forms against their definition: points put on a surface by its parametrization are found again by
// rays through them, and sign changes of the implicit function count the roots.
#include "core/trace/closed_form.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace trimray::trace {
namespace {

using nurbs::SurfaceKind;

constexpr double kPi = 3.14159265358979323846;

struct Case {
  const char* name;
  nurbs::Surface surface;
  Box2 uv;
};

nurbs::Surface surface(SurfaceKind kind, double r1, double r2, double angle, dvec3 location,
                       bool left_handed) {
  nurbs::Surface s;
  s.kind = kind, s.r1 = r1, s.r2 = r2, s.semi_angle = angle, s.location = location;
  s.z_axis = glm::normalize(dvec3(1, 2, 3));
  s.x_axis = glm::normalize(glm::cross(s.z_axis, dvec3(0, 0, 1)));
  s.y_axis = glm::cross(s.z_axis, s.x_axis) * (left_handed ? -1.0 : 1.0);
  return s;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const dvec3 at : {dvec3(0.3, -0.2, 0.7), dvec3(1e5, -1e5, 5e4)}) {
    for (const bool left : {false, true}) {
      const auto add = [&](const char* name, SurfaceKind kind, double r1, double r2, double a, Box2 uv) {
        all.push_back({name, surface(kind, r1, r2, a, at, left), uv});
      };
      add("plane", SurfaceKind::kPlane, 0, 0, 0, {{-3, -2}, {2, 4}});
      add("cylinder", SurfaceKind::kCylinder, 2, 0, 0, {{0, -3}, {2 * kPi, 3}});
      add("cone", SurfaceKind::kCone, 2, 0, 0.4, {{0, -3}, {2 * kPi, 3}});
      add("cone narrowing", SurfaceKind::kCone, 2, 0, -0.4, {{0, -3}, {2 * kPi, 3}});
      add("cone through its apex", SurfaceKind::kCone, 1, 0, 0.6, {{0, -4}, {2 * kPi, 3}});
      add("sphere", SurfaceKind::kSphere, 3, 0, 0, {{0, -kPi / 2}, {2 * kPi, kPi / 2}});
      add("torus", SurfaceKind::kTorus, 3, 1, 0, {{0, 0}, {2 * kPi, 2 * kPi}});
      add("thin torus", SurfaceKind::kTorus, 3, 0.01, 0, {{0, 0}, {2 * kPi, 2 * kPi}});
      add("horn torus", SurfaceKind::kTorus, 2, 2, 0, {{0, 0}, {2 * kPi, 2 * kPi}});
      add("spindle torus", SurfaceKind::kTorus, 1, 2, 0, {{0, 0}, {2 * kPi, 2 * kPi}});
    }
  }
  return all;
}

// An equation of the whole surface, in long double, zero on it and of opposite signs on its two sides.
long double implicit(const nurbs::Surface& s, dvec3 org, dvec3 dir, long double t) {
  long double p[3], local[3];
  for (int a = 0; a < 3; ++a) p[a] = static_cast<long double>(org[a]) - s.location[a] + t * dir[a];
  const dvec3 axes[3] = {s.x_axis, s.y_axis, s.z_axis};
  for (int a = 0; a < 3; ++a) local[a] = p[0] * axes[a][0] + p[1] * axes[a][1] + p[2] * axes[a][2];
  const long double rho2 = local[0] * local[0] + local[1] * local[1], z = local[2];
  const long double r1 = s.r1, r2 = s.r2;
  switch (s.kind) {
    case SurfaceKind::kPlane:
      return z;
    case SurfaceKind::kCylinder:
      return rho2 - r1 * r1;
    case SurfaceKind::kCone: {
      const long double w = r1 + z * std::tan(static_cast<long double>(s.semi_angle));
      return rho2 - w * w;
    }
    case SurfaceKind::kSphere:
      return rho2 + z * z - r1 * r1;
    default: {
      const long double k = rho2 + z * z + r1 * r1 - r2 * r2;
      return k * k - 4 * r1 * r1 * rho2;
    }
  }
}

class ClosedFormTest : public testing::TestWithParam<Case> {};

TEST_P(ClosedFormTest, RayThroughAPointOfTheSurfaceFindsItsTAndUv) {
  const Case& c = GetParam();
  const ClosedForm form = make_closed_form(c.surface, c.uv, 1e-6);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int k = 0; k < 4000; ++k) {
    const dvec2 uv = c.uv.lower + c.uv.extent() * dvec2(unit(random), unit(random));
    const dvec3 p = closed_form_point(form, uv);
    const dvec3 dir = glm::normalize(dvec3(unit(random), unit(random), unit(random)) - 0.5);
    const double grazing = std::abs(glm::dot(dir, closed_form_normal(form, uv)));
    if (grazing < 1e-3) continue;
    const double t = 2.0 + 10.0 * unit(random);
    ClosedRoot roots[kMaxClosedRoots];
    const int count = closed_form_roots(form, p - t * dir, dir, form.uv, -kInf, kInf, roots);
    double best = kInf;
    dvec2 found{0.0};
    for (int i = 0; i < count; ++i)
      if (std::abs(roots[i].t - t) < best) best = std::abs(roots[i].t - t), found = roots[i].uv;
    const double scale = glm::length(c.surface.location) + 20.0;
    ASSERT_LE(best, 1e-14 * scale / grazing) << c.name << " uv " << uv.x << ' ' << uv.y;
    const dvec3 back = closed_form_point(form, found);
    EXPECT_LE(glm::length(back - p), 2e-14 * scale / grazing) << c.name;
  }
}

TEST_P(ClosedFormTest, RootsAreTheSignChangesOfTheImplicitFunction) {
  const Case& c = GetParam();
  if (c.surface.kind == SurfaceKind::kCone && c.uv.lower.y == -4)
    return;  // covered by the uv range test below
  Box2 whole = c.uv;
  if (!is_angle_v(c.surface.kind) && c.surface.kind != SurfaceKind::kSphere)
    whole.lower.y = -1e9, whole.upper.y = 1e9;
  if (c.surface.kind == SurfaceKind::kPlane) whole.lower.x = -1e9, whole.upper.x = 1e9;
  ClosedForm form = make_closed_form(c.surface, c.uv, 1e-6);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int k = 0; k < 60; ++k) {
    const dvec3 target = c.surface.location + 3.5 * dvec3(unit(random), unit(random), unit(random));
    const dvec3 dir = glm::normalize(dvec3(unit(random), unit(random), unit(random)));
    const dvec3 org = target - 8.0 * dir;
    ClosedRoot roots[kMaxClosedRoots];
    const int count = closed_form_roots(form, org, dir, whole, 0.0, 16.0, roots);
    int changes = 0;
    double previous = 0.0;
    for (int i = 0; i <= 16000; ++i) {
      const long double now = implicit(c.surface, org, dir, 16.0L * i / 16000.0L);
      if (i > 0 && (now < 0) != (previous < 0)) ++changes;
      previous = static_cast<double>(now);
    }
    // A chord shorter than the step of the walk is seen by the closed form alone.
    int visible = count;
    for (int i = 0; i + 1 < count; ++i)
      if (roots[i + 1].t - roots[i].t < 1.1e-3) visible -= 2, ++i;
    EXPECT_EQ(visible, changes) << c.name << " ray " << k;
    for (int i = 0; i < count; ++i) {
      const long double step = 1e-9L * (glm::length(c.surface.location) > 1e3 ? 1e3L : 1.0L);
      const long double before = implicit(c.surface, org, dir, roots[i].t - step);
      const long double after = implicit(c.surface, org, dir, roots[i].t + step);
      if (i + 1 < count && roots[i + 1].t - roots[i].t < 1e-3) continue;
      if (i > 0 && roots[i].t - roots[i - 1].t < 1e-3) continue;
      EXPECT_NE(before < 0, after < 0) << c.name << " ray " << k << " root " << i;
    }
  }
}

TEST_P(ClosedFormTest, BoxHoldsTheSurfaceAndIsTight) {
  const Case& c = GetParam();
  const ClosedForm form = make_closed_form(c.surface, c.uv, 1e-6);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int k = 0; k < 200; ++k) {
    const dvec2 a = c.uv.lower + c.uv.extent() * dvec2(unit(random), unit(random));
    const dvec2 b = c.uv.lower + c.uv.extent() * dvec2(unit(random), unit(random));
    const Box2 part{glm::min(a, b), glm::max(a, b)};
    const Box3 box = closed_form_box(form, part);
    Box3 sampled;
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; j <= kSteps; ++j)
        sampled.add(
            closed_form_point(form, part.lower + part.extent() * dvec2(i, j) / static_cast<double>(kSteps)));
    ASSERT_TRUE(box.contains(sampled.lower) && box.contains(sampled.upper)) << c.name;
    // A bump missed between two samples is at most step^2 / 8 times the curvature radius high.
    const dvec2 length = closed_form_lengths(form, part);
    const double slack = 0.02 * (length.x + length.y) + 1e-8;
    EXPECT_LE(glm::length(box.lower - sampled.lower) + glm::length(box.upper - sampled.upper), slack)
        << c.name;
  }
}

TEST_P(ClosedFormTest, NormalIsTheCrossProductOfTheDerivatives) {
  const Case& c = GetParam();
  nurbs::Surface near = c.surface;
  near.location = dvec3(0.0);
  const ClosedForm form = make_closed_form(near, c.uv, 1e-6);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int k = 0; k < 500; ++k) {
    const dvec2 uv = c.uv.lower + c.uv.extent() * dvec2(unit(random), unit(random));
    const double h = 1e-6;
    const dvec3 du = closed_form_point(form, uv + dvec2(h, 0)) - closed_form_point(form, uv - dvec2(h, 0));
    const dvec3 dv = closed_form_point(form, uv + dvec2(0, h)) - closed_form_point(form, uv - dvec2(0, h));
    const dvec3 n = glm::cross(du, dv);
    if (glm::length(n) < 1e-4 * h * h) continue;
    EXPECT_NEAR(glm::dot(glm::normalize(n), closed_form_normal(form, uv)), 1.0, 1e-6)
        << c.name << ' ' << uv.x << ' ' << uv.y;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ClosedFormTest, testing::ValuesIn(cases()));

TEST(ClosedFormRangeTest, ConeRootsStayOnTheNappeOfTheFace) {
  const nurbs::Surface cone = surface(SurfaceKind::kCone, 1.0, 0.0, 0.5, dvec3(0.0), false);
  const double apex_v = -1.0 / std::sin(0.5);
  const Box2 above{{0, apex_v + 0.5}, {2 * kPi, 3}}, below{{0, apex_v - 3}, {2 * kPi, apex_v - 0.5}};
  for (const Box2& part : {above, below}) {
    const ClosedForm form = make_closed_form(cone, part, 0.0);
    const dvec3 middle = closed_form_point(form, part.center());
    const dvec3 org = middle + 20.0 * cone.z_axis, dir = -cone.z_axis;
    ClosedRoot roots[kMaxClosedRoots];
    ASSERT_EQ(closed_form_roots(form, org, dir, form.uv, -kInf, kInf, roots), 1);
    EXPECT_NEAR(roots[0].uv.y, part.center().y, 1e-12);
    EXPECT_NEAR(roots[0].uv.x, part.center().x, 1e-12);
  }
}

TEST(ClosedFormRangeTest, GrazingChordKeepsItsDigits) {
  // A ray at the distance r - e from the axis has the half chord sqrt(e (2 r - e)).
  const nurbs::Surface cylinder = surface(SurfaceKind::kCylinder, 2.0, 0.0, 0.0, dvec3(0.0), false);
  const ClosedForm form = make_closed_form(cylinder, {{0, -1}, {2 * kPi, 1}}, 0.0);
  for (double e = 1e-2; e > 1e-11; e *= 0.1) {
    const dvec3 org = (2.0 - e) * cylinder.x_axis - 1.0 * cylinder.y_axis;
    ClosedRoot roots[kMaxClosedRoots];
    ASSERT_EQ(closed_form_roots(form, org, cylinder.y_axis, form.uv, -kInf, kInf, roots), 2) << e;
    const double half = std::sqrt(e * (4.0 - e));
    EXPECT_NEAR(0.5 * (roots[1].t - roots[0].t), half, 1e-15 / half + 1e-15) << e;
    const dvec3 outside = (2.0 + e) * cylinder.x_axis - 1.0 * cylinder.y_axis;
    EXPECT_EQ(closed_form_roots(form, outside, cylinder.y_axis, form.uv, -kInf, kInf, roots), 0) << e;
  }
}

TEST(ClosedFormRangeTest, RayAlongTheAxisMeetsNoCylinderAndOneConeSheet) {
  const nurbs::Surface cylinder = surface(SurfaceKind::kCylinder, 2.0, 0.0, 0.0, dvec3(0.0), false);
  const ClosedForm tube = make_closed_form(cylinder, {{0, -1}, {2 * kPi, 1}}, 0.0);
  ClosedRoot roots[kMaxClosedRoots];
  EXPECT_EQ(closed_form_roots(tube, 1.9 * cylinder.x_axis, cylinder.z_axis, tube.uv, -kInf, kInf, roots), 0);
  const nurbs::Surface funnel = surface(SurfaceKind::kCone, 2.0, 0.0, 0.3, dvec3(0.0), false);
  const ClosedForm cone = make_closed_form(funnel, {{0, -3}, {2 * kPi, 3}}, 0.0);
  ASSERT_EQ(closed_form_roots(cone, 2.5 * funnel.y_axis - 10.0 * funnel.z_axis, funnel.z_axis, cone.uv, -kInf,
                              kInf, roots),
            1);
  EXPECT_NEAR(roots[0].t, 10.0 + 0.5 / std::tan(0.3), 1e-13);
  EXPECT_NEAR(roots[0].uv.x, kPi / 2, 1e-14);
}

}  // namespace
}  // namespace trimray::trace
