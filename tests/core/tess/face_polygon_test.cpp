// A single face on its way to triangles: its loops as polygons, its inner points, its mesh, and what stands
// in for one.
#include "core/tess/face_polygon.h"

#include <numeric>

#include <gtest/gtest.h>

#include "core/tess/face_mesh.h"
#include "core/tess/inner_points.h"
#include "tests/core/tess/random_surfaces.h"

namespace trimray::tess {
namespace {

using nurbs::Random;
using nurbs::TrimLoop;

struct OneFace {
  OneFace(const nurbs::SurfaceForm& form, const std::vector<TrimLoop>& loops, double mm)
      : tolerance(mm),
        store(nurbs::trimmed_face(form, loops)),
        chart(store, store.surfaces[0]),
        tree(store, chart, store.faces[0].uv_box, tolerance, kInf),
        limits{&tolerance, kInf} {
    wireframe.one.resize(store.vertices.size());
    std::iota(wireframe.one.begin(), wireframe.one.end(), 0);
    for (const nurbs::Edge& edge : store.edges) {
      const dvec3 ends[2] = {store.vertices[edge.vertex[0]].point, store.vertices[edge.vertex[1]].point};
      const std::int32_t c = store.edge_coedges[edge.coedges.begin];
      wireframe.polylines.push_back(make_polyline(store, edge, ends, {{&chart, &tree, c}}, limits));
    }
    polygon = make_polygon(store, 0, chart, wireframe, limits);
  }

  double area() const {
    double sum = 0.0;
    for (const auto& loop : polygon.loops)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const dvec2 a = loop[i].p, b = loop[(i + 1) % loop.size()].p;
        sum += 0.5 * (a.x * b.y - a.y * b.x);
      }
    return sum;
  }

  bool inside(dvec2 p) const {
    bool in = false;
    for (const auto& loop : polygon.loops)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const dvec2 a = loop[i].p, b = loop[(i + 1) % loop.size()].p;
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) in = !in;
      }
    return in;
  }

  UniformTolerance tolerance;
  nurbs::NurbsStore store;
  Chart chart;
  CurvatureTree tree;
  EdgeLimits limits;
  Wireframe wireframe;
  FacePolygon polygon;
};

double mesh_area(const FaceMesh& mesh) {
  double sum = 0.0;
  for (const auto& uv : mesh.corner_uv) {
    const dvec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    sum += 0.5 * (a.x * b.y - a.y * b.x);
  }
  return sum;
}

TEST(FacePolygon, HasTheSamplesOfItsEdgesInLoopOrder) {
  Random random(71);
  for (int k = 0; k < 40; ++k) {
    const auto loops = nurbs::gentle_loops(random, k % 5);
    const OneFace face(nurbs::random_patch(random, 3, 2, 1.0, k % 2 == 0), loops, 0.02);
    ASSERT_EQ(face.polygon.loops.size(), loops.size());
    double exact = 0.0;
    for (const auto& loop : loops) exact += nurbs::loop_area(loop);
    EXPECT_NEAR(face.area(), exact, 0.02);
    for (const auto& loop : face.polygon.loops)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const BoundaryPoint &b = loop[i], &next = loop[(i + 1) % loop.size()];
        EXPECT_TRUE(face.polygon.box.contains(b.p));
        EXPECT_LE(glm::distance(face.chart.point(b.p), b.place), face.store.edges[b.edge].band);
        ASSERT_GE(b.edge, 0);
        const EdgePolyline& line = face.wireframe.polyline(b.edge);
        EXPECT_EQ(b.place, line.points[b.segment]);
        EXPECT_EQ(next.place, line.points[b.segment + 1]);
        EXPECT_EQ(b.side_deviation, line.deviation[b.segment]);
      }
  }
}

TEST(InnerPoints, LieInsideAndAreAsManyAsTheGridHas) {
  Random random(72);
  std::size_t all = 0;
  for (int k = 0; k < 40; ++k) {
    const OneFace face(nurbs::random_patch(random, 3, 3, 1.0, k % 2 == 0), nurbs::gentle_loops(random, k % 5),
                       0.01);
    const auto points = inner_points(face.tree, face.polygon);
    std::size_t most = 0;
    for (const GridLeaf& leaf : face.tree.leaves()) most += std::size_t(leaf.count_u) * leaf.count_v;
    EXPECT_LE(points.size(), most);
    for (const dvec2 p : points) EXPECT_TRUE(face.inside(p));
    all += points.size();
  }
  EXPECT_GT(all, 400u);
}

TEST(FaceMesh, CoversThePolygonWithinTheTolerance) {
  Random random(73);
  for (int k = 0; k < 30; ++k) {
    const OneFace face(nurbs::random_patch(random, 3, 3, 1.0, k % 2 == 0), nurbs::gentle_loops(random, k % 5),
                       0.05);
    const FaceMesh mesh =
        mesh_face(face.store, 0, face.chart, &face.tree, face.polygon, face.limits, FaceHints{});
    if (!mesh.split.empty()) continue;  // wants finer edges: another round's business
    EXPECT_EQ(mesh.failure, "");
    EXPECT_NEAR(mesh_area(mesh), face.area(), 1e-12);
    for (const double d : mesh.deviation) EXPECT_LE(d, 0.05);
  }
}

// Loops that cross: the even-odd rule's region is covered, nothing is proven.
TEST(CoverFace, CoversWhatLoopsThatCrossBound) {
  const std::vector<TrimLoop> loops{nurbs::rectangle({0, 0}, {1, 1}),
                                    nurbs::turned(nurbs::rectangle({0.5, 0.4}, {1.5, 0.6}))};
  const OneFace face(nurbs::make_plane({}), loops, 0.01);
  const FaceMesh failed =
      mesh_face(face.store, 0, face.chart, nullptr, face.polygon, face.limits, FaceHints{});
  EXPECT_EQ(failed.failure, "its loops cross or touch");
  const FaceMesh cover = cover_face(face.store, 0, face.chart, face.polygon);
  EXPECT_NEAR(mesh_area(cover), 0.9 + 0.1, 1e-12);
  for (const double d : cover.deviation) EXPECT_EQ(d, kInf);
}

// Where nothing is left of the loops it is the whole box.
TEST(CoverFace, CoversTheBoxOfLoopsThatEncloseNothing) {
  const OneFace face(nurbs::make_plane({}), {nurbs::polygon({{0, 0}, {2, 1}})}, 0.01);
  const FaceMesh cover = cover_face(face.store, 0, face.chart, face.polygon);
  EXPECT_NEAR(mesh_area(cover), 2.0, 1e-12);
  EXPECT_EQ(cover.deviation.size(), cover.triangles.size());
}

}  // namespace
}  // namespace trimray::tess
