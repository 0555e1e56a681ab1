// Boxes: conservative where promised, and tight.
#include "core/nurbs/bounds.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/nurbs/make_store.h"

using namespace trimray;
using namespace trimray::nurbs;

namespace {

void expect_box(const Box3& box, dvec3 lower, dvec3 upper, double margin) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(box.lower[i], lower[i], margin) << i;
    EXPECT_NEAR(box.upper[i], upper[i], margin) << i;
  }
}

// Half extent of a torus along a unit direction.
double torus_reach(double major, double minor, dvec3 axis, dvec3 direction) {
  return major * glm::length(direction - glm::dot(direction, axis) * axis) + minor;
}

}  // namespace

TEST(Bounds, tightOnTiltedClosedForms) {
  const dvec3 axis = glm::normalize(dvec3(0.3, -0.5, 0.8)), centre(10, 20, 30);
  const Frame3 frame{centre, {1, 0, 0}, axis};
  const FaceSpec sphere = full_sphere(frame, 2.0), torus = full_torus(frame, 3.0, 1.0);
  const NurbsStore s = make_store({&sphere, 1}), t = make_store({&torus, 1});
  expect_box(face_bounds(s, TrimIndex(s), 0), centre - 2.0, centre + 2.0, 2e-6);
  const dvec3 reach(torus_reach(3, 1, axis, {1, 0, 0}), torus_reach(3, 1, axis, {0, 1, 0}),
                    torus_reach(3, 1, axis, {0, 0, 1}));
  expect_box(face_bounds(t, TrimIndex(t), 0), centre - reach, centre + reach, 4e-6);
}

TEST(Bounds, onlyTheTrimmedPartCounts) {
  const FaceSpec cap{as_nurbs(make_sphere({}, 2.0)), {{0.2, 0.3}, {1.1, 0.9}}};
  const NurbsStore store = make_store({&cap, 1});
  const dvec3 lower(2 * std::cos(1.1) * std::cos(0.9), 2 * std::sin(0.2) * std::cos(0.9), 2 * std::sin(0.3));
  const dvec3 upper(2 * std::cos(0.2) * std::cos(0.3), 2 * std::sin(1.1) * std::cos(0.3), 2 * std::sin(0.9));
  expect_box(face_bounds(store, TrimIndex(store), 0), lower, upper, 1e-6);
  // The hull contains it, always.
  const Box3 hull = store.prototypes[0].bounds;
  EXPECT_TRUE(hull.contains(lower) && hull.contains(upper));
}

TEST(Bounds, modelBoundsPlaceInstances) {
  const FaceSpec sphere = full_sphere({}, 2.0);
  NurbsStore store = make_store({&sphere, 1});
  store.instances.push_back(store.instances[0]);
  store.instances[1].placement.translation = {10, 0, 0};
  expect_box(model_bounds(store, TrimIndex(store)), {-2, -2, -2}, {12, 2, 2}, 2e-6);
}
