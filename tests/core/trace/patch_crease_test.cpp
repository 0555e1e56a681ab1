// Where surfaces are not smooth: apexes, creases, knots of full multiplicity.
#include <gtest/gtest.h>

#include "tests/core/trace/patch_rays.h"

namespace trimray::trace {
namespace {

using nurbs::FaceSpec;
using nurbs::Frame3;

// A roof over [0, 2] x [0, 1], its ridge at x = 1, z = 1: degree 3 in u, with the ridge's knot of the given
// multiplicity (3: the sides share its points; 4: each has its own).
FaceSpec roof(int multiplicity) {
  std::vector<double> knots{0, 0, 0, 0};
  knots.insert(knots.end(), multiplicity, 0.5);
  knots.insert(knots.end(), 4, 1.0);
  std::vector<dvec4> ctrl;
  for (int side = 0; side < 2; ++side)
    for (int i = side == 1 && multiplicity == 3 ? 1 : 0; i <= 3; ++i)
      for (int j = 0; j < 2; ++j) {
        const double x = side + i / 3.0;
        ctrl.push_back(dvec4(x, j, side == 0 ? x : 2.0 - x, 1.0));
      }
  FaceSpec face;
  face.surface = nurbs::make_bspline(3, 1, knots, {0, 0, 1, 1}, ctrl);
  face.uv_box.add(dvec2(0.0)), face.uv_box.add(dvec2(1.0));
  return face;
}

TEST(PatchCrease, NoRayFallsThroughTheRidge) {
  for (const int multiplicity : {3, 4}) {
    const Made made(roof(multiplicity));
    std::mt19937 rng(31);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (int k = 0; k < 4000; ++k) {
      // Through the ridge, up to rounding or 1e-6 beside it, from anywhere above both sides.
      const double aside = k % 4 == 0 ? 0.0 : std::pow(10.0, -6.0 - 11.0 * uniform(rng)) * (k % 2 ? 1 : -1);
      const double slope = 0.999 * (2.0 * uniform(rng) - 1.0);
      const dvec3 d = glm::normalize(dvec3(slope, 0.2 * uniform(rng) - 0.1, -1.0));
      const Ray ray{dvec3(1.0 + aside, 0.3 + 0.4 * uniform(rng), 1.0) - 3.0 * d, d};
      const Traced traced = trace_leaves(made.set, ray, 2.5);
      ASSERT_EQ(traced.roots.size(), 1u) << describe(ray) << " aside " << aside;
      EXPECT_NEAR(traced.roots[0].t, 3.0, 1e-3 + 3000 * std::fabs(aside));
    }
  }
}

TEST(PatchCrease, LevelRaysCrossTheRoofTwiceOrNotAtAll) {
  const Made made(roof(3));
  std::mt19937 rng(32);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int k = 0; k < 2000; ++k) {
    const double below = std::pow(10.0, -11.0 * uniform(rng)) * (k % 2 ? 0.5 : -0.5);
    const dvec3 d = glm::normalize(dvec3(1.0, 0.1 * uniform(rng), 0.0));
    const Ray ray{dvec3(1.0, 0.5, 1.0 - below) - 4.0 * d, d};
    EXPECT_EQ(trace_leaves(made.set, ray, 2.5).roots.size(), below > 0.0 ? 2u : 0u) << describe(ray) << below;
  }
}

// A cone from its apex down; the apex is a collapsed side where the surface has no normal.
TEST(PatchCrease, ConesHaveTheirRootsUpToTheApex) {
  const Frame3 frame{dvec3(1, 2, 3), dvec3(1, 0, 0), glm::normalize(dvec3(0.2, -0.3, 1))};
  const double radius = 2.0, angle = 0.5, slant = radius / std::sin(angle);
  FaceSpec face;
  face.surface = nurbs::as_nurbs(nurbs::make_cone(frame, radius, angle));
  face.uv_box.add(dvec2(0.0, -slant)), face.uv_box.add(dvec2(2.0 * std::acos(-1.0), 3.0));
  const Made made(face);
  const dvec3 axis = glm::normalize(frame.z_axis), apex = frame.location - radius / std::tan(angle) * axis;
  std::mt19937 rng(33);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int tested = 0;
  for (int k = 0; k < 3000; ++k) {
    const dvec3 d = glm::normalize(dvec3(normal(rng), normal(rng), normal(rng)));
    const double distance = k % 3 == 0 ? std::pow(10.0, -8.0 * uniform(rng)) : 4.0 * uniform(rng);
    const dvec3 at = k % 3 == 0 ? apex : apex + 4.0 * uniform(rng) * axis;
    const Ray ray{at + distance * dvec3(normal(rng), normal(rng), normal(rng)) - 20.0 * d, d};
    // (p . axis)^2 = cos^2 |p|^2 with p from the apex, and p . axis > 0.
    const dvec3 q = ray.org + 20.0 * d - apex;
    const double c2 = std::cos(angle) * std::cos(angle), da = glm::dot(d, axis), qa = glm::dot(q, axis);
    const double a = da * da - c2, b = qa * da - c2 * glm::dot(q, d), c = qa * qa - c2 * glm::dot(q, q);
    const double disc = b * b - a * c, top = (slant + 3.0) * std::cos(angle);
    if (std::fabs(a) < 1e-3 || std::fabs(disc) < 1e-6 * b * b || !(std::fabs(disc) > 1e-22)) continue;
    std::vector<double> truth;
    bool rim = false;
    if (disc > 0.0)
      for (const double t : {(-b - std::sqrt(disc)) / a, (-b + std::sqrt(disc)) / a}) {
        const double height = qa + t * da;
        rim = rim || std::fabs(height - top) < 0.01 || std::fabs(height) < 1e-9;
        if (height > 0.0 && height < top) truth.push_back(20.0 + t);
      }
    if (rim) continue;
    std::sort(truth.begin(), truth.end());
    ++tested;
    const Traced traced = trace_leaves(made.set, ray, 10.0);
    EXPECT_TRUE(traced.complete) << describe(ray);
    ASSERT_EQ(traced.roots.size(), truth.size()) << describe(ray) << " at " << distance;
    for (std::size_t i = 0; i < truth.size(); ++i)
      EXPECT_NEAR(traced.roots[i].t, truth[i], 1e-8) << describe(ray);
  }
  EXPECT_GT(tested, 1500);
}

// Weights that would turn negative in the margin: the patch stays, without the margin.
TEST(PatchCrease, AMarginThatWeightsForbidIsGivenUp) {
  std::vector<dvec4> ctrl;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      const double w = i == 0 ? 1.0 : 1e-6;  // falls by 1 over the patch: below 0 just beyond its end
      ctrl.push_back(w * dvec4(i, j, 0.0, 1.0));
    }
  FaceSpec face;
  face.surface = nurbs::make_bezier(1, 1, ctrl);
  face.uv_box.add(dvec2(0.0)), face.uv_box.add(dvec2(1.0));
  const nurbs::NurbsStore store = nurbs::make_store(std::span(&face, 1));
  const double margin = 0.5;
  const PatchSet set(store, 0, std::span(&margin, 1), 1);
  EXPECT_EQ(set.refused(), 0);
  ASSERT_GT(set.leaves().size(), 0u);
  for (const double x : {0.1, 0.5, 0.9, 0.999})
    EXPECT_EQ(trace_leaves(set, {dvec3(x, 0.4, 1.0), dvec3(0, 0, -1)}, 1.5).roots.size(), 1u) << x;
}

}  // namespace
}  // namespace trimray::trace
