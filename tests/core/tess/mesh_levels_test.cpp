#include "core/tess/mesh_levels.h"

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/closest.h"
#include "core/base/error.h"
#include "core/nurbs/make_store.h"
#include "core/tess/mesh_check.h"

namespace trimray::tess {
namespace {

using view::Camera;

// Unit spheres in their own coordinates, at the given places.
std::shared_ptr<nurbs::NurbsStore> spheres(const std::vector<Transform>& placements) {
  const nurbs::FaceSpec spec = nurbs::full_sphere({}, 1.0);
  auto store = std::make_shared<nurbs::NurbsStore>(nurbs::make_store(std::span(&spec, 1)));
  store->instances.clear();
  for (const Transform& t : placements) {
    store->instances.emplace_back().prototype = 0;
    store->instances.back().placement = t;
  }
  return store;
}

Transform at(const dvec3& place, double scale = 1.0) { return {dmat3(scale), place}; }

// Looks along +y from (0, -eye, 0).
Camera front(double pixel, bool perspective = false, double eye = 100.0) {
  Camera c = view::look(0.0, 0.0, view::UpAxis::kZ);
  c.eye = {0, -eye, 0};
  c.pixel = pixel, c.perspective = perspective;
  c.width_px = 400, c.height_px = 300;
  return c;
}

TEST(MeshLevels, InstancesOfOneSizeShareAMesh) {
  MeshLevels levels(spheres({at({-1.0, 0, 0}), at({1.0, 0, 0}, 0.75), at({0, 30, 0}), at({0, 0, 50})}));
  const ViewMeshes found = levels.meshes(front(0.02), 0.3);
  ASSERT_EQ(found.instances.size(), 3u) << "the last one is above the picture";
  EXPECT_EQ(found.instances[0].mesh, found.instances[2].mesh);
  EXPECT_EQ(found.built, 1) << "the small one is served by a level finer than it must be";
  EXPECT_EQ(found.instances[0].mesh, found.instances[1].mesh);
  EXPECT_FALSE(found.instances[0].cut);
  EXPECT_EQ(found.triangles, 3 * found.instances[0].mesh->mesh.triangles.size());
  EXPECT_LE(found.instances[0].tolerance, 0.3 * 0.02 * (1.0 + 1e-9));
  EXPECT_GT(found.instances[0].tolerance, 0.3 * 0.02 / 1.42);
  for (const double d : found.instances[0].mesh->mesh.deviation) EXPECT_LE(d, found.instances[0].tolerance);
}

TEST(MeshLevels, TheFarOneIsCoarser) {
  MeshLevels levels(spheres({at({-3, 0, 0}), at({3, 900, 0})}));
  const ViewMeshes found = levels.meshes(front(0.001, true), 0.3);
  ASSERT_EQ(found.instances.size(), 2u);
  EXPECT_EQ(found.built, 2);
  EXPECT_GT(found.instances[1].tolerance, 6.0 * found.instances[0].tolerance);
  EXPECT_LT(4 * found.instances[1].mesh->mesh.triangles.size(),
            found.instances[0].mesh->mesh.triangles.size());
}

TEST(MeshLevels, ALevelServesUntilTheViewNeedsAFinerOne) {
  MeshLevels levels(spheres({at({0, 0, 0})}));
  const auto counts = [&](double pixel) {
    const ViewMeshes found = levels.meshes(front(pixel), 0.25);
    return std::pair{found.built, found.reused};
  };
  using Pair = std::pair<int, int>;
  EXPECT_EQ(counts(1.0 / 64), Pair(1, 0));  // 2^-8 mm
  EXPECT_EQ(counts(1.0 / 64), Pair(0, 1));
  EXPECT_EQ(counts(1.9 / 64), Pair(0, 1)) << "finer than it must be, but not by much";
  EXPECT_EQ(counts(2.1 / 64), Pair(1, 0));
  EXPECT_EQ(counts(0.9 / 64), Pair(1, 0));
  EXPECT_EQ(counts(0.75 / 64), Pair(0, 1));
  EXPECT_EQ(counts(1.0 / 64), Pair(0, 1)) << "kept";
}

// Every point of the surface that is in the picture is near the mesh; brute force over a sphere.
void expect_covered(const Camera& c, const Transform& placement, const InstanceMesh& found, double px) {
  const TriMesh& mesh = found.mesh->mesh;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  int seen = 0;
  for (int k = 0; k < 400000 && seen < 100; ++k) {
    const dvec3 p = glm::normalize(dvec3(normal(random), normal(random), normal(random)));
    const dvec3 d = placement.point(p) - c.eye;
    const double z = glm::dot(d, c.forward), scale = c.pixel * (c.perspective ? z : 1.0);
    if (z <= 0.0 || std::abs(glm::dot(d, c.right)) > 0.5 * c.width_px * scale ||
        std::abs(glm::dot(d, c.up)) > 0.5 * c.height_px * scale)
      continue;
    ++seen;
    double nearest = kInf;
    for (const auto& t : mesh.triangles)
      nearest = std::min(
          nearest, distance_to_triangle(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
    const double stretch = glm::length(placement.linear[0]);  // the same in all directions here
    EXPECT_LE(nearest * stretch, px * scale * (1.0 + 1e-6)) << p.x << " " << p.y << " " << p.z;
  }
  EXPECT_GE(seen, 50);
}

TEST(MeshLevels, CutMeshesCoverWhatIsSeen) {
  const std::vector<Transform> placements{at({0.3, 0.1, 0.2}), at({1, 2, 1}, 3.0)};
  for (const bool perspective : {false, true})
    for (const double zoom : {30.0, 100.0}) {
      MeshLevels levels(spheres(placements));
      // In the perspective view the eye is a tenth before the spheres, so that their depths vary much.
      const Camera c = perspective ? front(0.1 / zoom, true, 2.5) : front(0.02 * 30.0 / zoom / 10.0);
      const ViewMeshes found = levels.meshes(c, 0.3);
      ASSERT_EQ(found.instances.size(), 2u);
      for (const InstanceMesh& i : found.instances) {
        EXPECT_TRUE(i.cut);
        expect_covered(c, placements[i.instance], i, 0.3);
        for (const std::int32_t v : i.mesh->mesh.triangles.at(0))
          EXPECT_LT(v, static_cast<std::int32_t>(i.mesh->mesh.vertices.size()));
      }
    }
}

TEST(MeshLevels, ACutMeshHasFewTrianglesBeyondThePicture) {
  const auto store = spheres({at({0, 0, 0})});
  MeshLevels levels(store);
  const Camera c = front(0.0005);  // 0.2 mm x 0.15 mm of the sphere
  const ViewMeshes found = levels.meshes(c, 0.2);
  ASSERT_EQ(found.instances.size(), 1u);
  const Tessellation whole = tessellate(*store, 0, UniformTolerance(0.2 * c.pixel));
  EXPECT_LT(100 * found.triangles, whole.mesh.triangles.size());
}

TEST(MeshLevels, ACutMeshIsKeptForTheSameAndForCoarserViews) {
  MeshLevels levels(spheres({at({0, 0, 0})}));
  const auto built = [&](const Camera& c, double px) { return levels.meshes(c, px).built; };
  Camera c = front(0.0005);
  EXPECT_EQ(built(c, 0.2), 1);
  EXPECT_EQ(built(c, 0.2), 0);
  EXPECT_EQ(built(c, 0.25), 0) << "coarser";
  EXPECT_EQ(built(c, 0.28), 0) << "coarser still";
  c.width_px -= 50;
  EXPECT_EQ(built(c, 0.2), 0) << "a part of it";
  c.width_px += 200;
  EXPECT_EQ(built(c, 0.2), 1) << "more of it";
  EXPECT_EQ(built(c, 0.09), 1) << "finer";
  c.eye.x += 0.5;
  EXPECT_EQ(built(c, 0.09), 1) << "elsewhere";
}

TEST(MeshLevels, ALevelServesCutInstancesToo) {
  MeshLevels levels(spheres({at({0, 0, 0})}));
  Camera c = front(0.01);
  EXPECT_EQ(levels.meshes(c, 0.25).built, 1);
  c.eye.x += 2.4;  // the rim of the sphere is left
  const ViewMeshes moved = levels.meshes(c, 0.25);
  EXPECT_EQ(moved.built, 0);
  ASSERT_EQ(moved.instances.size(), 1u);
  EXPECT_FALSE(moved.instances[0].cut);
  EXPECT_TRUE(check(moved.instances[0].mesh->mesh).open_edges == 0);
}

TEST(MeshLevels, MemoryIsBounded) {
  const auto store = spheres({at({0, 0, 0})});
  const std::size_t one = [&] {
    MeshLevels levels(store);
    levels.meshes(front(0.01), 0.25);
    return levels.bytes();
  }();
  MeshLevels levels(store, {.max_bytes = 5 * one / 2});
  EXPECT_EQ(levels.meshes(front(0.01), 0.25).built, 1);
  EXPECT_EQ(levels.meshes(front(0.04), 0.25).built, 1);
  EXPECT_EQ(levels.meshes(front(0.01), 0.25).reused, 1);
  EXPECT_EQ(levels.meshes(front(0.0075), 0.25).built, 1) << "larger than the first";
  EXPECT_LE(levels.bytes(), 5 * one / 2);
  EXPECT_EQ(levels.meshes(front(0.01), 0.25).reused, 1) << "used later than the coarse one";
  EXPECT_EQ(levels.meshes(front(0.04), 0.25).built, 1) << "dropped";
  MeshLevels none(store, {.max_bytes = 1});
  EXPECT_GT(none.meshes(front(0.01), 0.25).triangles, 100u);
  EXPECT_EQ(none.bytes(), 0u);
}

TEST(MeshLevels, SameForAnyNumberOfThreads) {
  std::vector<Transform> placements;
  for (int k = 0; k < 12; ++k) placements.push_back(at({0.5 * k, 3.0 * k, 0.3 * k}, 1.0 + 0.1 * k));
  const auto store = spheres(placements);
  MeshLevels one(store), four(store);
  for (const double pixel : {0.01, 0.012, 0.003, 0.01})
    for (const bool perspective : {false, true}) {
      const Camera c = front(perspective ? pixel / 20.0 : pixel, perspective, 20.0);
      const ViewMeshes a = one.meshes(c, 0.3, 1), b = four.meshes(c, 0.3, 4);
      EXPECT_EQ(std::tie(a.built, a.reused, a.triangles), std::tie(b.built, b.reused, b.triangles));
      ASSERT_EQ(a.instances.size(), b.instances.size());
      for (std::size_t i = 0; i < a.instances.size(); ++i) {
        const TriMesh &m = a.instances[i].mesh->mesh, &n = b.instances[i].mesh->mesh;
        EXPECT_TRUE(m.vertices == n.vertices && m.triangles == n.triangles && m.corner_uv == n.corner_uv);
      }
    }
}

TEST(MeshLevels, MayBeAskedFromSeveralThreads) {
  const auto store = spheres({at({0, 0, 0}), at({0, 5, 0}, 2.0)});
  MeshLevels levels(store);
  std::vector<std::thread> threads;
  std::vector<std::size_t> triangles(8);
  for (int k = 0; k < 8; ++k)
    threads.emplace_back(
        [&, k] { triangles[k] = levels.meshes(front(k % 2 == 0 ? 0.01 : 0.001), 0.3).triangles; });
  for (std::thread& t : threads) t.join();
  for (int k = 2; k < 8; ++k) EXPECT_EQ(triangles[k], triangles[k - 2]);
}

TEST(MeshLevels, WrongDeviationsAreRefused) {
  MeshLevels levels(spheres({at({0, 0, 0})}));
  for (const double px : {0.0, -1.0, kInf, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(levels.meshes(front(0.01), px), ArgumentError);
}

TEST(MeshLevels, NothingIsFineOfAnEmptyStore) {
  MeshLevels levels(std::make_shared<nurbs::NurbsStore>());
  EXPECT_TRUE(levels.meshes(front(0.01), 0.3).instances.empty());
}

}  // namespace
}  // namespace trimray::tess
