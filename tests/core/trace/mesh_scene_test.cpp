// Mesh faces in a scene: closed forms, and that nothing slips through a closed mesh.
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "core/nurbs/make_store.h"
#include "core/nurbs/merge_stores.h"
#include "core/trace/extent.h"
#include "core/trace/scene.h"
#include "tests/core/nurbs/meshes.h"

namespace trimray::trace {
namespace {

using nurbs::NurbsStore;
using testing::ball_mesh;
using testing::box_mesh;
using testing::store_in_groups;
using testing::store_of;
using testing::TestMesh;

Scene scene_of(NurbsStore store) { return Scene(std::make_shared<NurbsStore>(std::move(store)), 2); }

Ray ray_at(const dvec3& target, const dvec3& org) { return {org, glm::normalize(target - org), 0.0, kInf}; }

struct Random {
  std::mt19937_64 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  double unit() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine); }
  dvec3 direction() {
    std::normal_distribution<double> normal;
    return glm::normalize(dvec3(normal(engine), normal(engine), normal(engine)));
  }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine() % n); }
};

TEST(MeshScene, TriangleGivesDepthWeightsAndNormal) {
  const TestMesh mesh{{{1, 1, 5}, {3, 1, 5}, {1, 5, 5}}, {{0, 1, 2}}};
  const Scene scene = scene_of(store_of(mesh));
  const Ray ray{{1.5, 2, 9}, {0, 0, -1}, 0.0, kInf};
  Hit hit;
  scene.cast({&ray, 1}, {&hit, 1}, 1);
  EXPECT_DOUBLE_EQ(hit.t, 4.0);
  EXPECT_EQ(hit.face, 0);
  EXPECT_EQ(hit.instance, 0);
  EXPECT_NEAR(hit.uv_face.x, 0.25, 1e-15);
  EXPECT_NEAR(hit.uv_face.y, 0.25, 1e-15);
  EXPECT_EQ(hit.normal, dvec3(0, 0, 1));
  std::vector<Hit> all;
  scene.cast_all({{1.5, 2, 1}, {0, 0, 1}, 0.0, kInf}, all);  // from below: the same normal
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].normal, dvec3(0, 0, 1));
  scene.cast_all({{1.5, 2, 1}, {0, 0, 1}, 4.5, kInf}, all);
  EXPECT_TRUE(all.empty());
  scene.cast_all({{3, 5, 1}, {0, 0, 1}, 0.0, kInf}, all);  // beyond the long side
  EXPECT_TRUE(all.empty());
  scene.cast_all({{0, 2, 5}, {1, 0, 0}, 0.0, kInf}, all);  // within the plane
  EXPECT_TRUE(all.empty());
}

TEST(MeshScene, BoxIsMetWhereASlabTestSays) {
  const dvec3 lower(-1, 2, 0.5), upper(3, 2.5, 4);
  const Scene scene = scene_of(store_in_groups(box_mesh(lower, upper, 5), 50));  // a face a side
  Random random(1);
  std::vector<Hit> hits;
  int met = 0;
  for (int i = 0; i < 5000; ++i) {
    const Ray ray =
        ray_at(dvec3(random.unit(), random.unit(), random.unit()) * 6.0 - 1.0, 12.0 * random.direction());
    double enter = -kInf, leave = kInf;
    int side = -1;
    for (int a = 0; a < 3; ++a) {
      const double p = (lower[a] - ray.org[a]) / ray.dir[a], q = (upper[a] - ray.org[a]) / ray.dir[a];
      if (std::min(p, q) > enter) enter = std::min(p, q), side = 2 * a + (q < p);
      leave = std::min(leave, std::max(p, q));
    }
    scene.cast_all(ray, hits);
    ASSERT_EQ(hits.size(), enter <= leave ? 2u : 0u) << i;
    if (hits.empty()) continue;
    ++met;
    EXPECT_NEAR(hits[0].t, enter, 1e-13);
    EXPECT_NEAR(hits[1].t, leave, 1e-13);
    EXPECT_EQ(hits[0].face, side);
    dvec3 normal(0.0);
    normal[side / 2] = side % 2 ? 1.0 : -1.0;
    EXPECT_EQ(hits[0].normal, normal);
  }
  EXPECT_GT(met, 500);
}

