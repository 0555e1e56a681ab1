// What must hold of the mesh of any face: watertight as far as the model is, all of the face covered once, as
// near as proven, the same bytes for any number of threads.
#include <algorithm>
#include <cstring>

#include <gtest/gtest.h>

#include "core/tess/edge_measure.h"
#include "core/tess/mesh_check.h"
#include "core/tess/mesh_measure.h"
#include "core/tess/tessellate.h"
#include "tests/core/tess/random_loops.h"

namespace trimray::tess {
namespace {

using nurbs::NurbsStore;

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(static_cast<const void*>(a.data()), b.data(), a.size() * sizeof(T)) == 0);
}

struct Expected {
  bool closed = false;  // the whole mesh is
  bool valid = true;    // no face may need other means
  double uv_area = -1.0;
  double uv_slack = 0.0;
};

// `label` says how to make the store again.
TriMesh expect_good(const NurbsStore& store, double deviation, const Expected& expected,
                    const std::string& label) {
  SCOPED_TRACE(label);
  nurbs::validate(store);
  const Tessellation one = tessellate(store, 0, UniformTolerance(deviation), {.threads = 1});
  const Tessellation two = tessellate(store, 0, UniformTolerance(deviation), {.threads = 2});
  const TriMesh& mesh = one.mesh;
  EXPECT_TRUE(same_bytes(mesh.vertices, two.mesh.vertices) &&
              same_bytes(mesh.triangles, two.mesh.triangles) &&
              same_bytes(mesh.corner_uv, two.mesh.corner_uv) &&
              same_bytes(mesh.deviation, two.mesh.deviation) && same_bytes(mesh.face, two.mesh.face));
  check_mesh_fits(store, mesh);
  EXPECT_FALSE(mesh.triangles.empty());
  const MeshCheck c = check(mesh);
  if (expected.closed) {
    EXPECT_EQ(c.open_edges, 0);
    EXPECT_GT(c.volume, 0.0);
  }
  EXPECT_EQ(c.non_manifold_edges, 0);
  EXPECT_EQ(c.degenerate_triangles, 0);
  if (expected.valid) {
    for (const TessIssue& issue : one.issues) ADD_FAILURE() << "face " << issue.face << ": " << issue.reason;
  }
  if (!one.issues.empty()) return mesh;

  Box3 box;
  for (const dvec3& p : mesh.vertices) box.add(p);
  const double rounding =
      1e-12 * box.diagonal() + 1e-15 * glm::length(glm::abs(box.lower) + glm::abs(box.upper));
  TriMesh loose = mesh;  // other triangles are asked about the surface where this one is too far
  for (double& d : loose.deviation) d = std::max(d, deviation);
  const DeviationMeasure m = measure_deviation(store, loose, {.subdivisions = 4, .most_triangles = 600});
  int far = 0, over = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    over += !(mesh.deviation[i] <= deviation);
    if (!(m.to_surface[i] > mesh.deviation[i] * (1.0 + 1e-9) + rounding)) continue;
    if (far++ == 0)
      ADD_FAILURE() << "triangle " << i << " of face " << mesh.face[i] << ": " << m.to_surface[i]
                    << " from the surface, proven " << mesh.deviation[i] << ", asked " << deviation;
  }
  EXPECT_EQ(over, 0) << "triangles whose proven deviation is over the requested one";
  EXPECT_EQ(far, 0) << "triangles farther from the surface than proven";

  const EdgeMeasure edges = measure_edges(store, mesh);
  int off = 0, away = 0;
  for (const BorderSide& s : edges.sides) {
    off += s.edge < 0;
    away += s.edge >= 0 && std::max(s.edge_to_side, s.side_to_edge) > deviation * (1.0 + 1e-9) + rounding;
  }
  EXPECT_EQ(off, 0) << "sides where the mesh ends and the face does not";
  EXPECT_EQ(away, 0) << "sides too far from their edge";
  for (std::size_t e = 0; e < edges.missing.size(); ++e)
    EXPECT_LE(edges.missing[e], 2.0 * deviation + 1e-6 * edges.length[e]) << "edge " << e << " is left out";

  double area = 0.0;
  std::int64_t turned = 0;
  for (const FaceCover& f : measure_cover(store, mesh)) turned += f.turned_over;
  EXPECT_EQ(turned, 0) << "triangles upside down in uv";
  area = std::abs(measure_cover(store, mesh)[0].uv_area);
  if (expected.uv_area >= 0.0) {
    EXPECT_NEAR(area, expected.uv_area, expected.uv_slack);
  }
  return mesh;
}

