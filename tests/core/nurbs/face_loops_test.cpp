// Wires as real files leave them: without seams, without poles, in another period, out of order.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/nurbs/build_store.h"
#include "core/nurbs/trim.h"
#include "tests/core/nurbs/store_invariants.h"

using namespace trimray;
using namespace trimray::nurbs;

namespace {

constexpr double kPi = std::numbers::pi;

// A model of one face, made edge by edge. Every edge has an exact 3D curve and a straight p-curve.
class OneFace {
 public:
  explicit OneFace(brep::SurfaceKind kind, double r1, double r2 = 0.0, double semi_angle = 0.0) {
    brep::Surface s;
    s.kind = kind, s.r1 = r1, s.r2 = r2, s.semi_angle = semi_angle;
    s.x_axis = {1, 0, 0}, s.y_axis = {0, 1, 0}, s.z_axis = {0, 0, 1};
    model_.surfaces.push_back(s);
  }

  std::int32_t vertex(dvec3 p) {
    model_.vertices.push_back({p, 1e-7});
    model_.shapes.push_back(
        {brep::ShapeKind::kVertex, static_cast<std::int32_t>(model_.vertices.size()) - 1, false, {}});
    return static_cast<std::int32_t>(model_.shapes.size()) - 1;
  }

  // A circle of the given centre and frame over [first, last]; uv = from + t * step on the surface.
  std::int32_t arc(dvec3 centre, dvec3 x, dvec3 y, double radius, double first, double last, dvec2 from,
                   dvec2 step, std::int32_t v0, std::int32_t v1) {
    brep::Curve3 c;
    c.kind = brep::CurveKind::kCircle, c.location = centre, c.x_axis = x, c.y_axis = y, c.r1 = radius;
    return edge(c, first, last, from, step, v0, v1);
  }

  std::int32_t line(dvec3 start, dvec3 direction, double first, double last, dvec2 from, dvec2 step,
                    std::int32_t v0, std::int32_t v1) {
    brep::Curve3 c;
    c.kind = brep::CurveKind::kLine, c.location = start, c.x_axis = direction;
    return edge(c, first, last, from, step, v0, v1);
  }

  std::int32_t edge(const brep::Curve3& c, double first, double last, dvec2 from, dvec2 step, std::int32_t v0,
                    std::int32_t v1) {
    model_.curves3.push_back(c);
    brep::EdgeData e;
    e.tolerance = 1e-7, e.curve3 = static_cast<std::int32_t>(model_.curves3.size()) - 1, e.first = first,
    e.last = last;
    if (with_pcurves) {
      brep::Curve2 p;
      p.kind = brep::CurveKind::kLine, p.location = from, p.x_axis = step;
      model_.curves2.push_back(p);
      e.pcurves.push_back({static_cast<std::int32_t>(model_.curves2.size()) - 1, -1, 0, -1, first, last});
    }
    model_.edges.push_back(e);
    brep::Shape s{brep::ShapeKind::kEdge, static_cast<std::int32_t>(model_.edges.size()) - 1, false, {}};
    s.children.push_back({v0, brep::Orientation::kForward, -1});
    s.children.push_back({v1, brep::Orientation::kReversed, -1});
    model_.shapes.push_back(s);
    return static_cast<std::int32_t>(model_.shapes.size()) - 1;
  }

  void wire(const std::vector<std::pair<std::int32_t, bool>>& edges) {
    brep::Shape w{brep::ShapeKind::kWire, -1, true, {}};
    for (const auto& [shape, reversed] : edges)
      w.children.push_back(
          {shape, reversed ? brep::Orientation::kReversed : brep::Orientation::kForward, -1});
    model_.shapes.push_back(w);
    wires_.push_back(static_cast<std::int32_t>(model_.shapes.size()) - 1);
  }

  NurbsStore build() {
    model_.faces.push_back({0, -1, 1e-7, false, false});
    brep::Shape f{brep::ShapeKind::kFace, 0, false, {}};
    for (const std::int32_t w : wires_) f.children.push_back({w, brep::Orientation::kForward, -1});
    model_.shapes.push_back(f);
    BuildInput in;
    in.prototype_shapes = {static_cast<std::int32_t>(model_.shapes.size())};
    in.prototype_colors = {-1, 0, 0, 1};
    NurbsStore store = build_store(model_, in);
    validate(store);
    return store;
  }

  bool with_pcurves = true;

