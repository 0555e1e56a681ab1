// Proven distances of triangles against distances measured at many of their points.
#include "core/tess/triangle_bound.h"

#include <memory>

#include <gtest/gtest.h>

#include "core/tess/mesh_measure.h"
#include "tests/core/tess/random_surfaces.h"

namespace trimray::tess {
namespace {

using nurbs::Random;

// Triangles of one untrimmed face; the mesh holds them side by side.
struct Soup {
  explicit Soup(nurbs::RandomSurface s) : surface(std::move(s)), chart(surface.store, surface.surface()) {
    if (needs_tree(surface.surface().kind))
      tree = std::make_unique<CurvatureTree>(surface.store, chart, surface.box, tolerance, kInf);
    nurbs::Face face;
    face.surface = 0, face.prototype = 0;
    face.uv_box = {chart.to_face(surface.box.lower), chart.to_face(surface.box.upper)};
    surface.store.faces.push_back(face);
  }

  void add(const dvec2 (&p)[3]) {
    dvec3 s[3];
    std::array<dvec2, 3> uv;
    std::array<std::int32_t, 3> corner;
    for (int k = 0; k < 3; ++k) {
      s[k] = chart.point(p[k]), uv[k] = chart.to_face(p[k]);
      corner[k] = static_cast<std::int32_t>(mesh.vertices.size());
      mesh.vertices.push_back(s[k]);
    }
    const TriangleBound bound = bound_triangle(chart, tree.get(), p, s);
    mesh.triangles.push_back(corner), mesh.corner_uv.push_back(uv), mesh.face.push_back(0);
    mesh.deviation.push_back(bound.deviation);
    sides.push_back({bound.side[0], bound.side[1], bound.side[2]});
  }

  // Triangles measured to be farther than proven. A bound of kInf promises nothing.
  int violations(int subdivisions) const {
    TriMesh known = mesh;
    for (double& d : known.deviation) d = std::min(d, 1e3);
    const DeviationMeasure m =
        measure_deviation(surface.store, known, {.subdivisions = subdivisions, .threads = 1});
    int far = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      if (!(m.to_surface[i] > mesh.deviation[i] * (1.0 + 1e-9) + 1e-12)) continue;
      if (far++ == 0) {
        const auto& uv = mesh.corner_uv[i];
        ADD_FAILURE() << surface.name << ", triangle " << i << " (" << uv[0].x << ", " << uv[0].y << ") ("
                      << uv[1].x << ", " << uv[1].y << ") (" << uv[2].x << ", " << uv[2].y << "): measured "
                      << m.to_surface[i] << ", proven " << mesh.deviation[i];
      }
    }
    return far;
  }

