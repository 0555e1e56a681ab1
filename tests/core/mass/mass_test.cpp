// Areas, volumes and moments against closed forms, and the laws they have to keep.
#include "core/mass/mass.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/nurbs/trim_bezier.h"
#include "tests/core/tess/trimmed_stores.h"

namespace trimray::mass {
namespace {

using nurbs::NurbsStore;

constexpr double kPi = std::numbers::pi;

// Relative to `expected`, and within what is said of it.
void expect_near(double value, double error, double expected, double relative = 2e-14) {
  EXPECT_NEAR(value, expected, relative * std::abs(expected));
  EXPECT_LE(std::abs(value - expected), error);
  EXPECT_LE(error, 1e-12 * std::abs(expected));
}

NurbsStore single(const nurbs::FaceSpec& face) { return nurbs::make_store(std::span(&face, 1)); }

const nurbs::Frame3 kTilted{{3, -2, 5}, {1, 1, 0}, {0.5, -0.5, 2}};

TEST(Mass, SphereHasItsClosedForm) {
  for (const bool as_spline : {false, true}) {
    nurbs::FaceSpec face = nurbs::full_sphere(kTilted, 2.0);
    if (as_spline) face.surface = nurbs::as_nurbs(face.surface);
    const MassProperties m = measure_mass(single(face));
    expect_near(m.area, m.area_error, 16.0 * kPi);
    expect_near(m.moments.volume, m.moments.volume_error, 32.0 / 3.0 * kPi);
    const Body body = body_of(m.moments);
    EXPECT_LE(glm::distance(body.centroid, kTilted.location), 1e-13);
    const double inertia = 0.4 * m.moments.volume * 4.0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(body.inertia[i][j], i == j ? inertia : 0.0, 1e-12 * inertia);
    EXPECT_TRUE(m.left_out.empty());
  }
}

TEST(Mass, TorusHasItsClosedForm) {
  const double major = 3.0, minor = 1.25;
  for (const bool as_spline : {false, true}) {
    nurbs::FaceSpec face = nurbs::full_torus({}, major, minor);
    if (as_spline) face.surface = nurbs::as_nurbs(face.surface);
    const MassProperties m = measure_mass(single(face));
    expect_near(m.area, m.area_error, 4.0 * kPi * kPi * major * minor);
    const double volume = 2.0 * kPi * kPi * major * minor * minor;
    expect_near(m.moments.volume, m.moments.volume_error, volume);
    const Body body = body_of(m.moments);
    const double axial = volume * (major * major + 0.75 * minor * minor);
    const double other = volume * (0.5 * major * major + 0.625 * minor * minor);
    EXPECT_NEAR(body.inertia[2][2], axial, 1e-12 * axial);
    EXPECT_NEAR(body.inertia[0][0], other, 1e-12 * axial);
    EXPECT_NEAR(body.inertia[1][1], other, 1e-12 * axial);
  }
}

TEST(Mass, TorusThroughItsAxisHasPolesInside) {
  // The outer part alone, and all of it: |r1 + r2 cos v| has kinks at the poles.
  nurbs::FaceSpec face = nurbs::full_torus({}, 1.0, 2.0);
  const double pole = std::acos(-0.5);
  const MassProperties m = measure_mass(single(face));
  const double outer = 4.0 * kPi * 2.0 * (pole + 2.0 * std::sin(pole)),
               inner = -4.0 * kPi * 2.0 * (kPi - pole - 2.0 * std::sin(pole));
  expect_near(m.area, m.area_error, outer + inner);
}

TEST(Mass, ConeEndsAtItsApex) {
  nurbs::FaceSpec face{nurbs::make_cone({}, 1.0, kPi / 6.0), {{0.0, -2.0}, {2.0 * kPi, 2.0}}};
  const MassProperties m = measure_mass(single(face));
  expect_near(m.area, m.area_error, kPi * 2.0 * 4.0);  // from the apex at v = -2: radius 2 at slant 4
  EXPECT_EQ(m.moments.volume, 0.0);                    // open
  EXPECT_TRUE(std::isnan(m.shell_volume[0]));
}

TEST(Mass, NaturalFacesAreTheirWholeDomain) {
  nurbs::FaceSpec face = nurbs::full_sphere({}, 1.0);
  face.natural = true;
  const MassProperties m = measure_mass(single(face));
  expect_near(m.area, m.area_error, 4.0 * kPi);
}

TEST(Mass, PlateWithHolesWhicheverWayTheyRun) {
  const double area = 100.0 - kPi * (1.5 * 1.5 + 2.0 * 0.5) - 1.0 + 0.25;
  const std::vector<nurbs::TrimLoop> holes = {nurbs::ellipse({2.5, 2.5}, 1.5, 1.5),
                                              nurbs::ellipse({7, 6}, 2.0, 0.5),
                                              nurbs::polygon({{1, 8}, {2, 8}, {2, 9}, {1, 9}})};
  const auto island = nurbs::polygon({{1.25, 8.25}, {1.75, 8.25}, {1.75, 8.75}, {1.25, 8.75}});
  for (int turns = 0; turns < 8; ++turns) {
    std::vector<nurbs::TrimLoop> loops = {nurbs::polygon({{0, 0}, {10, 0}, {10, 10}, {0, 10}}), island};
    for (std::size_t k = 0; k < holes.size(); ++k)
      loops.push_back(turns >> k & 1 ? nurbs::turned(holes[k]) : holes[k]);
    const MassProperties m = measure_mass(nurbs::trimmed_face(nurbs::make_plane(kTilted), loops));
    expect_near(m.area, m.area_error, area);
  }
}

TEST(Mass, PrismOfALensHasVolumeAndCentroid) {
  const std::vector<nurbs::TrimLoop> loops = {nurbs::ellipse({4, -3}, 2.0, 1.0),
                                              nurbs::turned(nurbs::ellipse({4.5, -3}, 0.5, 0.5))};
  const MassProperties m = measure_mass(nurbs::prism(loops, 3.0));
  const double big = 2.0 * kPi, small = 0.25 * kPi;
  expect_near(m.moments.volume, m.moments.volume_error, 3.0 * (big - small));
  const Body body = body_of(m.moments);
  EXPECT_NEAR(body.centroid.x, (4.0 * big - 4.5 * small) / (big - small), 1e-13);
  EXPECT_NEAR(body.centroid.y, -3.0, 1e-13);
  EXPECT_NEAR(body.centroid.z, 1.5, 1e-13);
}

TEST(Mass, ShellsInsideOutHaveNegativeVolume) {
  nurbs::FaceSpec face = nurbs::full_sphere({}, 1.0);
  face.reversed = true;
  const MassProperties m = measure_mass(single(face));
  expect_near(m.moments.volume, m.moments.volume_error, -4.0 / 3.0 * kPi);
  EXPECT_EQ(m.shell_volume[0], m.moments.volume);
}

TEST(Mass, InstancesMayBeMirroredScaledAndStretched) {
  NurbsStore store = single(nurbs::full_sphere({{1, 0, 0}}, 1.0));
  store.instances[0].placement.linear = dmat3(-2, 0, 0, 0, 2, 0, 0, 0, 2);
  store.instances[0].placement.translation = {0, 5, 0};
  MassProperties m = measure_mass(store);
  expect_near(m.area, m.area_error, 16.0 * kPi);
  expect_near(m.moments.volume, m.moments.volume_error, 32.0 / 3.0 * kPi);
  EXPECT_LE(glm::distance(body_of(m.moments).centroid, dvec3(-2, 5, 0)), 1e-13);

  // A spheroid, prolate: its area is 2 pi a^2 (1 + c / (a e) asin e).
  store.instances[0].placement.linear = dmat3(1, 0, 0, 0, 1, 0, 0, 0, 2);
  store.instances.push_back(store.instances[0]);
  store.instances[1].placement = {};
  m = measure_mass(store);
  const double e = std::sqrt(0.75), spheroid = 2.0 * kPi * (1.0 + 2.0 / e * std::asin(e));
  expect_near(m.area, m.area_error, spheroid + 4.0 * kPi);
  expect_near(m.moments.volume, m.moments.volume_error, 4.0 * kPi);
  EXPECT_NEAR(m.faces[0].value[kArea], 4.0 * kPi, 1e-13);
}

TEST(Mass, TrianglesAreExact) {
  NurbsStore store = single(nurbs::full_sphere({}, 1.0));
  store.surfaces.emplace_back().kind = nurbs::SurfaceKind::kMesh;
  store.mesh_vertices = {{1, 1, 1}, {2, 1, 1}, {1, 3, 1}, {1, 1, 4}};
  store.mesh_triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  nurbs::Face& face = store.faces[0];
  face = {};
  face.surface = 1, face.prototype = 0, face.shell = 0, face.triangles = {0, 4};
  face.uv_box = {{0, 0}, {1, 1}};
  store.shells[0].closed = true;
  const MassProperties m = measure_mass(store);
  EXPECT_NEAR(m.moments.volume, 1.0, 1e-15);
  EXPECT_LE(glm::distance(body_of(m.moments).centroid, dvec3(1.25, 1.5, 1.75)), 1e-14);
  const dmat3 inertia = body_of(m.moments).inertia;
  EXPECT_NEAR(inertia[0][0], 3.0 / 80.0 * (4.0 + 9.0), 1e-14);
  EXPECT_NEAR(inertia[0][1], 2.0 / 80.0, 1e-14);
}

// A wavy spline surface with knots of its own, rational or not.
nurbs::SurfaceForm wavy(bool rational) {
  std::mt19937 words(7);
  std::uniform_real_distribution<double> noise(-0.4, 0.4), weight(0.5, 2.0);
  const std::vector<double> u{0, 0, 0, 0, 1, 2.5, 4, 4, 4, 4}, v{0, 0, 0, 1, 1.5, 3, 3, 3};
  std::vector<dvec4> ctrl;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 5; ++j) {
      const double w = rational ? weight(words) : 1.0;
      ctrl.push_back(w * dvec4(i + noise(words), 1.3 * j + noise(words), 2.0 * noise(words), 1.0));
    }
  return nurbs::make_bspline(3, 2, u, v, ctrl);
}

const nurbs::TrimLoop kOuter = nurbs::polygon({{0.3, 0.2}, {3.9, 0.4}, {3.6, 2.8}, {0.5, 2.5}});
const nurbs::TrimLoop kHole = nurbs::turned(nurbs::ellipse({2.2, 1.4}, 1.2, 0.7));

TEST(Mass, KnotsAndCutsChangeNothing) {
  for (const bool rational : {false, true}) {
    nurbs::SurfaceForm form = wavy(rational);
    const MassProperties a = measure_mass(nurbs::trimmed_face(form, {kOuter, kHole}));
    // A knot in the middle of a span, by cutting off and a part of the hole by halving its pieces.
    nurbs::SurfaceForm finer = form;
    nurbs::respan_surface(finer, {{0.1, 0.1}, {3.95, 2.9}});
    nurbs::TrimLoop halves;
    for (const nurbs::TrimPiece& p : kHole) {
      nurbs::TrimPiece left(p.size()), right(p.size());
      nurbs::split_bezier<dvec3>(p, 0.3, left.data(), right.data());
      halves.push_back(left), halves.push_back(right);
    }
    const MassProperties b = measure_mass(nurbs::trimmed_face(finer, {kOuter, halves}));
    expect_near(b.area, b.area_error, a.area, 1e-13);
    EXPECT_LE(std::abs(a.area - b.area), a.area_error + b.area_error);
    // The whole is the sum of its parts, cut along a slanted line.
    const auto low = nurbs::polygon({{0.3, 0.2}, {3.9, 0.4}, {3.7, 2.0}, {0.4, 1.35}}),
               high = nurbs::polygon({{0.4, 1.35}, {3.7, 2.0}, {3.6, 2.8}, {0.5, 2.5}});
    double sum = 0.0;
    for (const auto& part : {low, high}) sum += measure_mass(nurbs::trimmed_face(form, {part})).area;
    const double whole =
        measure_mass(
            nurbs::trimmed_face(
                form,
                {nurbs::polygon({{0.3, 0.2}, {3.9, 0.4}, {3.7, 2.0}, {3.6, 2.8}, {0.5, 2.5}, {0.4, 1.35}})}))
            .area;
    EXPECT_NEAR(sum, whole, 1e-13 * whole);
  }
}

TEST(Mass, FacesMayEndOnKnots) {
  const nurbs::SurfaceForm form = wavy(true);
  const auto area = [&](double u0, double u1, double v0, double v1) {
    return measure_mass(nurbs::trimmed_face(form, {nurbs::polygon({{u0, v0}, {u1, v0}, {u1, v1}, {u0, v1}})}))
        .area;
  };
  const double us[] = {0, 1, 2.5, 4}, vs[] = {0, 1, 1.5, 3};
  double sum = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum += area(us[i], us[i + 1], vs[j], vs[j + 1]);
  EXPECT_NEAR(sum, area(0, 4, 0, 3), 1e-13 * sum);
}

TEST(Mass, SplineAreaIsThatOfManyTriangles) {
  // Midpoints of a fine grid converge with the square of its step; Richardson takes that term away.
  const nurbs::SurfaceForm form = wavy(true);
  const NurbsStore store = nurbs::trimmed_face(form, {nurbs::polygon({{0, 0}, {4, 0}, {4, 3}, {0, 3}})});
  const auto sum = [&](int n) {
    double area = 0.0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const auto p = nurbs::evaluate(nurbs::view(form), {4.0 * (i + 0.5) / n, 3.0 * (j + 0.5) / n});
        area += glm::length(glm::cross(p.du, p.dv)) * 12.0 / n / n;
      }
    return area;
  };
  const double exact = (4.0 * sum(960) - sum(480)) / 3.0;  // knots lie on the grid
  EXPECT_NEAR(measure_mass(store).area, exact, 1e-8 * exact);
}