 private:
  brep::Model model_;
  std::vector<std::int32_t> wires_;
};

// Fraction of mismatches between the trim's answer and the expected one, on a grid over one period and the v
// range.
int mismatches(const NurbsStore& store, double v0, double v1,
               const std::function<bool(double, double)>& expected) {
  const TrimIndex trims(store);
  int wrong = 0;
  for (int i = 0; i < 97; ++i)
    for (int j = 0; j < 61; ++j) {
      const dvec2 uv(2.0 * kPi * (i + 0.37) / 97.0, v0 + (v1 - v0) * (j + 0.41) / 61.0);
      const dvec2 wrapped = trims.wrap(0, uv);
      const Box2& box = store.faces[0].uv_box;
      wrong += (box.contains(wrapped) && trims.inside(0, wrapped)) != expected(uv.x, uv.y);
    }
  return wrong;
}

void expect_sound(const NurbsStore& store) {
  ASSERT_EQ(store.faces[0].status, FaceStatus::kOk) << status_reason(store.faces[0].status);
  const invariants::Findings f = invariants::check(store, 20, 3);
  EXPECT_EQ(f.loops_open, 0);
  EXPECT_EQ(f.points_outside, 0);
}

constexpr dvec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};

}  // namespace

TEST(FaceLoops, cylinderRimsWithoutSeam) {
  for (const double turn : {0.0, 1.0, 3.5}) {  // where the upper rim begins
    OneFace f(brep::SurfaceKind::kCylinder, 2.0);
    const std::int32_t low = f.vertex({2, 0, 1}),
                       high = f.vertex({2 * std::cos(turn), 2 * std::sin(turn), 4});
    const std::int32_t bottom = f.arc({0, 0, 1}, kX, kY, 2.0, 0, 2 * kPi, {0, 1}, {1, 0}, low, low);
    const std::int32_t top = f.arc({0, 0, 4}, kX, kY, 2.0, turn, turn + 2 * kPi, {0, 4}, {1, 0}, high, high);
    f.wire({{bottom, false}});
    f.wire({{top, true}});
    const NurbsStore store = f.build();
    expect_sound(store);
    EXPECT_EQ(mismatches(store, 0.0, 5.0, [](double, double v) { return v > 1.0 && v < 4.0; }), 0) << turn;
    EXPECT_NEAR(store.faces[0].uv_box.extent().x, 2 * kPi, 1e-12);
  }
}

TEST(FaceLoops, sphereCapOfOneCircle) {
  for (const bool upper : {true, false}) {
    OneFace f(brep::SurfaceKind::kSphere, 2.0);
    const std::int32_t v = f.vertex({2 * std::cos(0.5), 0, 2 * std::sin(0.5)});
    const std::int32_t rim =
        f.arc({0, 0, 2 * std::sin(0.5)}, kX, kY, 2 * std::cos(0.5), 0, 2 * kPi, {0, 0.5}, {1, 0}, v, v);
    f.wire({{rim, !upper}});
    const NurbsStore store = f.build();
    expect_sound(store);
    EXPECT_EQ(mismatches(store, -kPi / 2, kPi / 2, [&](double, double w) { return (w > 0.5) == upper; }), 0);
  }
}

TEST(FaceLoops, coneOfOneCircleReachesItsApex) {
  OneFace f(brep::SurfaceKind::kCone, 2.0, 0.0, kPi / 4);  // apex at v = -2 sqrt 2
  const std::int32_t v = f.vertex({2, 0, 0});
  const std::int32_t rim = f.arc({0, 0, 0}, kX, kY, 2.0, 0, 2 * kPi, {0, 0}, {1, 0}, v, v);
  f.wire({{rim, true}});
  const NurbsStore store = f.build();
  expect_sound(store);
  const double apex = -2.0 * std::numbers::sqrt2;
  EXPECT_EQ(mismatches(store, -4.0, 2.0, [&](double, double w) { return w < 0.0 && w > apex; }), 0);
}

TEST(FaceLoops, torusBandOverThePeriod) {
  // From v = 5 up over 2 pi to v = 1.
  OneFace f(brep::SurfaceKind::kTorus, 5.0, 1.0);
  const auto rim = [&](double v) {
    const double r = 5 + std::cos(v), z = std::sin(v);
    const std::int32_t p = f.vertex({r, 0, z});
    return f.arc({0, 0, z}, kX, kY, r, 0, 2 * kPi, {0, v}, {1, 0}, p, p);
  };
  f.wire({{rim(5.0), false}});
  f.wire({{rim(1.0), true}});
  const NurbsStore store = f.build();
  expect_sound(store);
  EXPECT_EQ(mismatches(store, 0.0, 2 * kPi, [](double, double v) { return v > 5.0 || v < 1.0; }), 0);
}

