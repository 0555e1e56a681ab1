// Surfaces of every kind against the numbers in make_streams.py.
#include <gtest/gtest.h>

#include <cmath>

#include "core/brep/bintools.h"
#include "tests/core/brep/streams.h"

namespace trimray::brep {
namespace {

class BintoolsSurfaces : public ::testing::Test {
 protected:
  const Surface& surface(std::size_t face) const { return model.surfaces.at(model.faces.at(face).surface); }

  // All elementary surfaces share a frame at (1, 2, 3), axis along z, x along y.
  void expect_elementary(const Surface& s, SurfaceKind kind, double r1, double r2, bool left = false) const {
    EXPECT_EQ(s.kind, kind);
    EXPECT_EQ(s.location, dvec3(1, 2, 3));
    EXPECT_EQ(s.z_axis, dvec3(0, 0, 1));
    EXPECT_EQ(s.x_axis, dvec3(0, 1, 0));
    EXPECT_EQ(s.y_axis, dvec3(left ? 1 : -1, 0, 0));
    EXPECT_EQ(s.r1, r1);
    EXPECT_EQ(s.r2, r2);
  }

  // Pole (i, j) is (i, j, 10 i + j), weight (i, j) is 1 + i + j / 8.
  void expect_grid(const Surface& s, int count_u, int count_v, bool rational) const {
    ASSERT_EQ(s.count_u, count_u);
    ASSERT_EQ(s.count_v, count_v);
    ASSERT_EQ(s.poles.size(), static_cast<std::size_t>(count_u * count_v));
    ASSERT_EQ(s.weights.size(), rational ? s.poles.size() : 0u);
    for (int i = 0; i < count_u; ++i) {
      for (int j = 0; j < count_v; ++j) {
        EXPECT_EQ(s.poles[i * count_v + j], dvec3(i, j, 10 * i + j));
        if (rational) {
          EXPECT_NEAR(s.weights[i * count_v + j], 1 + i + j / 8.0, 1e-15);
        }
      }
    }
  }

  void expect_spline(const Surface& s) const {
    EXPECT_EQ(s.kind, SurfaceKind::kBspline);
    EXPECT_EQ(s.degree_u, 2);
    EXPECT_EQ(s.degree_v, 2);
    EXPECT_FALSE(s.rational_u || s.rational_v || s.periodic_u || s.periodic_v);
    expect_grid(s, 4, 3, false);
    EXPECT_EQ(s.knots_u, (std::vector<double>{0, 0.5, 2}));
    EXPECT_EQ(s.multiplicities_u, (std::vector<std::int32_t>{3, 1, 3}));
    EXPECT_EQ(s.knots_v, (std::vector<double>{-1, 1}));
    EXPECT_EQ(s.multiplicities_v, (std::vector<std::int32_t>{3, 3}));
  }

