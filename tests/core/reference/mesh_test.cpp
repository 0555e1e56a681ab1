// The fast tracer and the reference say the same about triangles.
#include <gtest/gtest.h>

#include <memory>

#include "core/nurbs/make_store.h"
#include "core/nurbs/merge_stores.h"
#include "tests/core/nurbs/meshes.h"
#include "tests/core/reference/agreement.h"

namespace trimray::reference_test {
namespace {

using nurbs::NurbsStore;
using trace::Hit;
using trace::Ray;

// Rays that pass a triangle's side closer than rounding, where either triangle may be the one: the two
// tracers agree on parity, and on the depth of what both see.
void expect_agreement(const NurbsStore& store, int count, unsigned seed) {
  const auto shared = std::make_shared<const NurbsStore>(store);
  const trace::Scene scene(shared);
  const reference::Model model(*shared, nullptr, 0);
  RayMaker maker(store, seed);
  int differ = 0, hits = 0;
  for (int k = 0; k < count; ++k) {
    const Ray ray = k % 2 ? maker.random() : maker.at_silhouette();
    std::vector<Hit> fast;
    scene.cast_all(ray, fast);
    const std::vector<Hit> slow = model.hits(ray);
    ASSERT_EQ(fast.size() % 2, 0u) << "ray " << k;
    ASSERT_EQ(slow.size() % 2, 0u) << "ray " << k;
    const std::string text = difference(fast, slow, maker.diagonal);
    if (k % 2) {
      ASSERT_TRUE(text.empty()) << "ray " << k << "\n" << text;
      for (std::size_t i = 0; i < fast.size(); ++i) {
        EXPECT_NEAR(fast[i].uv_face.x, slow[i].uv_face.x, 1e-7) << "ray " << k;
        EXPECT_NEAR(fast[i].uv_face.y, slow[i].uv_face.y, 1e-7) << "ray " << k;
        EXPECT_GT(glm::dot(fast[i].normal, slow[i].normal), 1.0 - 1e-12) << "ray " << k;
      }
    } else {
      differ += !text.empty();
    }
    hits += !slow.empty();
  }
  EXPECT_GT(hits, count / 4);
  EXPECT_LE(differ, count / 50);
}

TEST(MeshAgreement, holdsOnABall) {
  expect_agreement(testing::store_of(testing::ball_mesh({}, 2, 3)), 1200, 1);
}

TEST(MeshAgreement, holdsOnMirroredAndStretchedInstances) {
  NurbsStore store = testing::store_in_groups(testing::ball_mesh({1, 0, 0}, 2.0, 2), 256);
  store.instances.push_back(store.instances[0]);
  store.instances[1].placement = {dmat3(dvec3(-1, 0, 0), dvec3(0.2, 3, 0), dvec3(0, 0.5, 0.7)), {9, 1, 0}};
  expect_agreement(store, 1200, 2);
}

TEST(MeshAgreement, holdsBesideExactSurfaces) {
  const nurbs::FaceSpec spec = nurbs::full_sphere({{5, 0, 0}}, 1.5);
  const NurbsStore sphere = nurbs::make_store({&spec, 1}),
                   mesh = testing::store_of(testing::ball_mesh({}, 2.0, 3));
  const NurbsStore* const parts[] = {&sphere, &mesh};
  const NurbsStore store = nurbs::merge_stores(parts, "{}");
  const auto shared = std::make_shared<const NurbsStore>(store);
  const trace::Scene scene(shared);
  const reference::Model model(*shared, nullptr, 0);
  RayMaker maker(store, 3);
  int both = 0;
  for (int k = 0; k < 400; ++k) {
    const Ray ray =
        maker.through(dvec3(5.0 * maker.unit(), 0, 0) + 0.4 * maker.direction(), maker.direction());
    std::vector<Hit> fast;
    scene.cast_all(ray, fast);
    const std::string text = difference(fast, model.hits(ray), maker.diagonal);
    ASSERT_TRUE(text.empty()) << "ray " << k << "\n" << text;
    both += fast.size() == 4;
  }
  EXPECT_GT(both, 20);
}

// At corners and on sides the reference, too, counts evenly and misses nothing.
TEST(MeshAgreement, referenceIsWatertight) {
  const testing::TestMesh mesh = testing::box_mesh({-1, -2, 0}, {1, 3, 0.5}, 3);
  const NurbsStore store = testing::store_of(mesh);
  const reference::Model model(store, nullptr, 0);
  RayMaker maker(store, 4);
  for (int k = 0; k < 2000; ++k) {
    const nurbs::Triangle& t = mesh.triangles[maker.engine() % mesh.triangles.size()];
    const dvec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]];
    const dvec3 target = k % 3 == 0 ? a : k % 3 == 1 ? 0.5 * (a + b) : a + maker.unit() * (b - a);
    const dvec3 inside(0.1, 0.2, 0.3);
    EXPECT_EQ(model.hits({inside, glm::normalize(target - inside), 0.0, kInf}).size(), 1u) << "ray " << k;
    EXPECT_EQ(model.hits(maker.through(target, maker.direction())).size() % 2, 0u) << "ray " << k;
  }
}

}  // namespace
}  // namespace trimray::reference_test
