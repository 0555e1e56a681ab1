// The patch kernel against closed forms: quadrics and tori given as rational NURBS, and offsets of them.
#include <gtest/gtest.h>

#include "tests/core/trace/patch_rays.h"

namespace trimray::trace {
namespace {

using nurbs::FaceSpec;
using nurbs::Frame3;

const Frame3 kFrame{dvec3(3, -2, 5), glm::normalize(dvec3(1, 2, 0.5)), glm::normalize(dvec3(-0.3, 0.2, 1))};

// Both roots of a sphere; none where the ray passes beside it.
std::vector<double> sphere_roots(const Ray& ray, const dvec3& center, double radius) {
  const dvec3 q = ray.org - center;
  const double b = glm::dot(q, ray.dir);
  const dvec3 p = q - b * ray.dir;
  const double disc = (radius - glm::length(p)) * (radius + glm::length(p));
  if (disc <= 0.0) return {};
  return {-b - std::sqrt(disc), -b + std::sqrt(disc)};
}

void check_ray(const PatchSet& set, const Ray& ray, const std::vector<double>& truth, double scale,
               double& worst) {
  const Traced traced = trace_leaves(set, ray, scale);
  const std::vector<Root>& roots = traced.roots;
  EXPECT_TRUE(traced.complete);
  ASSERT_EQ(every_root(set, ray, scale).size(), truth.size()) << describe(ray);
  ASSERT_EQ(roots.size(), truth.size()) << describe(ray);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    worst = std::max(worst, std::fabs(roots[k].t - truth[k]) / scale);
    EXPECT_EQ(roots[k].sign, k % 2 == 0 ? -1 : 1) << describe(ray);
  }
}

FaceSpec nurbs_sphere(const Frame3& frame, double radius) {
  FaceSpec face = nurbs::full_sphere(frame, radius);
  face.surface = nurbs::as_nurbs(face.surface);
  return face;
}

TEST(PatchClosedForm, SphereHasExactlyItsTwoRoots) {
  const Made made(nurbs_sphere(kFrame, 7.0));
  std::mt19937 rng(1);
  double worst = 0.0;
  for (int k = 0; k < 6000; ++k) {
    // A third of the rays graze: 0.1 down to 1e-7 of the radius inside the rim.
    const Ray ray = random_ray(rng, kFrame.location, 8.0, 7.0);
    check_ray(made.set, ray, sphere_roots(ray, kFrame.location, 7.0), 14.0, worst);
  }
  // Rounding of the distance from the rim, e, moves the root of a grazing ray by e / (1e-7)^(1/2).
  EXPECT_LT(worst, 1e-12);
}

TEST(PatchClosedForm, RaysThroughPolesMeetThemOnce) {
  const Made made(nurbs_sphere(kFrame, 7.0));
  std::mt19937 rng(2);
  std::normal_distribution<double> normal;
  double worst = 0.0;
  for (int k = 0; k < 600; ++k) {
    const dvec3 pole = kFrame.location + (k % 2 ? 7.0 : -7.0) * kFrame.z_axis;
    // Exactly at the pole, then ever nearer misses of it.
    const double miss = k % 5 == 0 ? 0.0 : std::pow(10.0, -3.0 - k % 11);
    const dvec3 d = glm::normalize(dvec3(normal(rng), normal(rng), normal(rng)));
    const dvec3 aside(normal(rng), normal(rng), normal(rng));
    const Ray ray{pole + miss * aside - 20.0 * d, d};
    if (std::fabs(glm::dot(d, kFrame.z_axis)) < 1e-3) continue;
    check_ray(made.set, ray, sphere_roots(ray, kFrame.location, 7.0), 14.0, worst);
  }
  EXPECT_LT(worst, 1e-12);
}

TEST(PatchClosedForm, FarFromTheOriginTheErrorIsThatOfTheCoordinates) {
  Frame3 far = kFrame;
  far.location = dvec3(1e5, -1e5, 1e5);
  const Made made(nurbs_sphere(far, 7.0));
  std::mt19937 rng(3);
  double worst = 0.0;
  for (int k = 0; k < 1500; ++k) {
    const Ray ray = random_ray(rng, far.location, 6.9, 6.9);
    check_ray(made.set, ray, sphere_roots(ray, far.location, 7.0), 14.0, worst);
  }
  EXPECT_LT(worst, 1e-9);
}

TEST(PatchClosedForm, CylinderHasExactlyItsRoots) {
  FaceSpec face = nurbs::tube(kFrame, 3.0, -10.0, 10.0);
  face.surface = nurbs::as_nurbs(face.surface);
  const Made made(face);
  std::mt19937 rng(4);
  double worst = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const Ray ray = random_ray(rng, kFrame.location, 4.0, 3.0);
    const dvec3 q = ray.org - kFrame.location;
    const dvec3 d = ray.dir - glm::dot(ray.dir, kFrame.z_axis) * kFrame.z_axis;
    const dvec3 p = q - glm::dot(q, kFrame.z_axis) * kFrame.z_axis;
    const double dd = glm::dot(d, d), b = glm::dot(p, d) / dd;
    const dvec3 nearest = p - b * d;
    const double disc = (3.0 - glm::length(nearest)) * (3.0 + glm::length(nearest)) / dd;
    std::vector<double> truth;
    bool at_rim = false;
    if (disc > 0.0)
      for (double t : {-b - std::sqrt(disc), -b + std::sqrt(disc)}) {
        const double z = glm::dot(ray.org + t * ray.dir - kFrame.location, kFrame.z_axis);
        at_rim =
            at_rim || std::fabs(std::fabs(z) - 10.0) < 0.01;  // beyond its ends the tube goes on a little
        if (std::fabs(z) < 10.0) truth.push_back(t);
      }
    if (at_rim || truth.size() == 1) continue;
    check_ray(made.set, ray, truth, 20.0, worst);
  }
  EXPECT_LT(worst, 1e-12);
}

