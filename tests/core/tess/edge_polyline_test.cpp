// Polylines of random edges against points of their curves.
#include "core/tess/edge_polyline.h"

#include <gtest/gtest.h>

#include "core/nurbs/spline.h"
#include "tests/core/tess/random_surfaces.h"

namespace trimray::tess {
namespace {

using nurbs::Random;

dvec3 path_point(const nurbs::NurbsStore& store, const nurbs::Edge& edge, double at) {
  const int k = std::min(static_cast<int>(at), edge.pieces.size() - 1);
  const nurbs::CurvePiece& piece = store.edge_pieces[edge.pieces.begin + k];
  return nurbs::project(
      nurbs::bezier_point(store.edge_ctrl_h.data() + piece.ctrl.begin, piece.ctrl.size() - 1, at - k));
}

double distance_to_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 d = b - a;
  const double length2 = glm::dot(d, d);
  return glm::distance(p, a + (length2 > 0.0 ? std::clamp(glm::dot(p - a, d) / length2, 0.0, 1.0) : 0.0) * d);
}

// Both ways: the path from the segment, and the segment from (many points of) its part of the path.
void expect_as_near_as_proven(const nurbs::NurbsStore& store, const nurbs::Edge& edge,
                              const EdgePolyline& line) {
  ASSERT_EQ(line.points.size(), line.at.size());
  ASSERT_EQ(static_cast<int>(line.deviation.size()), line.segments());
  constexpr int kPlaces = 40;
  for (int k = 0; k < line.segments(); ++k) {
    ASSERT_LT(line.at[k], line.at[k + 1]);
    const dvec3 &a = line.points[k], &b = line.points[k + 1];
    std::vector<dvec3> path;
    double step = 0.0;
    for (int i = 0; i <= kPlaces; ++i) {
      path.push_back(path_point(store, edge, line.at[k] + (line.at[k + 1] - line.at[k]) * i / kPlaces));
      ASSERT_LE(distance_to_segment(path.back(), a, b), line.deviation[k] * (1.0 + 1e-9) + 1e-12);
      if (i > 0) step = std::max(step, glm::distance(path[i], path[i - 1]));
    }
    for (int i = 0; i <= kPlaces; ++i) {
      const dvec3 p = a + (b - a) * (double(i) / kPlaces);
      double nearest = kInf;
      for (std::size_t j = 0; j + 1 < path.size(); ++j)
        nearest = std::min(nearest, distance_to_segment(p, path[j], path[j + 1]));
      // The path's own chords are this far from it at most.
      ASSERT_LE(nearest, line.deviation[k] + 0.5 * step * step / glm::distance(a, b) + 1e-9);
    }
  }
}

// One edge alone, of several rational pieces that join.
nurbs::TrimmedMaker random_edge(Random& random, int pieces) {
  nurbs::TrimmedMaker maker;
  dvec3 start(0.0);
  nurbs::Edge edge;
  edge.pieces.begin = 0;
  for (int k = 0; k < pieces; ++k) {
    const int degree = 1 + static_cast<int>(random() % 4);
    nurbs::CurvePiece piece;
    piece.ctrl.begin = static_cast<std::int32_t>(maker.store.edge_ctrl_h.size());
    dvec3 p = start;
    for (int i = 0; i <= degree; ++i) {
      const double w = nurbs::uniform(random, 0.5, 2.0);
      maker.store.edge_ctrl_h.emplace_back(w * p, w);
      if (i < degree)
        p += dvec3(1.0, nurbs::uniform(random, -1, 1), nurbs::uniform(random, -1, 1)) / double(degree);
    }
    start = p;
    piece.ctrl.end = static_cast<std::int32_t>(maker.store.edge_ctrl_h.size());
    piece.t0 = k, piece.t1 = k + 1;
    maker.store.edge_pieces.push_back(piece);
  }
  edge.pieces.end = pieces;
  edge.vertex[0] = maker.vertex({0, 0, 0}), edge.vertex[1] = maker.vertex(start);
  maker.store.edges.push_back(edge);
  return maker;
}

TEST(EdgePolyline, IsAsNearAsProvenAndAsAsked) {
  Random random(51);
  for (int k = 0; k < 200; ++k) {
    const auto maker = random_edge(random, 1 + static_cast<int>(random() % 5));
    const nurbs::Edge& edge = maker.store.edges[0];
    const UniformTolerance tolerance(std::pow(10.0, nurbs::uniform(random, -4.0, 0.0)));
    const dvec3 ends[2] = {maker.store.vertices[edge.vertex[0]].point,
                           maker.store.vertices[edge.vertex[1]].point};
    EdgePolyline line = make_polyline(maker.store, edge, ends, {}, {.tolerance = &tolerance});
    EXPECT_EQ(line.at.front(), 0.0);
    EXPECT_EQ(line.at.back(), edge.pieces.size());
    EXPECT_EQ(line.points.front(), ends[0]);
    EXPECT_EQ(line.points.back(), ends[1]);
    for (const double d : line.deviation) EXPECT_LE(d, tolerance.at({}));
    expect_as_near_as_proven(maker.store, edge, line);
    // Cut somewhere: the parts have bounds of their own.
    std::vector<Cut> cuts;
    for (int i = 0; i < line.segments(); i += 1 + static_cast<int>(random() % 3))
      cuts.push_back({i, line.at[i] + nurbs::uniform(random, 0.1, 0.9) * (line.at[i + 1] - line.at[i])});
    const int before = line.segments();
    split_segments(maker.store, edge, cuts, line);
    EXPECT_EQ(line.segments(), before + static_cast<int>(cuts.size()));
    expect_as_near_as_proven(maker.store, edge, line);
  }
}

TEST(EdgePolyline, TakesAboutAsManySegmentsAsACircleNeeds) {
  const auto circle = nurbs::ellipse({0, 0}, 1.0, 1.0);
  for (const double asked : {0.1, 1e-2, 1e-3, 1e-4, 1e-5}) {
    nurbs::NurbsStore store;
    nurbs::Edge edge;
    for (const auto& quarter : circle) {
      nurbs::CurvePiece piece;
      piece.ctrl.begin = static_cast<std::int32_t>(store.edge_ctrl_h.size());
      for (const dvec3& h : quarter) store.edge_ctrl_h.emplace_back(h.x, h.y, 0.0, h.z);
      piece.ctrl.end = static_cast<std::int32_t>(store.edge_ctrl_h.size());
      store.edge_pieces.push_back(piece);
    }
    edge.pieces = {0, 4}, edge.vertex[0] = edge.vertex[1] = 0;
    store.vertices.push_back({{1, 0, 0}, 0.0});
    store.edges.push_back(edge);
    const UniformTolerance tolerance(asked);
    const dvec3 ends[2] = {{1, 0, 0}, {1, 0, 0}};
    const EdgePolyline line = make_polyline(store, edge, ends, {}, {.tolerance = &tolerance});
    expect_as_near_as_proven(store, edge, line);
    const double needed = std::numbers::pi / std::acos(1.0 - asked);
    EXPECT_LE(line.segments(), std::max(8.0, 1.6 * needed + 1.0)) << asked;
    EXPECT_GE(line.segments(), needed - 1e-9);
  }
}

// Samples of an edge lie in each face's chart where its p-curve is, and on the edge in space.
TEST(EdgePolyline, SamplesHavePlacesInTheChart) {
  Random random(52);
  for (int k = 0; k < 40; ++k) {
    const bool rational = k % 2 == 0;
    const auto form = nurbs::random_patch(random, 3, 3, 1.0, rational);
    const auto store = nurbs::trimmed_face(form, nurbs::gentle_loops(random, 2));
    const Chart chart(store, store.surfaces[0]);
    const UniformTolerance tolerance(0.05);
    const CurvatureTree tree(store, chart, store.faces[0].uv_box, tolerance, kInf);
    for (std::size_t e = 0; e < store.edges.size(); ++e) {
      const nurbs::Edge& edge = store.edges[e];
      const std::int32_t c = store.edge_coedges[edge.coedges.begin];
      const dvec3 ends[2] = {store.vertices[edge.vertex[0]].point, store.vertices[edge.vertex[1]].point};
      const EdgePolyline line =
          make_polyline(store, edge, ends, {{&chart, &tree, c}}, {.tolerance = &tolerance});
      expect_as_near_as_proven(store, edge, line);
      for (std::size_t i = 0; i < line.at.size(); ++i) {
        const dvec2 uv = pcurve_point(store, store.coedges[c], line.at[i]);
        EXPECT_LE(glm::distance(chart.point(chart.from_face(uv)), line.points[i]), edge.band + 1e-9);
        const dvec2 p = sample_in_chart(store, chart, store.coedges[c], line.at[i], line.points[i]);
        EXPECT_LE(glm::distance(chart.point(p), line.points[i]), edge.band + 1e-9);
        EXPECT_LT(glm::distance(p, chart.from_face(uv)), 1e-3);
      }
    }
  }
}

}  // namespace
}  // namespace trimray::tess
