// The patch kernel against closed forms: spheres, tori, cylinders and cones given as rational NURBS.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/nurbs/make_store.h"
#include "core/trace/patch.h"

namespace trimray::trace {
namespace {

using nurbs::FaceSpec;
using nurbs::Frame3;

struct Tally {
  int rays = 0, roots = 0, wrong_count = 0, wrong_t = 0, open_lanes = 0, lanes = 0, wrong_one = 0, wrong_none = 0;
  double worst_t = 0.0;
};

// All roots of all leaves, deduplicated, sorted.
std::vector<Root> every_root(const PatchSet& set, const Ray& ray, double scale) {
  std::vector<Root> roots;
  for (std::size_t k = 0; k < set.leaves().size(); ++k) set.all_roots(static_cast<std::int32_t>(k), ray, roots);
  std::sort(roots.begin(), roots.end(), [](const Root& a, const Root& b) { return a.t < b.t; });
  std::vector<Root> unique;
  for (const Root& r : roots) {
    const bool known = std::any_of(unique.begin(), unique.end(),
                                   [&](const Root& other) { return same_root(r, other, scale); });
    if (!known) unique.push_back(r);
  }
  return unique;
}

// Both roots of a sphere; none where the ray passes within rounding of its rim.
std::vector<double> sphere_roots(const Ray& ray, const dvec3& center, double radius) {
  const dvec3 q = ray.org - center;
  const double b = glm::dot(q, ray.dir);
  const dvec3 p = q - b * ray.dir;
  const double disc = (radius - glm::length(p)) * (radius + glm::length(p));
  if (disc <= 0.0) return {};
  return {-b - std::sqrt(disc), -b + std::sqrt(disc)};
}

void check_ray(const PatchSet& set, const Ray& ray, const std::vector<double>& truth, double scale, Tally& tally) {
  const std::vector<Root> roots = every_root(set, ray, scale);
  ++tally.rays;
  tally.roots += static_cast<int>(roots.size());
  if (roots.size() != truth.size()) {
    ++tally.wrong_count;
    return;
  }
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double error = std::fabs(roots[k].t - truth[k]) / scale;
    tally.worst_t = std::max(tally.worst_t, error);
    EXPECT_EQ(roots[k].sign, k % 2 == 0 ? -1 : 1);
  }
}

// Random lines whose distance from a centre is spread over [0, reach], a share of it close to `near`.
Ray random_ray(std::mt19937& rng, const dvec3& center, double reach, double near) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const dvec3 d = glm::normalize(dvec3(normal(rng), normal(rng), normal(rng)));
  const dvec3 side = glm::normalize(glm::cross(d, dvec3(normal(rng), normal(rng), normal(rng))));
  double distance = reach * uniform(rng);
  if (uniform(rng) < 0.3) distance = near * (1.0 - std::pow(10.0, -1.0 - 6.0 * uniform(rng)));
  Ray ray;
  ray.dir = d;
  ray.org = center + side * distance - 3.0 * reach * d;
  return ray;
}

TEST(PatchKernel, SphereAsNurbsHasExactlyTheClosedFormsRoots) {
  const Frame3 frame{dvec3(3, -2, 5), glm::normalize(dvec3(1, 2, 0.5)), glm::normalize(dvec3(-0.3, 0.2, 1))};
  FaceSpec face = nurbs::full_sphere(frame, 7.0);
  face.surface = nurbs::as_nurbs(face.surface);
  const auto store = nurbs::make_store(std::span(&face, 1));
  const double margin = 1e-3;
  const PatchSet set(store, 0, std::span(&margin, 1));
  ASSERT_GT(set.leaves().size(), 8u);
  std::mt19937 rng(1);
  Tally tally;
  for (int k = 0; k < 20000; ++k) {
    const Ray ray = random_ray(rng, frame.location, 8.0, 7.0);
    check_ray(set, ray, sphere_roots(ray, frame.location, 7.0), 14.0, tally);
  }
  EXPECT_EQ(tally.wrong_count, 0);
  EXPECT_LT(tally.worst_t, 1e-12);
  std::printf("sphere: %zu leaves, %d rays, worst |dt| %.3g of the diameter\n", set.leaves().size(), tally.rays,
              tally.worst_t);
}

}  // namespace
}  // namespace trimray::trace