TEST(Mass, OffsetOfASphereIsASphere) {
  nurbs::FaceSpec face = nurbs::full_sphere({}, 2.0);
  face.surface = nurbs::as_offset(nurbs::as_nurbs(face.surface), 0.5);
  const MassProperties m = measure_mass(single(face));
  EXPECT_NEAR(m.area, 25.0 * kPi, 1e-10 * m.area);
  EXPECT_LE(std::abs(m.area - 25.0 * kPi), std::max(m.area_error, 1e-10 * m.area));
}

TEST(Mass, NumberOfThreadsChangesNoBit) {
  std::vector<nurbs::FaceSpec> faces;
  for (int i = 0; i < 40; ++i) faces.push_back(nurbs::full_torus({{9.0 * i, 1, 2}}, 3.0, 1.0 + 0.01 * i));
  const NurbsStore store = nurbs::make_store(faces);
  const MassProperties a = measure_mass(store, 1), b = measure_mass(store, 4);
  EXPECT_EQ(a.area, b.area);
  EXPECT_EQ(a.area_error, b.area_error);
  EXPECT_EQ(a.moments.volume, b.moments.volume);
  EXPECT_EQ(a.moments.second, b.moments.second);
  for (std::size_t f = 0; f < a.faces.size(); ++f) EXPECT_EQ(a.faces[f].value, b.faces[f].value);
}

TEST(Mass, FacesThatCannotBeDrawnAreNamed) {
  const nurbs::FaceSpec faces[] = {nurbs::full_sphere({}, 1.0), nurbs::full_sphere({{5, 0, 0}}, 1.0)};
  NurbsStore store = nurbs::make_store(faces);
  store.faces[1].status = nurbs::FaceStatus::kBadTrim;
  const MassProperties m = measure_mass(store);
  EXPECT_EQ(m.left_out, std::vector<std::int32_t>{1});
  EXPECT_TRUE(std::isnan(m.faces[1].value[kArea]));
  EXPECT_TRUE(std::isnan(m.shell_volume[1]));
  expect_near(m.area, m.area_error, 4.0 * kPi);
  expect_near(m.moments.volume, m.moments.volume_error, 4.0 / 3.0 * kPi);
}

}  // namespace
}  // namespace trimray::mass