double area_of(const std::vector<nurbs::TrimLoop>& loops) {
  double area = 0.0;
  for (const auto& loop : loops) area += nurbs::loop_area(loop);
  return area;
}

double rim_of(const std::vector<nurbs::TrimLoop>& loops) {
  double length = 0.0;
  for (const auto& loop : loops)
    for (const auto& piece : loop)
      for (int i = 0; i < 64; ++i)
        length += glm::distance(nurbs::piece_uv(piece, i / 64.0), nurbs::piece_uv(piece, (i + 1) / 64.0));
  return length;
}

TEST(TessellateRandom, PrismsOverGentleLoopsAreClosed) {
  for (int seed = 0; seed < 80; ++seed) {
    nurbs::Random random(seed);
    const auto loops = nurbs::gentle_loops(random, static_cast<int>(random() % 8));
    const double deviation = std::pow(10.0, nurbs::uniform(random, -4.0, -1.0));
    const NurbsStore store = nurbs::prism(loops, nurbs::uniform(random, 0.01, 2.0));
    expect_good(store, deviation, {true, true, area_of(loops), 1e-4 + deviation * rim_of(loops)},
                "prism over gentle_loops, seed " + std::to_string(seed));
  }
}

// Loops that touch or nearly do so. Whatever comes of it is a mesh of reasonable size; where the loops bound
// a region at all it is closed, though it may have triangles without height.
TEST(TessellateRandom, PrismsOverNastyLoopsEndAndKeepTheirVolume) {
  for (int seed = 0; seed < 200; ++seed) {
    nurbs::Random random(seed);
    const auto loops = nurbs::nasty_loops(random, seed);
    double size = 0.0;
    for (const auto& loop : loops)
      for (const auto& piece : loop)
        size = std::max(size, glm::distance(nurbs::piece_uv(piece, 0.0), nurbs::piece_uv(loops[0][0], 0.0)));
    const double deviation = size * std::pow(10.0, nurbs::uniform(random, -4.0, -1.0));
    const NurbsStore store = nurbs::prism(loops, size);
    SCOPED_TRACE("prism over nasty_loops, seed " + std::to_string(seed));
    const Tessellation t = tessellate(store, 0, UniformTolerance(deviation));
    check_mesh_fits(store, t.mesh);
    EXPECT_LT(t.mesh.triangles.size(), 20000u);
    const MeshCheck c = check(t.mesh);
    const int kind = seed % 10;
    // Touching circles, shared sides, spikes outwards, corner to corner.
    if (kind == 0 || kind == 3 || kind == 5 || kind == 8) {
      EXPECT_TRUE(t.issues.empty());
      EXPECT_EQ(c.open_edges, 0);
    }
    const double exact = size * std::abs(area_of(loops));
    if (t.issues.empty()) {
      EXPECT_NEAR(c.volume, exact, deviation * c.area + 1e-6 * exact);
    }
  }
}

TEST(TessellateRandom, GentleLoopsOnRandomPatches) {
  for (int seed = 0; seed < 60; ++seed) {
    nurbs::Random random(seed);
    const int du = 1 + static_cast<int>(random() % 4), dv = 1 + static_cast<int>(random() % 4);
    const auto loops = nurbs::gentle_loops(random, static_cast<int>(random() % 6));
    const auto form =
        nurbs::random_patch(random, du, dv, nurbs::uniform(random, 0.0, 2.0), random() % 2 == 0);
    const double deviation = std::pow(10.0, nurbs::uniform(random, -3.0, 0.0));
    expect_good(nurbs::trimmed_face(form, loops, random() % 2 == 0), deviation, {},
                "gentle_loops on random_patch, seed " + std::to_string(seed));
  }
}

