#include "core/tess/mesh_check.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/tess/mesh_sides.h"
#include "tests/core/tess/meshes.h"

namespace trimray::tess {
namespace {

constexpr double kPi = std::numbers::pi;

void expect_closed(const MeshCheck& c) {
  EXPECT_EQ(c.open_edges, 0);
  EXPECT_EQ(c.non_manifold_edges, 0);
  EXPECT_EQ(c.non_manifold_vertices, 0);
  EXPECT_EQ(c.degenerate_triangles, 0);
  EXPECT_TRUE(c.closed());
}

TEST(MeshCheck, IcosphereIsClosedWithAlmostTheVolumeOfTheSphere) {
  const MeshCheck c = check(icosphere(4));
  expect_closed(c);
  EXPECT_NEAR(c.volume, 4.0 / 3.0 * kPi, 0.01 * c.volume);
  EXPECT_NEAR(c.area, 4.0 * kPi, 0.01 * c.area);
  EXPECT_LT(c.volume, 4.0 / 3.0 * kPi);
}

TEST(MeshCheck, TorusIsClosed) {
  const MeshCheck c = check(torus_grid(120, 60, 3.0, 1.0));
  expect_closed(c);
  EXPECT_NEAR(c.volume, 2.0 * kPi * kPi * 3.0, 0.01 * c.volume);
}

TEST(MeshCheck, VolumeIsExactForATetrahedronFarFromTheOrigin) {
  TriMesh mesh = tetrahedron();
  for (dvec3& p : mesh.vertices) p += dvec3(1 << 20);
  const MeshCheck c = check(mesh);
  expect_closed(c);
  EXPECT_NEAR(c.volume, 1.0 / 6.0, 1e-12);
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(check(mesh).volume, -1.0 / 6.0, 1e-12);
}

TEST(MeshCheck, OpenGridHasItsRimOpen) {
  const MeshCheck c = check(flat_grid(5, 3));
  EXPECT_EQ(c.open_edges, 16);
  EXPECT_EQ(c.non_manifold_edges, 0);
  EXPECT_EQ(c.non_manifold_vertices, 0);
  EXPECT_DOUBLE_EQ(c.area, 15.0);
  EXPECT_FALSE(c.closed());
}

TEST(MeshCheck, MoebiusStripHasOneEdgeThatRunsTheSameWayTwice) {
  const MeshCheck c = check(moebius_strip(12));
  EXPECT_EQ(c.open_edges, 24);
  EXPECT_EQ(c.non_manifold_edges, 1);
  EXPECT_EQ(c.non_manifold_vertices, 0);
}

TEST(MeshCheck, ThreePagesShareANonManifoldEdge) {
  const MeshCheck c = check(three_pages());
  EXPECT_EQ(c.open_edges, 6);
  EXPECT_EQ(c.non_manifold_edges, 1);
  EXPECT_EQ(c.non_manifold_vertices, 2);
}

TEST(MeshCheck, BowTieHasANonManifoldVertex) {
  EXPECT_EQ(check(bow_tie()).non_manifold_vertices, 1);
  EXPECT_EQ(check(bow_tie()).non_manifold_edges, 0);
  EXPECT_EQ(check(two_tetrahedra_at_a_vertex()).non_manifold_vertices, 1);
  EXPECT_TRUE(check(two_tetrahedra_at_a_vertex()).closed());
}

TEST(MeshCheck, DegenerateTrianglesAreCounted) {
  TriMesh mesh = tetrahedron();
  add_triangle(mesh, 1, 1, 2);  // a vertex twice: no sides of its own
  EXPECT_EQ(check(mesh).degenerate_triangles, 1);
  EXPECT_TRUE(check(mesh).closed());
  mesh = flat_grid(1, 1);
  mesh.vertices[1] = dvec3(0.5, 0.5 + 1e-13, 0.0);  // (0, 1) onto the diagonal
  EXPECT_EQ(check(mesh).degenerate_triangles, 1);
  mesh.vertices[1] = dvec3(0.5, 0.5 + 1e-10, 0.0);
  EXPECT_EQ(check(mesh).degenerate_triangles, 0);
  mesh.vertices[1] = dvec3(kNaN);
  EXPECT_EQ(check(mesh).degenerate_triangles, 1);
}

TEST(MeshCheck, NothingIsAskedOfAnEmptyMesh) {
  const MeshCheck c = check(TriMesh{});
  expect_closed(c);
  EXPECT_EQ(c.area, 0.0);
}

TEST(MeshCheck, VerticesThatDoNotExistAreRefused) {
  for (const std::int32_t bad : {-1, 4, 1 << 30}) {
    TriMesh mesh = tetrahedron();
    mesh.triangles[2][1] = bad;
    EXPECT_THROW(check(mesh), ArgumentError);
  }
}

TEST(MeshCheck, CountsDoNotDependOnTheOrderOfTriangles) {
  TriMesh mesh = torus_grid(20, 10, 3.0, 1.0);
  mesh.triangles.resize(311);
  const MeshCheck before = check(mesh);
  std::mt19937 random(1);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
  for (auto& t : mesh.triangles) std::rotate(t.begin(), t.begin() + random() % 3, t.end());
  const MeshCheck after = check(mesh);
  EXPECT_EQ(before.open_edges, after.open_edges);
  EXPECT_EQ(before.non_manifold_vertices, after.non_manifold_vertices);
  EXPECT_GT(before.open_edges, 0);
}

// The counts in another way: every pair of triangles looked at.
TEST(MeshCheck, RandomTriangleSoupsAgreeWithCountingEachEdgeByItself) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    TriMesh mesh;
    const int vertices = 4 + static_cast<int>(random() % 6);
    for (int i = 0; i < vertices; ++i)
      mesh.vertices.emplace_back(random() % 1000, random() % 1000, random() % 1000);
    for (int i = 0; i < 8; ++i)
      add_triangle(mesh, random() % vertices, random() % vertices, random() % vertices);
    std::int64_t open = 0, bad = 0;
    for (int a = 0; a < vertices; ++a) {
      for (int b = a + 1; b < vertices; ++b) {
        int up = 0, down = 0;
        for (const auto& t : mesh.triangles) {
          if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
          for (int k = 0; k < 3; ++k)
            up += t[k] == a && t[(k + 1) % 3] == b, down += t[k] == b && t[(k + 1) % 3] == a;
        }
        open += up + down == 1;
        bad += up + down > 2 || up == 2 || down == 2;
      }
    }
    const MeshCheck c = check(mesh);
    EXPECT_EQ(c.open_edges, open) << round;
    EXPECT_EQ(c.non_manifold_edges, bad) << round;
  }
}

}  // namespace
}  // namespace trimray::tess
