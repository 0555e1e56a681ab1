// Distances that are known: whole analytic surfaces, and plane faces with holes.
#include <numbers>

#include "tests/core/distance/probes.h"
#include "tests/core/tess/trimmed_stores.h"

namespace trimray::distance {
namespace {

using nurbs::Frame3;
constexpr double kPi = std::numbers::pi;

const Frame3 kFrame{{1.0, -2.0, 3.0}, {1.0, 2.0, 0.5}, {0.3, -0.2, 1.0}};

struct Cylindrical {
  double rho, z;
};
Cylindrical in_frame(const dvec3& p) {
  const dvec3 d = p - kFrame.location, axis = glm::normalize(kFrame.z_axis);
  const double z = glm::dot(d, axis);
  return {glm::length(d - z * axis), z};
}

double sphere_distance(const dvec3& p) { return std::abs(glm::distance(p, kFrame.location) - 2.0); }
double torus_distance(const dvec3& p) {
  const Cylindrical c = in_frame(p);
  return std::abs(std::hypot(c.rho - 3.0, c.z) - 1.0);
}
// Of radius 1.5 from z = -1 to 2, open at both ends.
double tube_distance(const dvec3& p) {
  const Cylindrical c = in_frame(p);
  return std::hypot(c.rho - 1.5, std::max({-1.0 - c.z, c.z - 2.0, 0.0}));
}

template <typename Expected>
void expect_distances(const nurbs::FaceSpec& face, const Expected& expected, std::vector<dvec3> queries,
                      bool with_axis = true) {
  const auto store = shared(nurbs::make_store(std::span(&face, 1)));
  const PointIndex index(store);
  const nurbs::TrimIndex trims(*store);
  const dvec3 axis = glm::normalize(kFrame.z_axis);
  // Where a whole circle or sphere is nearest, and beside it.
  for (const double h : {0.0, 0.5, -0.75})
    for (const double off : {0.0, 1e-14, 1e-9, 1e-4}) {
      if (!with_axis) continue;
      queries.push_back(kFrame.location + h * axis + off * dvec3(1.0, 0.5, 0.0));
    }
  for (const dvec3& q : queries) {
    const Nearest n = index.nearest(q);
    EXPECT_NEAR(n.distance, expected(q), 1e-12 * index.diagonal());
    expect_sound(*store, trims, q, n, index.diagonal());
    if (testing::Test::HasFatalFailure()) return;
  }
}

std::vector<dvec3> queries() { return random_points(400, kFrame.location, 5.0); }

TEST(ClosedForms, FullSphere) {
  expect_distances(nurbs::full_sphere(kFrame, 2.0), sphere_distance, queries());
}
TEST(ClosedForms, FullTorus) {
  expect_distances(nurbs::full_torus(kFrame, 3.0, 1.0), torus_distance, queries());
}
TEST(ClosedForms, Tube) { expect_distances(nurbs::tube(kFrame, 1.5, -1.0, 2.0), tube_distance, queries()); }

nurbs::FaceSpec splined(nurbs::FaceSpec face) {
  face.surface = nurbs::as_nurbs(std::move(face.surface));
  return face;
}

TEST(ClosedForms, NurbsSphere) {
  expect_distances(splined(nurbs::full_sphere(kFrame, 2.0)), sphere_distance, queries());
}
TEST(ClosedForms, NurbsTorus) {
  expect_distances(splined(nurbs::full_torus(kFrame, 3.0, 1.0)), torus_distance, queries());
}
TEST(ClosedForms, NurbsTube) {
  expect_distances(splined(nurbs::tube(kFrame, 1.5, -1.0, 2.0)), tube_distance, queries());
}

// Points on an offset's own axis are left to the bound that comes with the answer.
TEST(ClosedForms, OffsetSphereAndTorus) {
  nurbs::FaceSpec sphere = nurbs::full_sphere(kFrame, 1.5);
  sphere.surface = nurbs::as_offset(nurbs::as_nurbs(std::move(sphere.surface)), 0.5);
  sphere.natural = true;  // its edges would lie on the base
  expect_distances(sphere, sphere_distance, random_points(100, kFrame.location, 5.0), false);
  nurbs::FaceSpec torus = nurbs::full_torus(kFrame, 3.0, 1.25);
  torus.surface = nurbs::as_offset(nurbs::as_nurbs(std::move(torus.surface)), -0.25);
  torus.natural = true;
  expect_distances(torus, torus_distance, random_points(100, kFrame.location, 5.0), false);
}

TEST(ClosedForms, SpindleTorusHasAnInnerSheet) {
  const nurbs::FaceSpec face = nurbs::full_torus(kFrame, 1.0, 2.0);
  expect_distances(
      face,
      [](const dvec3& p) {
        const Cylindrical c = in_frame(p);
        return std::min(std::abs(std::hypot(c.rho - 1.0, c.z) - 2.0),
                        std::abs(std::hypot(c.rho + 1.0, c.z) - 2.0));
      },
      queries());
}

// A square with a square hole and a round one, by hand.
TEST(ClosedForms, PlaneWithHoles) {
  using nurbs::polygon;
  const std::vector<dvec2> outer{{0, 0}, {10, 0}, {10, 10}, {0, 10}}, hole{{2, 2}, {2, 5}, {5, 5}, {5, 2}};
  const auto store = shared(nurbs::trimmed_face(
      nurbs::make_plane({}),
      {polygon(outer), polygon(hole), nurbs::turned(nurbs::ellipse({7.5, 7.5}, 1.5, 1.5))}));
  const PointIndex index(store);
  const nurbs::TrimIndex trims(*store);
  int on_edge = 0, on_face = 0;
  for (const dvec3& q : random_points(3000, {5, 5, 0}, 8.0)) {
    const auto outside = [](double x, double lower, double upper) {
      return std::max({lower - x, x - upper, 0.0});
    };
    double flat = std::hypot(outside(q.x, 0, 10), outside(q.y, 0, 10));
    if (q.x > 2 && q.x < 5 && q.y > 2 && q.y < 5) flat = std::min({q.x - 2, 5 - q.x, q.y - 2, 5 - q.y});
    flat = std::max(flat, 1.5 - std::hypot(q.x - 7.5, q.y - 7.5));
    const Nearest n = index.nearest(q);
    // The edge of the round hole is fitted, within its band.
    EXPECT_NEAR(n.distance, std::hypot(flat, q.z), 1e-9);
    EXPECT_EQ(n.edge >= 0, flat > 0.0);
    ++(n.edge >= 0 ? on_edge : on_face);
    expect_sound(*store, trims, q, n, index.diagonal());
  }
  EXPECT_GT(on_edge, 500);
  EXPECT_GT(on_face, 500);
}

nurbs::TrimLoop box_loop(const Box2& b) {
  return nurbs::polygon({b.lower, {b.upper.x, b.lower.y}, b.upper, {b.lower.x, b.upper.y}});
}

class TrimmedKinds : public testing::TestWithParam<int> {};

TEST_P(TrimmedKinds, BetweenTheBoundsOfManyPoints) {
  const Frame3 frame = kFrame;
  const nurbs::SurfaceForm forms[] = {nurbs::make_cylinder(frame, 1.5), nurbs::make_cone(frame, 1.0, 0.4),
                                      nurbs::make_sphere(frame, 2.0), nurbs::make_torus(frame, 3.0, 1.0)};
  const nurbs::SurfaceForm& form = forms[GetParam() % 4];
  // uv: a rectangle with a round hole. The cone's apex is at v = -2.57.
  const nurbs::TrimLoop hole = nurbs::turned(nurbs::ellipse({1.6, 0.2}, 0.5, 0.4));
  const nurbs::NurbsStore store = nurbs::trimmed_face(GetParam() < 4 ? form : nurbs::as_nurbs(form),
                                                      {box_loop({{0.3, -0.9}, {3.8, 1.1}}), hole});
  expect_between_bounds(store, random_points(250, frame.location, 5.0), 160);
}
INSTANTIATE_TEST_SUITE_P(Kinds, TrimmedKinds, testing::Range(0, 8));

}  // namespace
}  // namespace trimray::distance