// Rays at corners and at points of sides, exactly as far as numbers go, and along the sides themselves.
// slivers: of triangles without area, which a ray may meet both before and behind.
void expect_watertight(const TestMesh& mesh, double size, unsigned seed, int slivers = 0) {
  const Scene scene = scene_of(store_of(mesh));
  Random random(seed);
  Box3 box;
  for (const dvec3& v : mesh.vertices) box.add(v);
  dvec3 inside(0.0);
  for (const dvec3& v : mesh.vertices) inside += v / double(mesh.vertices.size());
  std::vector<Ray> rays, out;
  for (int i = 0; i < 4000; ++i) {
    const nurbs::Triangle& t = mesh.triangles[random.below(mesh.triangles.size())];
    const dvec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]];
    const dvec3 target = i % 4 == 0 ? a : i % 4 == 1 ? 0.5 * (a + b) : a + random.unit() * (b - a);
    // Every eighth one from far away, every fifth one along an axis.
    dvec3 org = inside + size * (i % 8 == 0 ? 1e6 : 3.0) * random.direction();
    if (i % 5 == 0) {
      dvec3 axis(0.0);
      axis[i % 3] = 3.0 * size;
      org = target + axis;
    }
    rays.push_back(ray_at(i % 7 == 0 ? b : target, i % 7 == 0 ? 2.0 * a - b : org));
    if (box.contains(rays.back().org)) rays.pop_back();
    out.push_back(ray_at(target, inside));
  }
  std::vector<std::int32_t> counts(rays.size());
  scene.count_hits(rays, counts, 2);
  int met = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(counts[i] % 2, 0) << "ray " << i;
    met += counts[i] > 0;
  }
  EXPECT_GT(met, static_cast<int>(rays.size() / 2));
  std::vector<Hit> hits(rays.size());
  scene.cast(rays, hits, 2);
  for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_EQ(hits[i].face != kNoFace, counts[i] > 0) << i;
  // From within a convex solid every ray leaves once.
  counts.resize(out.size());
  scene.count_hits(out, counts, 2);
  for (std::size_t i = 0; i < out.size(); ++i) {
    ASSERT_EQ(counts[i] % 2, 1) << "ray " << i;
    ASSERT_LE(counts[i], 1 + 2 * slivers) << "ray " << i;
  }
}

TEST(MeshScene, NothingSlipsThroughABox) { expect_watertight(box_mesh({-1, -2, 0}, {1, 3, 0.5}, 7), 4, 2); }
TEST(MeshScene, NothingSlipsThroughABoxWhoseTrianglesShareNoCorners) {
  expect_watertight(box_mesh({-1, -2, 0}, {1, 3, 0.5}, 7, false), 4, 3);
}
TEST(MeshScene, NothingSlipsThroughABall) { expect_watertight(ball_mesh({10, 20, -5}, 3.0, 5), 3, 4); }
TEST(MeshScene, NothingSlipsThroughATinyBallFarOut) {
  expect_watertight(ball_mesh({1e4, -2e4, 5e3}, 1e-6, 3), 1e-6, 5);
}
TEST(MeshScene, NothingSlipsThroughATetrahedron) { expect_watertight(testing::tetrahedron(), 1.0, 6); }

TEST(MeshScene, TrianglesWithoutAreaAreNoHoles) {
  TestMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1}, 2);
  // Cut a side's triangle at a point on its longest side, and close the slit with a triangle of no area.
  const nurbs::Triangle t = mesh.triangles.back();
  const auto m = static_cast<std::int32_t>(mesh.vertices.size());
  mesh.vertices.push_back(0.5 * (mesh.vertices[t[0]] + mesh.vertices[t[1]]));
  mesh.triangles.back() = {t[0], m, t[2]};
  mesh.triangles.push_back({m, t[1], t[2]});
  mesh.triangles.push_back({t[0], t[1], m});
  ASSERT_TRUE(nurbs::closes_up(mesh.vertices, mesh.triangles));
  expect_watertight(mesh, 1.0, 7, 1);
}

