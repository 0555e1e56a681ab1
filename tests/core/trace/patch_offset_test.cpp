// Offset surfaces against closed forms: the offset of a sphere is a sphere, that of a torus a torus.
#include <gtest/gtest.h>

#include "core/trace/patch_offset.h"
#include "tests/core/trace/patch_rays.h"

namespace trimray::trace {
namespace {

using nurbs::FaceSpec;
using nurbs::Frame3;

const Frame3 kFrame{dvec3(3, -2, 5), glm::normalize(dvec3(1, 2, 0.5)), glm::normalize(dvec3(-0.3, 0.2, 1))};

FaceSpec offset_of(FaceSpec face, double offset) {
  face.surface = nurbs::as_offset(nurbs::as_nurbs(face.surface), offset);
  return face;
}

std::vector<double> sphere_roots(const Ray& ray, const dvec3& center, double radius) {
  const dvec3 q = ray.org - center;
  const double b = glm::dot(q, ray.dir);
  const double miss = glm::length(q - b * ray.dir), disc = (radius - miss) * (radius + miss);
  if (disc <= 0.0) return {};
  return {-b - std::sqrt(disc), -b + std::sqrt(disc)};
}

TEST(PatchOffset, SpheresGrowAndShrink) {
  for (const double offset : {1.5, -2.0}) {
    const Made made(offset_of(nurbs::full_sphere(kFrame, 5.0), offset));
    std::mt19937 rng(6);
    int open = 0, given_up = 0;
    constexpr int kRays = 700;
    for (int k = 0; k < kRays; ++k) {
      const double radius = 5.0 + offset;
      const Ray ray = random_ray(rng, kFrame.location, 1.05 * radius, radius);
      const Traced found = trace_leaves(made.set, ray, 2.0 * radius);
      open += found.open;
      EXPECT_EQ(found.one, 0);
      if (!found.complete) {
        ++given_up;
        continue;
      }
      const std::vector<double> truth = sphere_roots(ray, kFrame.location, radius);
      ASSERT_EQ(found.roots.size(), truth.size()) << describe(ray);
      for (std::size_t i = 0; i < truth.size(); ++i)
        EXPECT_NEAR(found.roots[i].t, truth[i], 1e-9) << describe(ray);
    }
    EXPECT_LT(open, 40 * kRays);
    EXPECT_EQ(given_up, 0);
  }
}

TEST(PatchOffset, OpenLanesGiveTheRootsOfTheScalarSearch) {
  const Made made(offset_of(nurbs::full_sphere(kFrame, 5.0), 1.5));
  std::mt19937 rng(8);
  RayLanes lanes = {};
  Ray rays[kLanes];
  for (int i = 0; i < kLanes; ++i) {
    const Ray& r = rays[i] = random_ray(rng, kFrame.location, 6.0, 6.5);
    lanes.org_x[i] = r.org.x, lanes.org_y[i] = r.org.y, lanes.org_z[i] = r.org.z;
    lanes.dir_x[i] = r.dir.x, lanes.dir_y[i] = r.dir.y, lanes.dir_z[i] = r.dir.z;
  }
  lanes.active = 0xb5;
  int roots = 0;
  for (std::size_t k = 0; k < made.set.leaves().size(); ++k) {
    const auto leaf = static_cast<std::int32_t>(k);
    std::vector<LaneRoot> found;
    std::vector<Root> want;
    EXPECT_EQ(made.set.open_roots(leaf, lanes, found), 5);
    std::size_t next = 0;
    for (int i = 0; i < kLanes; ++i) {
      want.clear();
      if (lanes.active >> i & 1u) made.set.all_roots(leaf, rays[i], want);
      for (const Root& r : want) {
        ASSERT_LT(next, found.size());
        EXPECT_EQ(found[next].lane, i);
        EXPECT_EQ(found[next].root.t, r.t);
        EXPECT_EQ(found[next++].root.uv_face, r.uv_face);
        ++roots;
      }
    }
    EXPECT_EQ(next, found.size());
  }
  EXPECT_GE(roots, 8);
}

TEST(PatchOffset, RaysNearAPoleMeetItOnce) {
  const Made made(offset_of(nurbs::full_sphere(kFrame, 5.0), 1.5));
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 100; ++k) {
    const dvec3 pole = kFrame.location + (k % 2 ? 6.5 : -6.5) * kFrame.z_axis;
    const dvec3 d = glm::normalize(dvec3(normal(rng), normal(rng), normal(rng)));
    if (std::fabs(glm::dot(d, glm::normalize(kFrame.z_axis))) < 0.1) continue;
    const dvec3 aside = std::pow(10.0, -1.0 - k % 3) * dvec3(normal(rng), normal(rng), normal(rng));
    const Ray ray{pole + aside - 20.0 * d, d};
    const Traced found = trace_leaves(made.set, ray, 13.0);
    const std::vector<double> truth = sphere_roots(ray, kFrame.location, 6.5);
    // Nearer to the pole's point a search may be given up (kMaxOffsetBoxes), but says so.
    if (!found.complete && glm::length(glm::cross(aside, d)) < 1e-3 * 1.5) continue;
    EXPECT_TRUE(found.complete) << describe(ray);
    ASSERT_EQ(found.roots.size(), truth.size()) << describe(ray);
    for (std::size_t i = 0; i < truth.size(); ++i)
      EXPECT_NEAR(found.roots[i].t, truth[i], 1e-9) << describe(ray);
  }
}

TEST(PatchOffset, ToriLieWhereTheirTubeGrows) {
  const Made made(offset_of(nurbs::full_torus(kFrame, 5.0, 2.0), -0.7));
  const dvec3 x = glm::normalize(kFrame.x_axis - glm::dot(kFrame.x_axis, kFrame.z_axis) * kFrame.z_axis);
  const dvec3 y = glm::cross(kFrame.z_axis, x);
  std::mt19937 rng(8);
  for (int k = 0; k < 400; ++k) {
    const Ray ray = random_ray(rng, kFrame.location, 6.5, 6.3);
    const auto implicit = [&](double t) {
      const dvec3 p = ray.org + t * ray.dir - kFrame.location;
      return std::hypot(std::hypot(glm::dot(p, x), glm::dot(p, y)) - 5.0, glm::dot(p, kFrame.z_axis)) - 1.3;
    };
    const Traced found = trace_leaves(made.set, ray, 13.0);
    EXPECT_TRUE(found.complete) << describe(ray);
    ASSERT_EQ(found.roots.size() % 2, 0u) << describe(ray);
    for (const Root& r : found.roots) EXPECT_LT(std::fabs(implicit(r.t)), 1e-11) << describe(ray);
    std::size_t changes = 0;
    for (int i = 0; i < 3000; ++i)
      changes += (implicit(40.0 * i / 3000) > 0.0) != (implicit(40.0 * (i + 1) / 3000) > 0.0);
    EXPECT_GE(found.roots.size(), changes) << describe(ray);
  }
}

// The enclosures hold what they say, at random points of random boxes.
TEST(PatchOffset, EnclosuresHoldTheSurface) {
  std::mt19937 rng(9);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<dvec4> points;
  for (int i = 0; i < 20; ++i) {
    const double w = 0.5 + uniform(rng);
    points.push_back(
        dvec4(w * dvec3(i / 5 + 0.5 * uniform(rng), i % 5 + 0.5 * uniform(rng), uniform(rng)), w));
  }
  Patch patch;
  patch.degree_u = 3, patch.degree_v = 4, patch.offset = 0.4, patch.size = 8.0;
  int regular = 0;
  for (int k = 0; k < 300; ++k) {
    const double size = std::pow(2.0, -8.0 * uniform(rng)), u0 = (1.0 - size) * uniform(rng),
                 v0 = (1.0 - size) * uniform(rng);
    const OffsetBox box = enclose_offset(patch, points.data(), {u0, u0 + size, v0, v0 + size});
    if (!box.regular) continue;
    ++regular;
    const auto holds = [](const Interval3& i, const dvec3& p) {
      return i.x.lo <= p.x && p.x <= i.x.hi && i.y.lo <= p.y && p.y <= i.y.hi && i.z.lo <= p.z &&
             p.z <= i.z.hi;
    };
    for (int n = 0; n < 10; ++n) {
      const OffsetJet jet =
          offset_jet(patch, points.data(), u0 + size * uniform(rng), v0 + size * uniform(rng));
      EXPECT_TRUE(holds(box.normal, box.frame * jet.normal));
      EXPECT_TRUE(holds(box.px, box.frame * (size * jet.pu)));
      EXPECT_TRUE(holds(box.py, box.frame * (size * jet.pv)));
      EXPECT_TRUE(holds(box.base + patch.offset * box.normal, box.frame * (jet.p - box.center)));
    }
  }
  EXPECT_GT(regular, 100);
}

}  // namespace
}  // namespace trimray::trace
