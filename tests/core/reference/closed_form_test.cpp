// The reference tracer against the polynomials that a ray's parameter satisfies on quadrics, tori and graphs.
#include <gtest/gtest.h>

#include <random>

#include "core/nurbs/make_store.h"
#include "core/reference/reference.h"
#include "tests/core/reference/polynomial.h"

namespace trimray::reference_test {
namespace {

using nurbs::FaceSpec;
using nurbs::Frame3;
using trace::Hit;
using trace::Ray;

constexpr double kPi = 3.14159265358979323846;

struct Random {
  std::mt19937_64 engine{7};
  double in(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  dvec3 direction() {
    dvec3 d;
    do d = {in(-1, 1), in(-1, 1), in(-1, 1)};
    while (glm::length(d) > 1.0 || glm::length(d) < 0.1);
    return glm::normalize(d);
  }
};

struct Shape {
  const char* name;
  nurbs::SurfaceForm (*surface)(const Frame3&);
  Box2 uv_box;
  double z0, z1;  // of the hits that count, in the frame
  // The implicit function along local coordinates x, y, z, each linear in t.
  Polynomial (*implicit)(const Polynomial& x, const Polynomial& y, const Polynomial& z);
};

const Box2 kTurnBy(double v0, double v1) { return {{0.0, v0}, {2 * kPi, v1}}; }

const Shape kShapes[] = {
    {"sphere", [](const Frame3& f) { return nurbs::make_sphere(f, 10.0); }, kTurnBy(-kPi / 2, kPi / 2), -11,
     11,
     [](const Polynomial& x, const Polynomial& y, const Polynomial& z) {
       return add(add(x * x, y * y), add(z * z, {100.0L}, -1));
     }},
    {"cylinder", [](const Frame3& f) { return nurbs::make_cylinder(f, 8.0); }, kTurnBy(-5, 9), -5, 9,
     [](const Polynomial& x, const Polynomial& y, const Polynomial&) {
       return add(add(x * x, y * y), {64.0L}, -1);
     }},
    {"cone", [](const Frame3& f) { return nurbs::make_cone(f, 4.0, 0.5); }, kTurnBy(-5, 9),
     -5 * std::cos(0.5), 9 * std::cos(0.5),
     [](const Polynomial& x, const Polynomial& y, const Polynomial& z) {
       const Polynomial r = add({4.0L}, z, std::tan(0.5L));
       return add(add(x * x, y * y), r * r, -1);
     }},
    {"torus", [](const Frame3& f) { return nurbs::make_torus(f, 7.0, 3.0); }, kTurnBy(0, 2 * kPi), -4, 4,
     [](const Polynomial& x, const Polynomial& y, const Polynomial& z) {
       const Polynomial q = add(x * x, y * y), s = add(add(q, z * z), {40.0L});  // 49 - 9
       return add(s * s, q, -4 * 49.0L);
     }},
};

// The roots of the implicit function on the part of the shape that the face covers.
std::vector<long double> truth(const Shape& shape, const Frame3& f, const Ray& ray) {
  using Vec = glm::vec<3, long double>;
  const Vec z = glm::normalize(Vec(f.z_axis)),
            x = glm::normalize(Vec(f.x_axis) - glm::dot(Vec(f.x_axis), z) * z), y = glm::cross(z, x);
  const Vec o = Vec(ray.org) - Vec(f.location), d(ray.dir);
  const long double unit = glm::length(d);
  const long double shift = -glm::dot(o, d) / unit / unit;  // roots about the nearest point keep their digits
  const Vec near = o + shift * d;
  auto linear = [&](const Vec& axis) { return Polynomial{glm::dot(axis, near), glm::dot(axis, d)}; };
  std::vector<long double> out;
  for (long double t : roots(shape.implicit(linear(x), linear(y), linear(z)), -100 / unit, 100 / unit)) {
    const long double height = value(linear(z), t);
    if (height >= shape.z0 && height <= shape.z1) out.push_back(t + shift);
  }
  return out;
}

Frame3 frame(int k) {
  if (k == 0) return {};
  return {k == 1 ? dvec3(3, -2, 1) : dvec3(7e4, -6e4, 4e4), glm::normalize(dvec3(1, 2, -1)),
          glm::normalize(dvec3(2, -0.3, 1))};
}

nurbs::NurbsStore store_of(const Shape& shape, const Frame3& f, bool plain) {
  nurbs::SurfaceForm form = shape.surface(f);
  FaceSpec spec{plain ? nurbs::as_nurbs(form) : form, shape.uv_box};
  return nurbs::make_store(std::span<const FaceSpec>(&spec, 1));
}

void expect_truth(const Shape& shape, const Frame3& f, const nurbs::NurbsStore& store, const Ray& ray,
                  double accuracy) {
  std::vector<Hit> hits;
  reference::cast_all(store, ray, hits);
  const std::vector<long double> expected = truth(shape, f, ray);
  ASSERT_EQ(hits.size(), expected.size()) << shape.name;
  for (std::size_t k = 0; k < hits.size(); ++k) {
    EXPECT_NEAR(hits[k].t, double(expected[k]), accuracy) << shape.name;
    EXPECT_EQ(hits[k].face, 0);
    EXPECT_NEAR(glm::length(hits[k].normal), 1.0, 1e-12);
    if (k > 0 || expected.size() == 1) continue;
    if (shape.z0 < -9) {
      EXPECT_LT(glm::dot(hits[k].normal, ray.dir), 0.0);  // a closed shape is entered first
    }
  }
}

class ClosedForm : public testing::TestWithParam<int> {};

TEST_P(ClosedForm, findsAllRootsOfRandomRays) {
  const Shape& shape = kShapes[GetParam()];
  Random random;
  for (int place = 0; place < 3; ++place)
    for (bool plain : {false, true}) {
      const Frame3 f = frame(place);
      const nurbs::NurbsStore store = store_of(shape, f, plain);
      for (int k = 0; k < 60; ++k) {
        const dvec3 d = random.direction();
        const dvec3 aim = f.location + 9.0 * random.direction();
        expect_truth(shape, f, store, {aim - 40.0 * d, d}, place == 2 ? 1e-9 : 2e-12);
      }
    }
}

// Rays that pass a silhouette at 1e-3 ... 1e-7 of the size: two close roots or none. Aimed from a point of
// the surface along a tangent, then moved along the normal.
TEST_P(ClosedForm, tellsGrazingRaysApart) {
  const Shape& shape = kShapes[GetParam()];
  Random random;
  const Frame3 f = frame(1);
  const nurbs::NurbsStore store = store_of(shape, f, true);
  int two = 0;
  for (int k = 0; k < 120; ++k) {
    const dvec2 uv(random.in(0.1, 6.1), random.in(0.7 * shape.uv_box.lower.y, 0.7 * shape.uv_box.upper.y));
    const nurbs::SurfacePoint s = nurbs::evaluate(store, store.surfaces[0], uv);
    const dvec3 n = glm::normalize(glm::cross(s.du, s.dv));
    const double turn = random.in(0, 6.3);
    const dvec3 d =
        glm::normalize(std::cos(turn) * glm::normalize(s.du) + std::sin(turn) * glm::normalize(s.dv));
    const double gap = std::pow(10.0, random.in(-6, -2)) * (k % 2 ? 1 : -1);
    const Ray ray{s.p + gap * n - 30.0 * d, d};
    two += truth(shape, f, ray).size() >= 2;
    // A root's error grows as the line turns tangent: rounding / sqrt(2 gap / R).
    expect_truth(shape, f, store, ray, 1e-13 / std::sqrt(std::abs(gap)) * 10);
  }
  EXPECT_GT(two, 30);
}

INSTANTIATE_TEST_SUITE_P(Shapes, ClosedForm, testing::Range(0, 4));

TEST(Sphere, isHitTwiceThroughPolesAndSeam) {
  for (bool natural : {false, true})
    for (int place = 0; place < 3; ++place) {
      const Frame3 f = frame(place);
      FaceSpec spec = nurbs::full_sphere(f, 10.0);
      spec.natural = natural;
      const nurbs::NurbsStore store = nurbs::make_store(std::span<const FaceSpec>(&spec, 1));
      const dvec3 z = glm::normalize(f.z_axis), x = glm::normalize(f.x_axis - glm::dot(f.x_axis, z) * z);
      Random random;
      for (int k = 0; k < 40; ++k) {
        // Points of the seam, every eighth one a pole.
        const double v = k % 8 == 0 ? kPi / 2 : k % 8 == 1 ? -kPi / 2 : random.in(-1.5, 1.5);
        const dvec3 p = f.location + 10.0 * (std::cos(v) * x + std::sin(v) * z);
        dvec3 d = k < 8 ? (k % 2 ? -z : z) : random.direction();
        if (std::abs(glm::dot(d, p - f.location)) < 1.0) continue;
        const Ray ray{p - 50.0 * d, d};
        std::vector<Hit> hits;
        reference::cast_all(store, ray, hits);
        ASSERT_EQ(hits.size(), 2u) << "v = " << v << " natural " << natural << " place " << place << " k "
                                   << k;
        const std::vector<long double> expected = truth(kShapes[0], f, ray);
        for (int i = 0; i < 2; ++i) EXPECT_NEAR(hits[i].t, double(expected[i]), place == 2 ? 1e-8 : 1e-9);
      }
    }
}

TEST(Plane, givesTheFoot) {
  FaceSpec spec{nurbs::make_plane({{0, 0, 5}}), {{-3, -2}, {4, 2}}};
  const nurbs::NurbsStore store = nurbs::make_store(std::span<const FaceSpec>(&spec, 1));
  const dvec3 d = glm::normalize(dvec3(0.3, -0.2, -1));
  Hit hit;
  const Ray rays[] = {{dvec3(1, 1, 5) - 7.0 * d, d},
                      {dvec3(1, 1, 5) - 7.0 * d, 2.0 * d},
                      {dvec3(4.1, 1, 5) - 7.0 * d, d},
                      {dvec3(0, 0, 5), dvec3(1, 0, 0)}};
  reference::cast(store, {rays, 1}, {&hit, 1});
  EXPECT_NEAR(hit.t, 7.0, 1e-14);
  EXPECT_NEAR(hit.uv_face.x, 1.0, 1e-14);
  EXPECT_NEAR(hit.uv_face.y, 1.0, 1e-14);
  EXPECT_NEAR(hit.normal.z, 1.0, 1e-15);
  reference::cast(store, {rays + 1, 1}, {&hit, 1});
  EXPECT_NEAR(hit.t, 3.5, 1e-14);  // in multiples of the direction's length
  reference::cast(store, {rays + 2, 1}, {&hit, 1});
  EXPECT_EQ(hit.face, kNoFace);
  reference::cast(store, {rays + 3, 1}, {&hit, 1});  // edge-on
  EXPECT_EQ(hit.face, kNoFace);
}

TEST(Offset, ofSphereAndTorusIsAnotherOne) {
  Random random;
  for (double offset : {2.5, -1.0}) {
    FaceSpec spec{nurbs::as_offset(nurbs::make_sphere({}, 10.0), offset),
                  {{0.0, -kPi / 2}, {2 * kPi, kPi / 2}}};
    spec.natural = true;
    const nurbs::NurbsStore store = nurbs::make_store(std::span<const FaceSpec>(&spec, 1));
    const long double r = 10.0L + offset;
    std::vector<Ray> rays;
    for (int k = 0; k < 100; ++k) {
      const dvec3 d = random.direction(), o = 0.8 * double(r) * random.direction() - 40.0 * d;
      rays.push_back({o, d});
    }
    std::vector<Hit> first(rays.size()), all;
    reference::cast(store, rays, first);
    for (std::size_t k = 0; k < rays.size(); ++k) {
      const long double b = glm::dot(rays[k].org, rays[k].dir),
                        c = glm::dot(rays[k].org, rays[k].org) - r * r;
      EXPECT_NEAR(first[k].t, double(-b - std::sqrt(b * b - c)), 1e-11);
      if (k % 10 != 0) continue;
      reference::cast_all(store, rays[k], all);
      ASSERT_EQ(all.size(), 2u);
      EXPECT_EQ(all[0].t, first[k].t);
      EXPECT_NEAR(all[1].t, double(-b + std::sqrt(b * b - c)), 1e-11);
    }
  }
}

// A bicubic graph z = f(x, y) over linear x, y: along a ray a polynomial of degree 6.
TEST(Bezier, graphHasAllRootsOfItsPolynomial) {
  Random random;
  double z[4][4];
  std::vector<dvec4> ctrl;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) ctrl.emplace_back(i / 3.0, j / 3.0, z[i][j] = random.in(-4, 4), 1.0);
  FaceSpec spec{nurbs::make_bezier(3, 3, ctrl), {{0, 0}, {1, 1}}};
  const nurbs::NurbsStore store = nurbs::make_store(std::span<const FaceSpec>(&spec, 1));
  int seen[7] = {};
  for (int k = 0; k < 1200; ++k) {
    const dvec3 a(random.in(0, 1), random.in(0, 1), random.in(-0.5, 0.5));
    const dvec3 d = glm::normalize(dvec3(random.in(-1, 1), random.in(-1, 1), random.in(-0.3, 0.3)));
    const Polynomial x = {a.x, d.x}, y = {a.y, d.y};
    auto bernstein = [](const Polynomial& s, int i) {
      const Polynomial r = add({1.0L}, s, -1);
      Polynomial b = {i == 1 || i == 2 ? 3.0L : 1.0L};
      for (int n = 0; n < 3; ++n) b = b * (n < i ? s : r);
      return b;
    };
    Polynomial g = {-a.z, -d.z};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) g = add(g, bernstein(x, i) * bernstein(y, j), z[i][j]);
    std::vector<double> expected;
    for (long double t : roots(g, -3, 3)) {
      const long double px = value(x, t), py = value(y, t);
      if (px >= 0 && px <= 1 && py >= 0 && py <= 1) expected.push_back(double(t) + 5);
    }
    std::vector<Hit> hits;
    reference::cast_all(store, {a - 5.0 * d, d}, hits);
    ASSERT_EQ(hits.size(), expected.size()) << k;
    ++seen[hits.size()];
    for (std::size_t i = 0; i < hits.size(); ++i) EXPECT_NEAR(hits[i].t, expected[i], 1e-11);
  }
  EXPECT_GT(seen[2], 10);
  EXPECT_GT(seen[3], 10);
}

TEST(Instances, moveRaysAndNormals) {
  FaceSpec spec = nurbs::full_sphere({}, 2.0);
  nurbs::NurbsStore store = nurbs::make_store(std::span<const FaceSpec>(&spec, 1));
  store.instances[0].placement.translation = {0, 0, 10};
  store.instances.push_back(store.instances[0]);
  store.instances[1].placement = {dmat3(3.0), {0, 0, -10}};  // three times as large
  store.instances[1].placement.linear[0] *= -1.0;            // and mirrored
  std::vector<Hit> hits;
  reference::cast_all(store, {{0.1, 0.2, 50}, {0, 0, -1}}, hits);
  ASSERT_EQ(hits.size(), 4u);
  const double small = std::sqrt(4 - 0.05), large = std::sqrt(36 - 0.05);
  const double expected[] = {40 - small, 40 + small, 60 - large, 60 + large};
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(hits[k].t, expected[k], 1e-12);
    EXPECT_EQ(hits[k].instance, k / 2);
    EXPECT_EQ(hits[k].normal.z > 0, k % 2 == 0);
  }
}

}  // namespace
}  // namespace trimray::reference_test