TEST(TessellateRandom, GentleLoopsOnAnalyticSurfaces) {
  for (int seed = 0; seed < 60; ++seed) {
    nurbs::Random random(seed);
    auto loops = nurbs::gentle_loops(random, static_cast<int>(random() % 6));
    const nurbs::Frame3 frame{
        {nurbs::uniform(random, -5, 5), 2, 3}, {1, 0, 0}, {0, nurbs::uniform(random, -1, 1), 1}};
    const nurbs::SurfaceForm forms[] = {nurbs::make_cylinder(frame, 2.0),
                                        nurbs::make_cone(frame, 2.0, 0.4),
                                        nurbs::make_sphere(frame, 2.0),
                                        nurbs::make_torus(frame, 3.0, 1.0),
                                        nurbs::as_nurbs(nurbs::make_torus(frame, 3.0, 1.0)),
                                        nurbs::as_nurbs(nurbs::make_sphere(frame, 2.0))};
    const auto& form = forms[seed % 6];
    // u in (1, 5), v in (-0.9, 1.3): clear of seams and poles.
    for (auto& loop : loops)
      for (auto& piece : loop)
        for (dvec3& h : piece) h = dvec3(h.z + 4.0 * h.x, -0.9 * h.z + 2.2 * h.y, h.z);
    if (seed % 6 == 3 || seed % 6 == 4)
      for (auto& loop : loops)
        for (auto& piece : loop)
          for (dvec3& h : piece) h.y += h.z;
    const double deviation = std::pow(10.0, nurbs::uniform(random, -3.5, -0.5));
    expect_good(nurbs::trimmed_face(form, loops, random() % 2 == 0), deviation, {},
                "gentle_loops on an analytic surface, seed " + std::to_string(seed));
  }
}

TEST(TessellateRandom, WholeSpheresToriAndTubes) {
  for (const bool as_nurbs : {false, true}) {
    for (const double deviation : {0.5, 0.1, 0.01}) {
      for (const bool reversed : {false, true}) {
        const nurbs::Frame3 frame{{1, 2, 3}, {1, 1, 0}, {0.3, -0.2, 1}};
        const auto make = [&](nurbs::FaceSpec spec) {
          if (as_nurbs) spec.surface = nurbs::as_nurbs(spec.surface);
          spec.reversed = reversed;
          return nurbs::make_store(std::span(&spec, 1));
        };
        const std::string label = std::to_string(deviation) + (as_nurbs ? " as NURBS" : "");
        const auto sphere =
            expect_good(make(nurbs::full_sphere(frame, 2.0)), deviation, {}, "sphere " + label);
        EXPECT_EQ(check(sphere).open_edges, 0);
        const auto torus =
            expect_good(make(nurbs::full_torus(frame, 3.0, 1.0)), deviation, {}, "torus " + label);
        EXPECT_EQ(check(torus).open_edges, 0);
        expect_good(make(nurbs::tube(frame, 2.0, -1.0, 4.0)), deviation, {}, "tube " + label);
        EXPECT_EQ(check(sphere).volume > 0.0, !reversed);
      }
    }
  }
}

// A face without any loop: its natural domain.
TEST(TessellateRandom, NaturalFacesAreClosed) {
  for (nurbs::FaceSpec spec : {nurbs::full_sphere({}, 2.0), nurbs::full_torus({}, 3.0, 1.0)}) {
    spec.natural = true;
    const NurbsStore store = nurbs::make_store(std::span(&spec, 1));
    const Tessellation t = tessellate(store, 0, UniformTolerance(0.01));
    EXPECT_TRUE(t.issues.empty());
    EXPECT_EQ(check(t.mesh).open_edges, 0);
    EXPECT_EQ(check(t.mesh).degenerate_triangles, 0);
  }
}

}  // namespace
}  // namespace trimray::tess
