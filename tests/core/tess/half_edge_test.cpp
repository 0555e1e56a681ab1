#include "core/tess/half_edge.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/tess/mesh_check.h"
#include "tests/core/tess/meshes.h"

namespace trimray::tess {
namespace {

TEST(HalfEdge, ClosedMeshesAreTakenWhole) {
  for (const TriMesh& mesh : {icosphere(2), torus_grid(12, 8, 3.0, 1.0), tetrahedron()}) {
    const HalfEdgeMesh half = half_edges(mesh);
    EXPECT_TRUE(half.closed_manifold());
    EXPECT_EQ(half.kernel.n_edges(), 3 * mesh.triangles.size() / 2);
    EXPECT_EQ(half.triangles.size(), mesh.triangles.size());
  }
}

TEST(HalfEdge, WhatIsNotManifoldIsRefused) {
  EXPECT_EQ(half_edges(moebius_strip(12)).refused.size(), 1u);
  EXPECT_EQ(half_edges(three_pages()).refused.size(), 2u);  // each page runs the same way along the edge
  EXPECT_GT(half_edges(two_tetrahedra_at_a_vertex()).refused.size(), 0u);
  EXPECT_EQ(half_edges(bow_tie()).refused.size(), 0u);
  EXPECT_FALSE(half_edges(bow_tie()).closed_manifold());
  EXPECT_FALSE(half_edges(flat_grid(3, 2)).closed_manifold());
}

TEST(HalfEdge, VerticesThatDoNotExistAreRefused) {
  TriMesh mesh = tetrahedron();
  mesh.triangles[0][0] = 9;
  EXPECT_THROW(half_edges(mesh), ArgumentError);
}

// The half-edge mesh and the count over sorted sides must agree on what is closed and manifold, also after
// triangles were lost, doubled or turned over.
TEST(HalfEdge, AgreesWithTheCheckOnDamagedMeshes) {
  std::mt19937 random(3);
  int closed = 0;
  for (int round = 0; round < 300; ++round) {
    TriMesh mesh = round % 2 == 0 ? icosphere(1) : torus_grid(6, 5, 3.0, 1.0);
    const std::size_t at = random() % mesh.triangles.size();
    const std::int32_t other = static_cast<std::int32_t>(random() % mesh.vertices.size());
    switch (round % 5) {
      case 0:
        std::swap(mesh.triangles[at][0], mesh.triangles[at][1]);
        break;
      case 1:
        mesh.triangles[at][random() % 3] = other;
        break;
      case 2:
        add_triangle(mesh, mesh.triangles[at][0], mesh.triangles[at][1], other);
        break;
      case 3:
        mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      default:
        std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    }
    const MeshCheck c = check(mesh);
    const bool whole = c.closed() && c.non_manifold_vertices == 0 &&
                       std::none_of(mesh.triangles.begin(), mesh.triangles.end(), [](const auto& t) {
                         return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
                       });
    EXPECT_EQ(half_edges(mesh).closed_manifold(), whole) << round;
    closed += whole;
  }
  EXPECT_GE(closed, 60);
}

// A height field over a grid; its deviation here: height of the surface over the triangle's middle.
double height(dvec2 uv) { return 0.2 * (uv.x + uv.y) * (uv.x + uv.y); }
double middle_gap(std::int32_t, const std::array<dvec2, 3>& uv, const std::array<dvec3, 3>& p) {
  double worst = 0.0;
  for (int k = 0; k < 3; ++k) {
    const dvec2 m = 0.5 * (uv[k] + uv[(k + 1) % 3]);
    worst = std::max(worst, std::abs(height(m) - 0.5 * (p[k].z + p[(k + 1) % 3].z)));
  }
  return worst;
}

TriMesh height_field(int n) {
  TriMesh mesh = grid(n, n, false, false, [](int i, int j) { return dvec3(i, j, height(dvec2(i, j))); });
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    mesh.deviation[i] =
        middle_gap(0, mesh.corner_uv[i], {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  return mesh;
}

TEST(Improve, FlipsTheDiagonalsThatCrossTheValley) {
  // The surface bends along (1, 1) only: every diagonal should run along (1, -1).
  TriMesh mesh = height_field(8);
  const double before = *std::max_element(mesh.deviation.begin(), mesh.deviation.end());
  const MeshCheck was = check(mesh);
  EXPECT_GE(improve(mesh, middle_gap), 64);
  const double after = *std::max_element(mesh.deviation.begin(), mesh.deviation.end());
  EXPECT_LT(after, 0.3 * before);
  const MeshCheck is = check(mesh);
  EXPECT_EQ(is.open_edges, was.open_edges);
  EXPECT_EQ(is.non_manifold_edges, 0);
  EXPECT_EQ(is.degenerate_triangles, 0);
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& uv = mesh.corner_uv[i];
    const dvec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    EXPECT_GT(a.x * b.y - a.y * b.x, 0.0);
    area += 0.5 * (a.x * b.y - a.y * b.x);
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(dvec2(mesh.vertices[mesh.triangles[i][k]]), mesh.corner_uv[i][k]) << "uv went astray";
    const auto& t = mesh.triangles[i];
    EXPECT_EQ(mesh.deviation[i],
              middle_gap(0, uv, {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}));
  }
  EXPECT_DOUBLE_EQ(area, 64.0);
}

TEST(Improve, NothingIsFlippedAcrossFacesOrSeamsOrWhereItIsGoodEnough) {
  TriMesh mesh = height_field(4);
  for (std::size_t i = 0; i < mesh.face.size(); ++i) mesh.face[i] = static_cast<std::int32_t>(i);
  EXPECT_EQ(improve(mesh, middle_gap), 0);
  mesh = height_field(4);
  for (std::size_t i = 0; i < mesh.corner_uv.size(); i += 2)
    for (dvec2& uv : mesh.corner_uv[i]) uv.x += 100.0;
  EXPECT_EQ(improve(mesh, middle_gap), 0);
  mesh = height_field(4);
  EXPECT_EQ(improve(mesh, middle_gap, 1e3), 0);
  for (double& d : mesh.deviation) d = kInf;
  EXPECT_EQ(improve(mesh, middle_gap), 0);
}

TEST(Improve, NoEdgeIsMadeTwice) {
  // Both ways over a tetrahedron's edges exist already.
  TriMesh mesh = tetrahedron();
  for (auto& uv : mesh.corner_uv) uv = {dvec2(0, 0), dvec2(1, 0), dvec2(0, 1)};
  for (double& d : mesh.deviation) d = 1.0;
  EXPECT_EQ(improve(mesh, [](auto, const auto&, const auto&) { return 0.0; }), 0);
}

TEST(Improve, RandomHeightFieldsStayMeshesOfTheSameGrid) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  for (int round = 0; round < 20; ++round) {
    TriMesh mesh = height_field(10);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const int i = static_cast<int>(v) / 11, j = static_cast<int>(v) % 11;
      if (i == 0 || j == 0 || i == 10 || j == 10) continue;
      const dvec2 uv(i + jitter(random), j + jitter(random));
      mesh.vertices[v] = dvec3(uv, height(uv));
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& t = mesh.triangles[i];
      for (int k = 0; k < 3; ++k) mesh.corner_uv[i][k] = dvec2(mesh.vertices[t[k]]);
      mesh.deviation[i] =
          middle_gap(0, mesh.corner_uv[i], {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    }
    TriMesh again = mesh;
    const double before = *std::max_element(mesh.deviation.begin(), mesh.deviation.end());
    EXPECT_GT(improve(mesh, middle_gap), 0);
    EXPECT_LE(*std::max_element(mesh.deviation.begin(), mesh.deviation.end()), before);
    EXPECT_EQ(check(mesh).open_edges, 40);
    EXPECT_EQ(check(mesh).non_manifold_edges, 0);
    double area = 0.0;
    for (const auto& uv : mesh.corner_uv) {
      const dvec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
      area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    EXPECT_NEAR(area, 100.0, 1e-9);
    improve(again, middle_gap);
    EXPECT_EQ(again.triangles, mesh.triangles);
  }
}

}  // namespace
}  // namespace trimray::tess