TEST(MeshScene, AnswersDoNotDependOnThreadsOrderOrGrouping) {
  // Twice the same ball: equal t everywhere, and silhouettes where two triangles are met at one point.
  TestMesh mesh = ball_mesh({0, 0, 0}, 2.0, 3);
  const std::size_t count = mesh.triangles.size();
  for (std::size_t i = 0; i < count; ++i) mesh.triangles.push_back(mesh.triangles[i]);
  const Scene scene = scene_of(store_of(mesh));
  Random random(8);
  std::vector<Ray> rays;
  for (int i = 0; i < 3000; ++i) {
    const dvec3 target = i % 2 ? mesh.vertices[random.below(mesh.vertices.size())] : 2.0 * random.direction();
    rays.push_back(ray_at(target, 7.0 * random.direction()));
  }
  std::vector<Hit> one(rays.size()), four(rays.size()), all;
  scene.cast(rays, one, 1);
  scene.cast(rays, four, 4);
  ASSERT_EQ(std::memcmp(one.data(), four.data(), one.size() * sizeof(Hit)), 0);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Hit alone;
    scene.cast({&rays[i], 1}, {&alone, 1}, 1);
    ASSERT_EQ(std::memcmp(&alone, &one[i], sizeof(Hit)), 0) << "ray " << i;
    scene.cast_all(rays[i], all);
    ASSERT_EQ(all.empty(), one[i].face == kNoFace) << "ray " << i;
    ASSERT_EQ(all.size() % 4, 0u) << "ray " << i;
    if (all.empty()) continue;
    ASSERT_EQ(std::memcmp(&all[0], &one[i], sizeof(Hit)), 0) << "ray " << i;
  }
  std::shuffle(rays.begin(), rays.end(), random.engine);
  const Scene serial(std::make_shared<NurbsStore>(scene.store()), 1);
  scene.cast(rays, one, 2);
  serial.cast(rays, four, 2);
  EXPECT_EQ(std::memcmp(one.data(), four.data(), one.size() * sizeof(Hit)), 0);
}

TEST(MeshScene, AnswersDoNotDependOnTheMachine) {
  const TestMesh mesh = ball_mesh({1, 2, 3}, 2.0, 4);
  const Scene scene = scene_of(store_of(mesh));
  Random random(12);
  std::vector<Ray> rays;
  for (int i = 0; i < 5000; ++i) {
    const dvec3 corner = mesh.vertices[random.below(mesh.vertices.size())];
    rays.push_back(ray_at(i % 2 ? corner : corner + 0.5 * random.direction(), 9.0 * random.direction()));
  }
  std::vector<Hit> best(rays.size()), other(rays.size());
  scene.cast(rays, best, 1);
  EXPECT_GT(std::count_if(best.begin(), best.end(), [](const Hit& h) { return h.face != kNoFace; }), 3000);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    scene.cast(rays, other, 1);
    EXPECT_EQ(std::memcmp(best.data(), other.data(), best.size() * sizeof(Hit)), 0)
        << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(MeshScene, InstancesMirrorAndStretch) {
  NurbsStore store = store_of(ball_mesh({0, 0, 0}, 1.0, 4));
  store.instances[0].placement = {dmat3(dvec3(-2, 0, 0), dvec3(0, 3, 0), dvec3(0, 0, 0.5)), {10, 0, 0}};
  const Scene scene = scene_of(store);
  Random random(9);
  std::vector<Hit> all;
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    const Ray ray = ray_at(dvec3(10, 0, 0) + dvec3(2, 3, 0.5) * random.direction() * random.unit(),
                           dvec3(10, 0, 0) + 20.0 * random.direction());
    scene.cast_all(ray, all);
    ASSERT_EQ(all.size(), 2u) << i;
    EXPECT_LT(glm::dot(all[0].normal, ray.dir), 0.0);
    EXPECT_GT(glm::dot(all[1].normal, ray.dir), 0.0);
    const dvec3 p = (ray.org + all[0].t * ray.dir - dvec3(10, 0, 0)) / dvec3(2, 3, 0.5);
    EXPECT_NEAR(glm::length(p), 1.0, 5e-3);  // the chord of 1024 triangles
    const dvec3 n = glm::normalize(p / dvec3(2, 3, 0.5));
    met += glm::dot(n, all[0].normal) > 0.98;
  }
  EXPECT_GT(met, 1900);
}

