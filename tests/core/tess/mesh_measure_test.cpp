#include "core/tess/mesh_measure.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/nurbs/make_store.h"
#include "core/tess/edge_measure.h"
#include "tests/core/tess/face_grid.h"

namespace trimray::tess {
namespace {

constexpr double kPi = std::numbers::pi;

nurbs::NurbsStore store_of(const nurbs::FaceSpec& spec) { return nurbs::make_store(std::span(&spec, 1)); }

// Chords of a circle: the largest gap is the rise of the arc, r (1 - cos(pi / n)).
TEST(MeasureDeviation, TubeIsOffByTheRiseOfItsArcs) {
  for (const bool as_nurbs : {false, true}) {
    nurbs::FaceSpec spec = nurbs::tube({{5, 6, 7}, {1, 1, 0}, {1, 0, 2}}, 2.0, 0.0, 3.0);
    if (as_nurbs) spec.surface = nurbs::as_nurbs(spec.surface);
    const nurbs::NurbsStore store = store_of(spec);
    for (const int n : {3, 8, 50}) {
      const TriMesh mesh = face_grid(store, n, 2, true);
      const double rise = 2.0 * (1.0 - std::cos(kPi / n));
      const DeviationMeasure m = measure_deviation(store, mesh);
      for (const double d : m.to_surface) EXPECT_NEAR(d, rise, 1e-9);
      for (const double d : m.from_surface) EXPECT_NEAR(d, rise, 1e-9);
    }
  }
}

TEST(MeasureDeviation, VerticesOffTheSurfaceAreSeen) {
  const nurbs::NurbsStore store = store_of(nurbs::full_sphere({}, 1.0));
  TriMesh mesh = face_grid(store, 60, 30, true);
  const double usual = *std::max_element(mesh.deviation.begin(), mesh.deviation.end());
  EXPECT_EQ(usual, 0.0);
  mesh.vertices[387] *= 1.25;
  mesh.deviation.assign(mesh.triangles.size(), 1.0);
  const auto measured = measure_deviation(store, mesh).to_surface;
  int far = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const bool moved = std::count(t.begin(), t.end(), 387) > 0;
    far += moved;
    if (moved) {
      EXPECT_NEAR(measured[i], 0.25, 1e-12);
    } else {
      EXPECT_LT(measured[i], 0.01) << i << " " << t[0] << " " << t[1] << " " << t[2];
    }
  }
  EXPECT_EQ(far, 6);
}

TEST(MeasureDeviation, WrongUvIsSeen) {
  const nurbs::NurbsStore store = store_of(nurbs::full_sphere({}, 1.0));
  TriMesh mesh = face_grid(store, 60, 30, true);
  for (dvec2& uv : mesh.corner_uv[751]) uv.x += 0.3;
  mesh.deviation.assign(mesh.triangles.size(), 0.01);
  EXPECT_LT(measure_deviation(store, mesh).to_surface[751], 0.01) << "the triangle is where it was";
  EXPECT_LT(measure_deviation(store, mesh).from_surface[751], 0.01) << "another triangle is there";
  mesh.deviation.assign(mesh.triangles.size(), 1.0);
  EXPECT_GT(measure_deviation(store, mesh).from_surface[751], 0.1) << "its own, where that is near enough";
}

TEST(MeasureDeviation, AChoiceOfTrianglesIsMeasuredAlikeByAnyNumberOfThreads) {
  const nurbs::NurbsStore store = store_of(nurbs::full_torus({}, 3.0, 1.0));
  TriMesh mesh = face_grid(store, 60, 40, true, true);
  mesh.deviation.assign(mesh.triangles.size(), 1.0);
  const auto all = measure_deviation(store, mesh).to_surface;
  const auto some = measure_deviation(store, mesh, {6, 500, 3, 2}).to_surface;
  const auto one = measure_deviation(store, mesh, {6, 500, 3, 1}).to_surface;
  int measured = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(std::isnan(some[i]), std::isnan(one[i]));
    if (std::isnan(some[i])) continue;
    ++measured;
    EXPECT_EQ(some[i], all[i]);
    EXPECT_EQ(one[i], all[i]);
  }
  EXPECT_NEAR(measured, 500, 100);
}

TEST(MeasureDeviation, AMeshOfAnotherStoreIsRefused) {
  const nurbs::NurbsStore store = store_of(nurbs::full_torus({}, 3.0, 1.0));
  TriMesh mesh = tetrahedron();
  mesh.face[0] = 7;
  EXPECT_THROW(measure_deviation(store, mesh), ArgumentError);
  mesh.face[0] = 0, mesh.triangles[1][2] = 44;
  EXPECT_THROW(measure_deviation(store, mesh), ArgumentError);
}

