// The graph of shapes: counts, orientation, placement, seams, smoothness, meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "core/brep/bintools.h"
#include "tests/core/brep/streams.h"

namespace trimray::brep {
namespace {

std::array<int, 8> kinds(const Model& model) {
  std::array<int, 8> counts{};
  for (const Shape& shape : model.shapes) ++counts[static_cast<std::size_t>(shape.kind)];
  return counts;
}

TEST(BintoolsTopology, BoxSharesItsEdgesAndVertices) {
  const Model model = parse_bintools(testing::read_stream("box"));
  EXPECT_EQ(kinds(model), (std::array{0, 0, 1, 1, 6, 6, 12, 8}));
  EXPECT_EQ(model.shapes.back().kind, ShapeKind::kSolid);  // the root comes last

  dvec3 lower(1e9), upper(-1e9);
  for (const VertexData& v : model.vertices) lower = min(lower, v.point), upper = max(upper, v.point);
  EXPECT_EQ(lower, dvec3(0));
  EXPECT_EQ(upper, dvec3(1, 2, 3));

  // Every edge is used by two wires and bounded by a forward and a reversed vertex.
  std::vector<int> uses(model.shapes.size());
  for (const Shape& shape : model.shapes) {
    if (shape.kind == ShapeKind::kShell || shape.kind == ShapeKind::kEdge) {
      EXPECT_EQ(shape.closed, shape.kind == ShapeKind::kShell);
    }
    if (shape.kind != ShapeKind::kWire) continue;
    EXPECT_EQ(shape.children.size(), 4u);
    for (const ShapeUse& use : shape.children) ++uses[use.shape];
  }
  for (std::size_t i = 0; i < model.shapes.size(); ++i) {
    const Shape& shape = model.shapes[i];
    if (shape.kind != ShapeKind::kEdge) continue;
    EXPECT_EQ(uses[i], 2);
    ASSERT_EQ(shape.children.size(), 2u);
    EXPECT_NE(shape.children[0].orientation, shape.children[1].orientation);

    // The line really runs from the forward to the reversed vertex.
    const EdgeData& edge = model.edges[shape.data];
    const Curve3& line = model.curves3.at(edge.curve3);
    for (const ShapeUse& use : shape.children) {
      const double t = use.orientation == Orientation::kForward ? edge.first : edge.last;
      const dvec3 p = model.vertices[model.shapes[use.shape].data].point;
      EXPECT_LE(glm::distance(line.location + t * line.x_axis, p), 1e-14);
    }
  }
}

TEST(BintoolsTopology, ChildrenStandBeforeParents) {
  for (const char* name : {"box", "cone", "meshes", "rounded_box", "locations"}) {
    const Model model = parse_bintools(testing::read_stream(name));
    for (std::size_t i = 0; i < model.shapes.size(); ++i) {
      for (const ShapeUse& use : model.shapes[i].children) EXPECT_LT(use.shape, static_cast<int>(i));
    }
  }
}

TEST(BintoolsTopology, CylinderHasASeamOfTwoCurves) {
  const Model model = parse_bintools(testing::read_stream("cylinder"));
  EXPECT_EQ(kinds(model), (std::array{0, 0, 1, 1, 3, 3, 3, 2}));
  int seams = 0;
  for (const EdgeData& edge : model.edges) {
    for (const PCurve& p : edge.pcurves) {
      const Surface& surface = model.surfaces.at(p.surface);
      if (p.curve2 < 0) continue;
      ++seams;
      EXPECT_TRUE(edge.smooth);
      EXPECT_EQ(surface.kind, SurfaceKind::kCylinder);
      EXPECT_EQ(surface.r1, 2.5);
      EXPECT_EQ(p.first, 0);
      EXPECT_EQ(p.last, 7);
      // One curve at u = 2 pi, the other at u = 0.
      EXPECT_EQ(model.curves2.at(p.curve).location.x + model.curves2.at(p.curve2).location.x,
                2 * std::numbers::pi);
    }
  }
  EXPECT_EQ(seams, 1);
}

TEST(BintoolsTopology, OlderVersionsSayTheSame) {
  const Model model = parse_bintools(testing::read_stream("cylinder"));
  for (const char* name : {"cylinder_v1", "cylinder_v2", "cylinder_v3"}) {
    const Model older = parse_bintools(testing::read_stream(name));
    EXPECT_EQ(kinds(older), kinds(model));
    ASSERT_EQ(older.edges.size(), model.edges.size());
    for (std::size_t i = 0; i < model.edges.size(); ++i) {
      EXPECT_EQ(older.edges[i].last, model.edges[i].last);
      ASSERT_EQ(older.edges[i].pcurves.size(), model.edges[i].pcurves.size());
      EXPECT_EQ(older.edges[i].smooth, model.edges[i].smooth);
    }
    for (std::size_t i = 0; i < model.vertices.size(); ++i) {
      EXPECT_EQ(older.vertices[i].point, model.vertices[i].point);
    }
  }
}

TEST(BintoolsTopology, PolesAreDegenerateEdges) {
  const Model sphere = parse_bintools(testing::read_stream("sphere"));
  EXPECT_EQ(kinds(sphere), (std::array{0, 0, 1, 1, 1, 1, 3, 2}));
  int degenerate = 0;
  for (const EdgeData& edge : sphere.edges) {
    degenerate += edge.degenerated;
    EXPECT_EQ(edge.degenerated, edge.curve3 < 0);
    EXPECT_EQ(edge.pcurves.size(), 1u);
  }
  EXPECT_EQ(degenerate, 2);
  for (const VertexData& v : sphere.vertices) EXPECT_NEAR(std::abs(v.point.z), 4.0, 1e-14);

  const Model cone = parse_bintools(testing::read_stream("cone"));
  EXPECT_EQ(std::ranges::count_if(cone.edges, &EdgeData::degenerated), 1);
  const auto apex = std::ranges::find_if(cone.surfaces, [](auto& s) { return s.kind == SurfaceKind::kCone; });
  ASSERT_NE(apex, cone.surfaces.end());
  EXPECT_NEAR(std::tan(apex->semi_angle), -3.0 / 4.0, 1e-15);
}

TEST(BintoolsTopology, TorusHasTwoSeams) {
  const Model model = parse_bintools(testing::read_stream("torus"));
  EXPECT_EQ(kinds(model), (std::array{0, 0, 1, 1, 1, 1, 2, 1}));
  for (const EdgeData& edge : model.edges) {
    ASSERT_EQ(edge.pcurves.size(), 1u);
    EXPECT_GE(edge.pcurves[0].curve2, 0);
  }
}

TEST(BintoolsTopology, RoundedBoxIsSmoothAlongItsFillet) {
  const Model model = parse_bintools(testing::read_stream("rounded_box"));
  EXPECT_EQ(model.faces.size(), 7u);
  EXPECT_EQ(model.edges.size(), 15u);
  EXPECT_EQ(std::ranges::count_if(model.edges, &EdgeData::smooth), 2);
  // A smooth edge lies between the fillet of radius 1 and a plane, along the fillet's axis.
  const auto fillet =
      std::ranges::find_if(model.surfaces, [](auto& s) { return s.kind == SurfaceKind::kCylinder; });
  ASSERT_NE(fillet, model.surfaces.end());
  EXPECT_EQ(fillet->r1, 1.0);
  for (const EdgeData& edge : model.edges) {
    if (!edge.smooth) continue;
    const Curve3& line = model.curves3.at(edge.curve3);
    EXPECT_EQ(line.kind, CurveKind::kLine);
    EXPECT_NEAR(std::abs(dot(line.x_axis, fillet->z_axis)), 1.0, 1e-15);
  }
}

TEST(BintoolsTopology, CompositeLocationsAreEvaluated) {
  const Model model = parse_bintools(testing::read_stream("locations"));
  const std::vector<ShapeUse>& uses = model.shapes.back().children;
  ASSERT_EQ(uses.size(), 10u);
  // By hand: odd i turns (x, y, z) to (-y, x, z), even i to (x, -z, y); then a step (i, 10 i, 100 i).
  const auto first = [](dvec3 p) { return dvec3(-p.y, p.x, p.z) + dvec3(1, 10, 100); };
  const auto second = [](dvec3 p) { return dvec3(p.x, -p.z, p.y) + dvec3(2, 20, 200); };
  const auto third = [](dvec3 p) { return dvec3(-p.y, p.x, p.z) + dvec3(3, 30, 300); };
  const auto second_back = [](dvec3 p) {
    p -= dvec3(2, 20, 200);
    return dvec3(p.x, p.z, -p.y);
  };
  const dvec3 p(1, 2, 3);
  const std::vector<dvec3> expected = {p,
                                       first(p),
                                       first(second(p)),
                                       first(second(third(p))),
                                       third(third(third(p))),
                                       second_back(second_back(p)),
                                       first(second_back(p)),
                                       {1, 2, 7},
                                       {3, 6, 9},
                                       p};
  for (std::size_t i = 0; i < uses.size(); ++i) {
    const VertexData& vertex = model.vertices.at(model.shapes.at(uses[i].shape).data);
    EXPECT_EQ(vertex.point, p);
    EXPECT_EQ(vertex.tolerance, 0.5);
    const dvec3 placed = uses[i].location < 0 ? p : model.locations.at(uses[i].location).point(p);
    EXPECT_LE(glm::distance(placed, expected[i]), 1e-12) << "use " << i;
    EXPECT_EQ(uses[i].orientation, i == 9 ? Orientation::kReversed : Orientation::kForward);
  }
  EXPECT_EQ(uses[0].location, -1);
}

TEST(BintoolsTopology, MeshesAreKept) {
  for (const char* name : {"meshes", "meshes_v3"}) {
    const Model model = parse_bintools(testing::read_stream(name));
    EXPECT_EQ(kinds(model), (std::array{1, 0, 1, 1, 4, 3, 4, 2}));
    for (const FaceData& face : model.faces) EXPECT_GE(face.mesh, 0);
    EXPECT_EQ(std::ranges::count(model.faces, -1, &FaceData::surface), 1);
    EXPECT_EQ(std::ranges::count(model.edges, -1, &EdgeData::curve3), 1);
  }
  const Model model = parse_bintools(testing::read_stream("mesh_face"));
  ASSERT_EQ(model.faces.size(), 1u);
  EXPECT_EQ(model.faces[0].surface, -1);
  ASSERT_EQ(model.faces[0].mesh, 0);
  const Mesh& mesh = model.meshes[0];
  EXPECT_EQ(mesh.nodes, (std::vector<dvec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::int32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(BintoolsTopology, PointRepresentationsArePassedOver) {
  const Model model = parse_bintools(testing::read_stream("points"));
  EXPECT_EQ(kinds(model), (std::array{1, 0, 0, 0, 1, 0, 1, 3}));
  const auto inside = std::ranges::find(model.vertices, 0.25, &VertexData::tolerance);
  ASSERT_NE(inside, model.vertices.end());
  EXPECT_EQ(inside->point, dvec3(4, 0, 0));
  for (const Shape& shape : model.shapes) {
    if (shape.kind != ShapeKind::kEdge) continue;
    EXPECT_EQ(std::ranges::count(shape.children, Orientation::kInternal, &ShapeUse::orientation), 1);
  }
}

}  // namespace
}  // namespace trimray::brep