// A mesh in front of, inside and behind exact surfaces, in one merged scene.
TEST(MeshScene, MixesWithExactSurfaces) {
  const nurbs::FaceSpec sphere = nurbs::full_sphere({}, 2.0);
  const NurbsStore exact = nurbs::make_store({&sphere, 1}), inner = store_of(ball_mesh({}, 1.0, 4)),
                   outer = store_of(box_mesh(dvec3(-3), dvec3(3), 4));
  const NurbsStore* const parts[] = {&exact, &inner, &outer};
  const Scene scene = scene_of(nurbs::merge_stores(parts, "{}"));
  Random random(10);
  std::vector<Hit> all;
  int through = 0;
  for (int i = 0; i < 3000; ++i) {
    const Ray ray = ray_at(2.2 * random.unit() * random.direction(), 9.0 * random.direction());
    scene.cast_all(ray, all);
    const double miss = glm::length(glm::cross(ray.org, ray.dir));
    if (std::abs(miss - 2.0) < 1e-6 || std::abs(miss - 1.0) < 0.01) continue;
    const std::vector<std::int32_t> expected = miss < 1.0   ? std::vector<std::int32_t>{2, 0, 1, 1, 0, 2}
                                               : miss < 2.0 ? std::vector<std::int32_t>{2, 0, 0, 2}
                                                            : std::vector<std::int32_t>{2, 2};
    ASSERT_EQ(all.size(), expected.size()) << i;
    for (std::size_t k = 0; k < all.size(); ++k) {
      EXPECT_EQ(all[k].face, expected[k]);
      EXPECT_EQ(all[k].instance, expected[k]);
    }
    EXPECT_FALSE(scene.near_edge({ray.org, ray.dir, 0.0, all[0].t}));
    through += miss < 1.0;
  }
  EXPECT_GT(through, 500);
}

TEST(MeshScene, ExtentIsExact) {
  NurbsStore store = store_of(ball_mesh({1, 2, 3}, 4.0, 6));
  store.instances.push_back(store.instances[0]);
  store.instances[1].placement = {dmat3(dvec3(0, 1, 0), dvec3(-2, 0, 0), dvec3(0.3, 0, 1)), {50, 0, 0}};
  Box3 box;
  for (const nurbs::Instance& n : store.instances)
    for (const dvec3& v : store.mesh_vertices) box.add(n.placement.point(v));
  const Extent extent = model_extent(store, 2);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(extent.bounds.lower[a], box.lower[a], 1e-13);
    EXPECT_NEAR(extent.bounds.upper[a], box.upper[a], 1e-13);
  }
  // The points reach about as far as the model in any direction.
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    const dvec3 d = random.direction();
    double model = -kInf, points = -kInf;
    for (const nurbs::Instance& n : store.instances)
      for (const dvec3& v : store.mesh_vertices) model = std::max(model, glm::dot(d, n.placement.point(v)));
    for (const dvec3& p : extent.points) points = std::max(points, glm::dot(d, p));
    EXPECT_LE(points, model + 1e-12);
    EXPECT_GE(points, model - 0.01 * box.diagonal());
  }
}

}  // namespace
}  // namespace trimray::trace