  UniformTolerance tolerance{0.01};
  nurbs::RandomSurface surface;
  Chart chart;
  std::unique_ptr<CurvatureTree> tree;
  TriMesh mesh;
  std::vector<std::array<double, 3>> sides;
};

// Of all sizes and shapes, slivers among them.
void add_random(Random& random, int count, Soup& soup) {
  for (int k = 0; k < count; ++k) {
    const Box2 box = nurbs::box_in(random, soup.surface.box);
    dvec2 p[3] = {nurbs::uv_in(random, box), nurbs::uv_in(random, box), nurbs::uv_in(random, box)};
    if (k % 5 == 4)
      p[2] = p[0] + nurbs::uniform(random, 0.1, 0.9) * (p[1] - p[0]) +
             std::pow(10.0, nurbs::uniform(random, -6.0, -1.0)) * (p[2] - p[0]);
    for (dvec2& q : p) q = glm::clamp(q, soup.surface.box.lower, soup.surface.box.upper);
    soup.add(p);
  }
}

TEST(TriangleBound, HoldsOnClosedForms) {
  Random random(11);
  for (int form = 0; form < 10; ++form)
    for (int k = 0; k < 6; ++k) {
      Soup soup(nurbs::random_closed_form(random, form));
      add_random(random, 60, soup);
      EXPECT_EQ(soup.violations(6), 0);
    }
}

TEST(TriangleBound, HoldsOnPatches) {
  Random random(12);
  for (int k = 0; k < 60; ++k) {
    const int p = 1 + static_cast<int>(random() % 4), q = 1 + static_cast<int>(random() % 4);
    const bool rational = k % 2 == 0;
    Soup soup(nurbs::in_store(nurbs::random_patch(random, p, q, nurbs::uniform(random, 0.0, 2.0), rational),
                              {{0, 0}, {1, 1}}, std::to_string(p) + " x " + std::to_string(q)));
    add_random(random, 60, soup);
    EXPECT_EQ(soup.violations(8), 0);
  }
}

TEST(TriangleBound, HoldsAcrossKnotsAndKinks) {
  Random random(13);
  for (int k = 0; k < 40; ++k) {
    Soup soup(nurbs::random_bspline(random, k % 2 == 0, k % 4 < 2));
    add_random(random, 60, soup);
    EXPECT_EQ(soup.violations(8), 0);
  }
}

TEST(TriangleBound, IsZeroOnPlanes) {
  Random random(14);
  Soup soup(nurbs::random_closed_form(random, 0));
  add_random(random, 20, soup);
  for (const double d : soup.mesh.deviation) EXPECT_EQ(d, 0.0);
}

// On small triangles the bound is not far above the truth; farthest where the surface is a saddle, on which
// some triangles hardly deviate.
TEST(TriangleBound, IsTightOnSmallTriangles) {
  Random random(15);
  for (int form = 0; form < 12; ++form) {
    Soup soup(form < 10 ? nurbs::random_closed_form(random, form)
                        : nurbs::in_store(nurbs::random_patch(random, 3, 3, 1.0, form == 11),
                                          {{0, 0}, {1, 1}}, "cubic"));
    if (form % 5 == 0 && form < 10) continue;
    for (int k = 0; k < 100; ++k) {
      const dvec2 size = 0.02 * soup.surface.box.extent(), p = nurbs::uv_in(random, soup.surface.box);
      const double a = nurbs::uniform(random, 0.0, 6.28);
      dvec2 corners[3];
      for (int i = 0; i < 3; ++i)
        corners[i] = glm::clamp(p + size * dvec2(std::cos(a + 2.1 * i), std::sin(a + 2.1 * i)),
                                soup.surface.box.lower, soup.surface.box.upper);
      soup.add(corners);
    }
    const DeviationMeasure m =
        measure_deviation(soup.surface.store, soup.mesh, {.subdivisions = 8, .threads = 1});
    std::vector<double> ratio;
    for (std::size_t i = 0; i < m.to_surface.size(); ++i)
      ratio.push_back(soup.mesh.deviation[i] / m.to_surface[i]);
    std::nth_element(ratio.begin(), ratio.begin() + ratio.size() / 2, ratio.end());
    EXPECT_LT(ratio[ratio.size() / 2], form % 5 == 4 || form >= 10 ? 3.0 : 1.8) << soup.surface.name;
  }
}

// Half a turn is as far as a chord can say anything of its arc.
TEST(TriangleBound, NothingIsProvenWhereAWeightIsNotPositive) {
  Random random(77);
  auto form = nurbs::random_patch(random, 3, 3, 1.0, true);
  form.ctrl_h[5].w = -0.5;
  const auto s = nurbs::in_store(form, {{0, 0}, {1, 1}}, "a weight below 0");
  const Chart chart(s.store, s.surface());
  const UniformTolerance tolerance(1.0);
  const CurvatureTree tree(s.store, chart, s.box, tolerance, kInf);
  const dvec2 p[3] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  const dvec3 at[3] = {chart.point(p[0]), chart.point(p[1]), chart.point(p[2])};
  EXPECT_EQ(bound_triangle(chart, &tree, p, at).deviation, kInf);
}

TEST(TriangleBound, TrianglesThatReachAroundAreNotProven) {
  const auto cylinder = nurbs::in_store(nurbs::make_cylinder({}, 2.0), {{0, -1}, {6.2, 1}}, "cylinder");
  Soup soup(cylinder);
  soup.add({{0.0, 0.0}, {3.3, 0.0}, {1.0, 1.0}});
  EXPECT_EQ(soup.mesh.deviation[0], kInf);
  soup.add({{0.0, 0.0}, {1.0, 0.0}, {0.5, 1.0}});
  EXPECT_NEAR(soup.mesh.deviation[1], 2.0 * (1.0 - std::cos(0.5)), 1e-12);
  EXPECT_NEAR(soup.sides[1][0], 2.0 * (1.0 - std::cos(0.5)), 1e-12);
}

}  // namespace
}  // namespace trimray::tess