  Model model = parse_bintools(testing::read_stream("surfaces"));
};

TEST_F(BintoolsSurfaces, Elementary) {
  ASSERT_EQ(model.faces.size(), 14u);
  expect_elementary(surface(0), SurfaceKind::kPlane, 0, 0);
  expect_elementary(surface(1), SurfaceKind::kCylinder, 2.5, 0, true);
  expect_elementary(surface(2), SurfaceKind::kCone, 3, 0);
  EXPECT_EQ(surface(2).semi_angle, 0.5);
  expect_elementary(surface(3), SurfaceKind::kSphere, 4, 0);
  expect_elementary(surface(4), SurfaceKind::kTorus, 8, 2);
}

TEST_F(BintoolsSurfaces, SweptKeepTheirCurve) {
  const Surface& extrusion = surface(5);
  EXPECT_EQ(extrusion.kind, SurfaceKind::kExtrusion);
  EXPECT_EQ(extrusion.z_axis, dvec3(0, 0, 1));
  const Curve3& profile = model.curves3.at(extrusion.basis_curve);
  EXPECT_EQ(profile.kind, CurveKind::kBspline);
  EXPECT_EQ(profile.poles, (std::vector<dvec3>{{0, 0, 0}, {1, 1, 0}, {2, 0, 0}}));

  const Surface& revolution = surface(6);
  EXPECT_EQ(revolution.kind, SurfaceKind::kRevolution);
  EXPECT_EQ(revolution.location, dvec3(0, 0, 7));
  EXPECT_EQ(revolution.z_axis, dvec3(0, 0, 1));
  const Curve3& meridian = model.curves3.at(revolution.basis_curve);
  EXPECT_EQ(meridian.kind, CurveKind::kLine);
  EXPECT_EQ(meridian.location, dvec3(4, 0, 0));
}

TEST_F(BintoolsSurfaces, BezierPlainAndRational) {
  EXPECT_EQ(surface(7).kind, SurfaceKind::kBezier);
  EXPECT_EQ(surface(7).degree_u, 2);
  EXPECT_EQ(surface(7).degree_v, 3);
  expect_grid(surface(7), 3, 4, false);
  EXPECT_EQ(surface(7).knots_u, (std::vector<double>{0, 1}));
  EXPECT_EQ(surface(7).multiplicities_u, (std::vector<std::int32_t>{3, 3}));
  EXPECT_EQ(surface(7).multiplicities_v, (std::vector<std::int32_t>{4, 4}));

  EXPECT_TRUE(surface(11).rational_u);
  EXPECT_TRUE(surface(11).rational_v);
  EXPECT_EQ(surface(11).degree_u, 1);
  EXPECT_EQ(surface(11).degree_v, 2);
  expect_grid(surface(11), 2, 3, true);
}

TEST_F(BintoolsSurfaces, SplinePlainAndRationalPeriodic) {
  expect_spline(surface(8));
  const Surface& periodic = surface(12);
  EXPECT_EQ(periodic.kind, SurfaceKind::kBspline);
  EXPECT_TRUE(periodic.rational_u && periodic.rational_v && periodic.periodic_u);
  EXPECT_FALSE(periodic.periodic_v);
  EXPECT_EQ(periodic.degree_u, 3);
  EXPECT_EQ(periodic.degree_v, 1);
  expect_grid(periodic, 4, 3, true);
  EXPECT_EQ(periodic.knots_u, (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(periodic.multiplicities_u, (std::vector<std::int32_t>{1, 1, 1, 1, 1}));
  EXPECT_EQ(periodic.knots_v, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(periodic.multiplicities_v, (std::vector<std::int32_t>{2, 1, 2}));
}

TEST_F(BintoolsSurfaces, TrimmedAndOffsetKeepTheirBasis) {
  const Surface& trimmed = surface(9);
  EXPECT_EQ(trimmed.kind, SurfaceKind::kTrimmed);
  EXPECT_EQ(dvec4(trimmed.u0, trimmed.u1, trimmed.v0, trimmed.v1), dvec4(0.25, 1, 0.5, 2));
  expect_elementary(model.surfaces.at(trimmed.basis), SurfaceKind::kTorus, 8, 2);

  const Surface& offset = surface(10);
  EXPECT_EQ(offset.kind, SurfaceKind::kOffset);
  EXPECT_EQ(offset.offset, 0.125);
  expect_spline(model.surfaces.at(offset.basis));

  // OpenCascade trims the basis of a trimmed offset too.
  const Surface& chain = surface(13);
  EXPECT_EQ(chain.kind, SurfaceKind::kTrimmed);
  const Surface& inner = model.surfaces.at(chain.basis);
  EXPECT_EQ(inner.kind, SurfaceKind::kOffset);
  EXPECT_EQ(inner.offset, 1);
  const Surface& innermost = model.surfaces.at(inner.basis);
  EXPECT_EQ(innermost.kind, SurfaceKind::kTrimmed);
  expect_elementary(model.surfaces.at(innermost.basis), SurfaceKind::kTorus, 8, 2);
}

TEST_F(BintoolsSurfaces, FacesKeepToleranceAndNaturalRestriction) {
  for (std::size_t i = 0; i < model.faces.size(); ++i) {
    EXPECT_EQ(model.faces[i].tolerance, 0.001 * static_cast<double>(i + 1));
    EXPECT_EQ(model.faces[i].natural_restriction, i % 2 == 0);
    EXPECT_EQ(model.faces[i].mesh, -1);
  }
}

}  // namespace
}  // namespace trimray::brep
