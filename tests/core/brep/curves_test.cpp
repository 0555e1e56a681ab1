// Curves of every kind, in space and in uv, against the numbers in make_streams.py.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/brep/bintools.h"
#include "tests/core/brep/streams.h"

namespace trimray::brep {
namespace {

template <typename Vec>
Vec vec(double x, double y, double z) {
  if constexpr (Vec::length() == 2) {
    return Vec(x, y);
  } else {
    return Vec(x, y, z);
  }
}

// The conics 1..4 share a frame at (1, 2, 3) with x along y.
template <typename Vec>
void expect_conic(const Curve<Vec>& curve, CurveKind kind, double r1, double r2, const Vec& y_axis) {
  EXPECT_EQ(curve.kind, kind);
  EXPECT_EQ(curve.location, vec<Vec>(1, 2, 3));
  EXPECT_EQ(curve.x_axis, vec<Vec>(0, 1, 0));
  EXPECT_EQ(curve.y_axis, y_axis);
  EXPECT_EQ(curve.r1, r1);
  EXPECT_EQ(curve.r2, r2);
}

template <typename Vec>
void expect_bezier(const Curve<Vec>& curve) {
  EXPECT_EQ(curve.kind, CurveKind::kBezier);
  EXPECT_EQ(curve.degree, 3);
  EXPECT_TRUE(curve.rational);
  const std::vector<Vec> poles = {vec<Vec>(0, 0, 0), vec<Vec>(1, 2, 0), vec<Vec>(3, 2, 1), vec<Vec>(4, 0, 2)};
  EXPECT_EQ(curve.poles, poles);
  // OpenCascade divides nothing here: weights arrive as given.
  EXPECT_EQ(curve.weights, (std::vector<double>{1, 0.5, 0.25, 2}));
  EXPECT_EQ(curve.knots, (std::vector<double>{0, 1}));
  EXPECT_EQ(curve.multiplicities, (std::vector<std::int32_t>{4, 4}));
}

template <typename Vec>
void expect_spline(const Curve<Vec>& curve) {
  EXPECT_EQ(curve.kind, CurveKind::kBspline);
  EXPECT_EQ(curve.degree, 2);
  EXPECT_FALSE(curve.rational);
  EXPECT_FALSE(curve.periodic);
  EXPECT_TRUE(curve.weights.empty());
  ASSERT_EQ(curve.poles.size(), 4u);
  EXPECT_EQ(curve.poles[2], vec<Vec>(3, 2, 1));
  EXPECT_EQ(curve.knots, (std::vector<double>{0, 0.5, 2}));
  EXPECT_EQ(curve.multiplicities, (std::vector<std::int32_t>{3, 1, 3}));
}

template <typename Vec>
void expect_periodic_spline(const Curve<Vec>& curve) {
  EXPECT_EQ(curve.kind, CurveKind::kBspline);
  EXPECT_EQ(curve.degree, 3);
  EXPECT_TRUE(curve.rational);
  EXPECT_TRUE(curve.periodic);
  EXPECT_EQ(curve.poles.size(), 4u);
  EXPECT_EQ(curve.weights, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(curve.knots, (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(curve.multiplicities, (std::vector<std::int32_t>{1, 1, 1, 1, 1}));
}

TEST(BintoolsCurves, EveryKindInSpace) {
  const Model model = parse_bintools(testing::read_stream("curves3"));
  ASSERT_EQ(model.edges.size(), 11u);
  const auto curve = [&](std::size_t edge) { return model.curves3.at(model.edges.at(edge).curve3); };

  EXPECT_EQ(curve(0).kind, CurveKind::kLine);
  EXPECT_EQ(curve(0).location, dvec3(1, 2, 3));
  EXPECT_EQ(curve(0).x_axis, dvec3(0, 0, -1));
  const dvec3 y_axis(-1, 0, 0);
  expect_conic(curve(1), CurveKind::kCircle, 2.5, 0, y_axis);
  expect_conic(curve(2), CurveKind::kEllipse, 5, 3, y_axis);
  expect_conic(curve(3), CurveKind::kParabola, 0.75, 0, y_axis);
  expect_conic(curve(4), CurveKind::kHyperbola, 4, 6, y_axis);
  expect_bezier(curve(5));
  expect_spline(curve(6));

  EXPECT_EQ(curve(7).kind, CurveKind::kTrimmed);
  EXPECT_EQ(curve(7).first, 0.25);
  EXPECT_EQ(curve(7).last, 1.5);
  expect_conic(model.curves3.at(curve(7).basis), CurveKind::kCircle, 2.5, 0, y_axis);

  EXPECT_EQ(curve(8).kind, CurveKind::kOffset);
  EXPECT_EQ(curve(8).offset, 0.125);
  EXPECT_EQ(curve(8).offset_direction, dvec3(0, 0, 1));
  expect_spline(model.curves3.at(curve(8).basis));
  expect_periodic_spline(curve(9));

  EXPECT_EQ(curve(10).kind, CurveKind::kOffset);
  EXPECT_EQ(curve(10).offset, -1);
  EXPECT_EQ(curve(10).offset_direction, dvec3(1, 0, 0));
  const Curve3& trimmed = model.curves3.at(curve(10).basis);
  EXPECT_EQ(trimmed.kind, CurveKind::kTrimmed);
  EXPECT_EQ(trimmed.first, 0.5);
  expect_spline(model.curves3.at(trimmed.basis));
}

TEST(BintoolsCurves, EdgesKeepToleranceAndRange) {
  const Model model = parse_bintools(testing::read_stream("curves3"));
  for (std::size_t i = 0; i < model.edges.size(); ++i) {
    EXPECT_EQ(model.edges[i].tolerance, 0.001 * static_cast<double>(i + 1));
    EXPECT_EQ(model.edges[i].first, 0.5);
    EXPECT_EQ(model.edges[i].last, 0.75 + static_cast<double>(i));
    EXPECT_EQ(model.edges[i].location, -1);
    EXPECT_TRUE(model.edges[i].pcurves.empty());
    EXPECT_FALSE(model.edges[i].smooth);
  }
}

TEST(BintoolsCurves, EveryKindInSurfaceParameters) {
  const Model model = parse_bintools(testing::read_stream("curves2"));
  ASSERT_EQ(model.edges.size(), 1u);
  EXPECT_EQ(model.edges[0].curve3, -1);
  std::vector<PCurve> pcurves = model.edges[0].pcurves;
  ASSERT_EQ(pcurves.size(), 10u);
  // The plane of the k-th p-curve stands at z = k; the order of the records is OpenCascade's affair.
  const auto height = [&](const PCurve& p) { return model.surfaces.at(p.surface).location.z; };
  std::ranges::sort(pcurves, {}, height);
  const auto curve = [&](std::size_t k) { return model.curves2.at(pcurves.at(k).curve); };
  for (std::size_t k = 0; k < pcurves.size(); ++k) {
    EXPECT_EQ(height(pcurves[k]), static_cast<double>(k));
    EXPECT_EQ(pcurves[k].curve2, -1);
    EXPECT_EQ(pcurves[k].first, 0.5);
    EXPECT_EQ(pcurves[k].last, 0.75 + static_cast<double>(k));
  }

  EXPECT_EQ(curve(0).kind, CurveKind::kLine);
  EXPECT_EQ(curve(0).location, dvec2(1, 2));
  EXPECT_EQ(curve(0).x_axis, dvec2(0, -1));
  const dvec2 y_axis(1, 0);  // left-handed
  expect_conic(curve(1), CurveKind::kCircle, 2.5, 0, y_axis);
  expect_conic(curve(2), CurveKind::kEllipse, 5, 3, y_axis);
  expect_conic(curve(3), CurveKind::kParabola, 0.75, 0, y_axis);
  expect_conic(curve(4), CurveKind::kHyperbola, 4, 6, y_axis);
  expect_bezier(curve(5));
  expect_spline(curve(6));
  EXPECT_EQ(curve(7).kind, CurveKind::kTrimmed);
  EXPECT_EQ(curve(7).last, 1.5);
  expect_conic(model.curves2.at(curve(7).basis), CurveKind::kCircle, 2.5, 0, y_axis);
  EXPECT_EQ(curve(8).kind, CurveKind::kOffset);
  EXPECT_EQ(curve(8).offset, 0.125);
  expect_spline(model.curves2.at(curve(8).basis));
  expect_periodic_spline(curve(9));
}

}  // namespace
}  // namespace trimray::brep