TEST(MeasureCover, AreaInUvAndTrianglesTurnedOver) {
  nurbs::FaceSpec spec = nurbs::tube({}, 1.0, 0.0, 3.0);
  for (const bool reversed : {false, true}) {
    spec.reversed = reversed;
    const nurbs::NurbsStore store = store_of(spec);
    TriMesh mesh = face_grid(store, 10, 3, true);
    EXPECT_NEAR(measure_cover(store, mesh)[0].uv_area, (reversed ? -1 : 1) * 6.0 * kPi, 1e-12);
    EXPECT_EQ(measure_cover(store, mesh)[0].turned_over, 0);
    std::swap(mesh.corner_uv[5][0], mesh.corner_uv[5][1]);
    EXPECT_EQ(measure_cover(store, mesh)[0].turned_over, 1);
  }
}

double worst(const EdgeMeasure& m, double BorderSide::*field) {
  double w = 0.0;
  for (const BorderSide& s : m.sides) w = std::max(w, s.*field);
  return w;
}

TEST(MeasureEdges, RimsAndSeamOfATubeAreFound) {
  for (const int n : {3, 24}) {
    const nurbs::NurbsStore store = store_of(nurbs::tube({}, 2.0, 0.0, 3.0));
    const TriMesh mesh = face_grid(store, n, 4, true);
    const EdgeMeasure m = measure_edges(store, mesh);
    int open = 0;
    for (const BorderSide& s : m.sides) {
      EXPECT_GE(s.edge, 0);
      open += s.open;
    }
    EXPECT_EQ(open, 2 * n);
    EXPECT_EQ(m.sides.size(), 2u * n + 8u) << "two rims, and the seam from both sides";
    const double rise = 2.0 * (1.0 - std::cos(kPi / n));
    EXPECT_NEAR(worst(m, &BorderSide::edge_to_side), rise, 1e-3 * rise);
    EXPECT_NEAR(worst(m, &BorderSide::side_to_edge), rise, 0.01 * rise);
    for (std::size_t e = 0; e < store.edges.size(); ++e)
      EXPECT_NEAR(m.missing[e], 0.0, 1e-9) << n << " " << e;
    EXPECT_NEAR(*std::max_element(m.length.begin(), m.length.end()), 4.0 * kPi, 0.1);
  }
}

TEST(MeasureEdges, PolesAreInside) {
  const nurbs::NurbsStore store = store_of(nurbs::full_sphere({}, 1.0));
  TriMesh mesh = face_grid(store, 16, 8, true);
  // Every pole one vertex; the triangles that lose their area there go.
  TriMesh closed = mesh;
  closed.triangles.clear(), closed.corner_uv.clear(), closed.face.clear(), closed.deviation.clear();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    auto t = mesh.triangles[i];
    for (std::int32_t& v : t) v = v % 9 == 0 ? 0 : v % 9 == 8 ? 8 : v;
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    add_triangle(closed, t[0], t[1], t[2]);
    closed.corner_uv.back() = mesh.corner_uv[i];
  }
  const EdgeMeasure m = measure_edges(store, closed);
  EXPECT_EQ(m.sides.size(), 16u) << "the seam from both sides";
  for (const BorderSide& s : m.sides) {
    EXPECT_GE(s.edge, 0);
    EXPECT_FALSE(s.open);
  }
  for (const double gap : m.missing) EXPECT_NEAR(gap, 0.0, 1e-9);
}

TEST(MeasureEdges, AHoleInAMeshLiesOnNoEdge) {
  const nurbs::NurbsStore store = store_of(nurbs::full_torus({}, 3.0, 1.0));
  TriMesh mesh = face_grid(store, 16, 8, true, true);
  const auto off_edges = [&] {
    int count = 0;
    for (const BorderSide& s : measure_edges(store, mesh).sides) count += s.edge < 0;
    return count;
  };
  EXPECT_EQ(off_edges(), 0);
  mesh.triangles.erase(mesh.triangles.begin() + 77);
  mesh.corner_uv.erase(mesh.corner_uv.begin() + 77);
  mesh.face.pop_back(), mesh.deviation.pop_back();
  EXPECT_EQ(off_edges(), 3);
}

TEST(MeasureEdges, WhatAMeshLeavesOutOfAnEdgeIsSeen) {
  const nurbs::NurbsStore store = store_of(nurbs::tube({}, 2.0, 0.0, 3.0));
  TriMesh mesh = face_grid(store, 24, 1, true);
  mesh.triangles.resize(24), mesh.corner_uv.resize(24), mesh.face.resize(24), mesh.deviation.resize(24);
  const EdgeMeasure m = measure_edges(store, mesh);
  EXPECT_EQ(std::count_if(m.missing.begin(), m.missing.end(), [](double x) { return x > 1.0; }), 3)
      << "half of both rims and one side of the seam";
}

}  // namespace
}  // namespace trimray::tess
