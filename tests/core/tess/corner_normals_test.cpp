#include "core/tess/corner_normals.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/nurbs/make_store.h"
#include "tests/core/tess/face_grid.h"

namespace trimray::tess {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

TEST(CornerNormals, SphereHasItsOwnOutwardNormalsPolesIncluded) {
  for (const bool reversed : {false, true}) {
    nurbs::FaceSpec spec = nurbs::full_sphere({}, 2.0);
    spec.reversed = reversed;
    const nurbs::NurbsStore store = nurbs::make_store(std::span(&spec, 1));
    const TriMesh mesh = face_grid(store, 24, 12, true);
    const auto normals = corner_normals(store, mesh);
    ASSERT_EQ(normals.size(), 3 * mesh.triangles.size());
    for (std::size_t c = 0; c < normals.size(); ++c) {
      const dvec3 p = mesh.vertices[mesh.triangles[c / 3][c % 3]] / 2.0;
      EXPECT_LT(glm::distance(normals[c], reversed ? -p : p), 1e-3) << c;
    }
  }
}

TEST(CornerNormals, BothSidesOfASmoothEdgeGetTheSameBits) {
  const nurbs::FaceSpec spec = nurbs::tube({}, 1.0, 0.0, 3.0);
  const nurbs::NurbsStore store = nurbs::make_store(std::span(&spec, 1));
  const TriMesh mesh = face_grid(store, 16, 2, true);
  const auto normals = corner_normals(store, mesh);
  std::vector<dvec3> at(mesh.vertices.size(), dvec3(0.0));
  for (std::size_t c = 0; c < normals.size(); ++c) {
    dvec3& n = at[mesh.triangles[c / 3][c % 3]];
    if (n == dvec3(0.0)) n = normals[c];
    EXPECT_EQ(n, normals[c]);
    EXPECT_NEAR(glm::length(n), 1.0, 1e-14);
    EXPECT_NEAR(n.z, 0.0, 1e-14);
  }
}

TEST(CornerNormals, CreasesStaySharp) {
  // Two planes of one store that share an edge of the mesh.
  const nurbs::FaceSpec specs[2] = {{nurbs::make_plane({}), {{0, 0}, {1, 1}}},
                                    {nurbs::make_plane({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}), {{0, 0}, {1, 1}}}};
  const nurbs::NurbsStore store = nurbs::make_store(specs);
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
  add_triangle(mesh, 0, 2, 1, 0), add_triangle(mesh, 0, 1, 3, 1);
  const auto normals = corner_normals(store, mesh);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(normals[c], dvec3(0, 0, 1));
  for (int c = 3; c < 6; ++c) EXPECT_EQ(normals[c], dvec3(1, 0, 0));
}

TEST(CornerNormals, ConesApexTakesTheNormalsOfItsTriangles) {
  const double slope = 0.5;
  const nurbs::FaceSpec spec{nurbs::make_cone({}, 1.0, -slope), {{0.0, 0.0}, {kTurn, 1.0 / std::sin(slope)}}};
  const nurbs::NurbsStore store = nurbs::make_store(std::span(&spec, 1));
  for (const int n : {12, 400}) {  // few wide triangles, and ones that agree with their neighbours
    const TriMesh mesh = face_grid(store, n, 1, true);
    const auto normals = corner_normals(store, mesh);
    for (std::size_t c = 0; c < normals.size(); ++c) {
      if (mesh.corner_uv[c / 3][c % 3].y < 1.0) continue;
      EXPECT_NEAR(normals[c].z, std::sin(slope), 1e-2) << "not the axis";
      const double u =
          (mesh.corner_uv[c / 3][0].x + mesh.corner_uv[c / 3][1].x + mesh.corner_uv[c / 3][2].x) / 3;
      EXPECT_GT(normals[c].x * std::cos(u) + normals[c].y * std::sin(u), 0.8 * std::cos(slope));
    }
  }
}

TEST(CornerNormals, OneAndTwoThreadsGiveTheSameBytes) {
  const nurbs::FaceSpec spec = nurbs::full_torus({}, 3.0, 1.0);
  const nurbs::NurbsStore store = nurbs::make_store(std::span(&spec, 1));
  const TriMesh mesh = face_grid(store, 40, 20, true);
  EXPECT_EQ(corner_normals(store, mesh, 1), corner_normals(store, mesh, 2));
}

TEST(CornerNormals, AMeshOfAnotherStoreIsRefused) {
  const nurbs::FaceSpec spec = nurbs::full_torus({}, 3.0, 1.0);
  const nurbs::NurbsStore store = nurbs::make_store(std::span(&spec, 1));
  TriMesh mesh = tetrahedron();
  mesh.face[1] = 1;
  EXPECT_THROW(corner_normals(store, mesh), ArgumentError);
  mesh.face.pop_back();
  EXPECT_THROW(corner_normals(store, mesh), ArgumentError);
}

}  // namespace
}  // namespace trimray::tess