TEST(FaceLoops, sphereOctantWithoutPoleEdge) {
  for (const double shift : {0.0, 2 * kPi}) {  // one meridian drawn a period further
    OneFace f(brep::SurfaceKind::kSphere, 2.0);
    const std::int32_t a = f.vertex({2, 0, 0}), b = f.vertex({0, 2, 0}), pole = f.vertex({0, 0, 2});
    const std::int32_t equator = f.arc({0, 0, 0}, kX, kY, 2, 0, kPi / 2, {0, 0}, {1, 0}, a, b);
    const std::int32_t up = f.arc({0, 0, 0}, kY, kZ, 2, 0, kPi / 2, {kPi / 2, 0}, {0, 1}, b, pole);
    const std::int32_t down = f.arc({0, 0, 0}, kX, kZ, 2, 0, kPi / 2, {shift, 0}, {0, 1}, a, pole);
    f.wire({{equator, false}, {down, true}, {up, false}});  // stored out of order
    const NurbsStore store = f.build();
    expect_sound(store);
    EXPECT_EQ(mismatches(store, -kPi / 2, kPi / 2, [](double u, double v) { return v > 0.0 && u < kPi / 2; }),
              0)
        << shift;
    EXPECT_TRUE(store.faces[0].iso_rectangle);
  }
}

TEST(FaceLoops, holeAcrossTheSeam) {
  // A square hole over |u| < 0.4, 2 < v < 3 in a band without seam.
  OneFace f(brep::SurfaceKind::kCylinder, 2.0);
  const std::int32_t low = f.vertex({2, 0, 1}), high = f.vertex({2, 0, 4});
  f.wire({{f.arc({0, 0, 1}, kX, kY, 2.0, 0, 2 * kPi, {0, 1}, {1, 0}, low, low), false}});
  f.wire({{f.arc({0, 0, 4}, kX, kY, 2.0, 0, 2 * kPi, {0, 4}, {1, 0}, high, high), true}});
  const auto corner = [&](double u, double v) { return f.vertex({2 * std::cos(u), 2 * std::sin(u), v}); };
  const std::int32_t p = corner(-0.4, 2), q = corner(0.4, 2), r = corner(0.4, 3), s = corner(-0.4, 3);
  const auto along = [&](double u) { return dvec3(2 * std::cos(u), 2 * std::sin(u), 0); };
  f.wire({{f.arc({0, 0, 2}, kX, kY, 2, -0.4, 0.4, {0, 2}, {1, 0}, p, q), true},
          {f.line(along(-0.4), kZ, 2, 3, {-0.4, 0}, {0, 1}, p, s), false},
          {f.arc({0, 0, 3}, kX, kY, 2, -0.4, 0.4, {0, 3}, {1, 0}, s, r), false},
          {f.line(along(0.4), kZ, 2, 3, {0.4, 0}, {0, 1}, q, r), true}});
  const NurbsStore store = f.build();
  expect_sound(store);
  const auto expected = [](double u, double v) {
    const double near = u > kPi ? u - 2 * kPi : u;
    return v > 1 && v < 4 && !(std::abs(near) < 0.4 && v > 2 && v < 3);
  };
  EXPECT_EQ(mismatches(store, 0.0, 5.0, expected), 0);
}

TEST(FaceLoops, missingPCurvesAreProjected) {
  OneFace f(brep::SurfaceKind::kCylinder, 2.0);
  f.with_pcurves = false;
  const auto corner = [&](double u, double v) { return f.vertex({2 * std::cos(u), 2 * std::sin(u), v}); };
  const auto along = [&](double u) { return dvec3(2 * std::cos(u), 2 * std::sin(u), 0); };
  const std::int32_t p = corner(2.5, 2), q = corner(4.0, 2), r = corner(4.0, 3), s = corner(2.5, 3);
  f.wire({{f.arc({0, 0, 2}, kX, kY, 2, 2.5, 4.0, {}, {}, p, q), false},
          {f.line(along(4.0), kZ, 2, 3, {}, {}, q, r), false},
          {f.arc({0, 0, 3}, kX, kY, 2, 2.5, 4.0, {}, {}, s, r), true},
          {f.line(along(2.5), kZ, 2, 3, {}, {}, p, s), true}});
  const NurbsStore store = f.build();
  expect_sound(store);
  EXPECT_EQ(
      mismatches(store, 0.0, 5.0, [](double u, double v) { return u > 2.5 && u < 4.0 && v > 2 && v < 3; }),
      0);
  for (const Edge& e : store.edges) EXPECT_LE(e.band, 1e-7);
}

TEST(FaceLoops, unboundedFaceWithoutLoopsIsBadTrim) {
  OneFace plane(brep::SurfaceKind::kPlane, 0.0);
  EXPECT_EQ(plane.build().faces[0].status, FaceStatus::kBadTrim);
  OneFace sphere(brep::SurfaceKind::kSphere, 3.0);
  const NurbsStore store = sphere.build();
  EXPECT_EQ(store.faces[0].status, FaceStatus::kOk);
  EXPECT_TRUE(store.shells[0].closed);
  EXPECT_TRUE(store.faces[0].iso_rectangle);
}