TEST(PatchClosedForm, TorusRootsLieOnItInEvenNumbersAndAgreeWithTheQuartic) {
  FaceSpec face = nurbs::full_torus(kFrame, 5.0, 2.0);
  face.surface = nurbs::as_nurbs(face.surface);
  const Made made(face);
  std::mt19937 rng(5);
  const dvec3 x = glm::normalize(kFrame.x_axis - glm::dot(kFrame.x_axis, kFrame.z_axis) * kFrame.z_axis);
  const dvec3 y = glm::cross(kFrame.z_axis, x);
  for (int k = 0; k < 2000; ++k) {
    const Ray ray = random_ray(rng, kFrame.location, 7.5, 3.0);
    const auto implicit = [&](double t) {
      const dvec3 p = ray.org + t * ray.dir - kFrame.location;
      const double ring = std::hypot(glm::dot(p, x), glm::dot(p, y)) - 5.0;
      return std::hypot(ring, glm::dot(p, kFrame.z_axis)) - 2.0;
    };
    const std::vector<Root> roots = every_root(made.set, ray, 14.0);
    ASSERT_EQ(roots.size() % 2, 0u) << describe(ray);
    for (const Root& r : roots) EXPECT_LT(std::fabs(implicit(r.t)), 1e-12) << describe(ray);
    // Sign changes on a fine grid can only miss pairs of roots.
    std::size_t changes = 0;
    constexpr int kGrid = 4000;
    for (int i = 0; i < kGrid; ++i)
      changes += (implicit(45.0 * i / kGrid) > 0.0) != (implicit(45.0 * (i + 1) / kGrid) > 0.0);
    EXPECT_GE(roots.size(), changes) << describe(ray);
    for (std::size_t i = 0; i < roots.size(); ++i)
      EXPECT_EQ(roots[i].sign, i % 2 == 0 ? -1 : 1) << describe(ray);
  }
}

TEST(PatchClosedForm, OffsetOfASphereIsASphere) {
  FaceSpec face = nurbs_sphere(kFrame, 5.0);
  face.surface = nurbs::as_offset(face.surface, 1.5);
  const Made made(face);
  ASSERT_GT(made.set.leaves().size(), 0u);
  std::mt19937 rng(6);
  double worst = 0.0;
  for (int k = 0; k < 60; ++k) {
    Ray ray = random_ray(rng, kFrame.location, 6.3, 6.0);
    if (glm::length(glm::cross(ray.org + 30.0 * ray.dir - kFrame.location, kFrame.z_axis)) < 0.2) continue;
    check_ray(made.set, ray, sphere_roots(ray, kFrame.location, 6.5), 13.0, worst);
  }
  EXPECT_LT(worst, 1e-11);
}

}  // namespace
}  // namespace trimray::trace
