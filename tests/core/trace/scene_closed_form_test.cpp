// First hits of whole scenes, native and as NURBS, from 26 sides, against roots computed here in long double
// by Bernstein subdivision of the implicit equation: no line of the tracer is shared.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/nurbs/make_store.h"
#include "core/trace/scene.h"

namespace trimray::trace {
namespace {

using nurbs::FaceSpec;
using nurbs::Frame3;
using nurbs::SurfaceKind;
using Real = long double;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kQuarter = std::numbers::pi / 2.0;

// Coefficients in t of the implicit equation along a ray, about the ray's point nearest to the frame's
// origin.
struct Line {
  Real o[3], d[3], t0;
};

Line local_line(const nurbs::Surface& s, dvec3 org, dvec3 dir) {
  Line line{};
  for (int a = 0; a < 3; ++a) line.t0 += (static_cast<Real>(s.location[a]) - org[a]) * dir[a];
  const dvec3 axes[3] = {s.x_axis, s.y_axis, s.z_axis};
  for (int k = 0; k < 3; ++k)
    for (int a = 0; a < 3; ++a) {
      line.o[k] += (static_cast<Real>(org[a]) - s.location[a] + line.t0 * dir[a]) * axes[k][a];
      line.d[k] += static_cast<Real>(dir[a]) * axes[k][a];
    }
  return line;
}

std::vector<Real> times(const std::vector<Real>& a, const std::vector<Real>& b) {
  std::vector<Real> c(a.size() + b.size() - 1, 0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) c[i + j] += a[i] * b[j];
  return c;
}

std::vector<Real> sum(std::vector<Real> a, const std::vector<Real>& b, Real factor) {
  a.resize(std::max(a.size(), b.size()), 0);
  for (std::size_t i = 0; i < b.size(); ++i) a[i] += factor * b[i];
  return a;
}

// grow: the radius that is meant, relative; tells rays that graze from rays that do not.
std::vector<Real> implicit(const nurbs::Surface& s, const Line& l, Real grow) {
  const std::vector<Real> x{l.o[0], l.d[0]}, y{l.o[1], l.d[1]}, z{l.o[2], l.d[2]};
  const std::vector<Real> rho2 = sum(times(x, x), times(y, y), 1);
  const Real r1 = s.r1, r2 = s.r2 * (1 + grow);
  switch (s.kind) {
    case SurfaceKind::kPlane:
      return z;
    case SurfaceKind::kCylinder:
      return sum(rho2, {1}, -r1 * r1 * (1 + grow) * (1 + grow));
    case SurfaceKind::kCone: {
      const std::vector<Real> w = sum({r1 * (1 + grow)}, z, std::tan(static_cast<Real>(s.semi_angle)));
      return sum(rho2, times(w, w), -1);
    }
    case SurfaceKind::kSphere:
      return sum(sum(rho2, times(z, z), 1), {1}, -r1 * r1 * (1 + grow) * (1 + grow));
    default: {
      const std::vector<Real> k = sum(sum(rho2, times(z, z), 1), {1}, r1 * r1 - r2 * r2);
      return sum(times(k, k), rho2, -4 * r1 * r1);
    }
  }
}

// Roots in [a, b] of a polynomial given by Bernstein coefficients there.
void isolate(const std::vector<Real>& bernstein, Real a, Real b, int depth, std::vector<Real>& roots) {
  int changes = 0;
  for (std::size_t i = 0; i + 1 < bernstein.size(); ++i)
    changes += (bernstein[i] < 0) != (bernstein[i + 1] < 0);
  if (changes == 0) return;
  if (depth == 0) return roots.push_back((a + b) / 2);
  std::vector<Real> left, right(bernstein.size()), work = bernstein;
  for (std::size_t n = work.size(); n > 0; --n) {
    left.push_back(work[0]);
    right[n - 1] = work[n - 1];
    for (std::size_t i = 0; i + 1 < n; ++i) work[i] = (work[i] + work[i + 1]) / 2;
  }
  isolate(left, a, (a + b) / 2, depth - 1, roots);
  isolate(right, (a + b) / 2, b, depth - 1, roots);
}

std::vector<Real> line_roots(const std::vector<Real>& power, Real reach) {
  // t = reach (2 s - 1), then power basis to Bernstein.
  const std::size_t n = power.size() - 1;
  std::vector<Real> shifted{0}, base{1};
  for (const Real c : power) shifted = sum(shifted, base, c), base = times(base, {-reach, 2 * reach});
  shifted.resize(n + 1, 0);
  const auto choose = [](std::size_t m, std::size_t k) {
    Real c = 1;
    for (std::size_t i = 0; i < k; ++i) c = c * (m - i) / (i + 1);
    return c;
  };
  std::vector<Real> bernstein(n + 1, 0), roots;
  for (std::size_t i = 0; i <= n; ++i)
    for (std::size_t k = 0; k <= i; ++k) bernstein[i] += choose(i, k) / choose(n, k) * shifted[k];
  isolate(bernstein, -reach, reach, 58, roots);
  return roots;
}

struct Expected {
  Real t = 1e30L;
  int face = -1;
};

// wider: by how much the uv box is enlarged, relative to its size.
void first_hit(const FaceSpec& spec, int face, dvec3 org, dvec3 dir, Real reach, Real grow, Real wider,
               Expected& best) {
  const nurbs::Surface& s = spec.surface.surface;
  const Line l = local_line(s, org, dir);
  for (const Real root : line_roots(implicit(s, l, grow), reach)) {
    Real p[3];
    for (int k = 0; k < 3; ++k) p[k] = l.o[k] + root * l.d[k];
    const Real rho = std::sqrt(p[0] * p[0] + p[1] * p[1]);
    Real u = std::atan2(p[1], p[0]), v = 0;
    switch (s.kind) {
      case SurfaceKind::kPlane:
        u = p[0], v = p[1];
        break;
      case SurfaceKind::kCylinder:
        v = p[2];
        break;
      case SurfaceKind::kCone:
        v = p[2] / std::cos(static_cast<Real>(s.semi_angle));
        if (s.r1 + p[2] * std::tan(static_cast<Real>(s.semi_angle)) < 0) u = std::atan2(-p[1], -p[0]);
        break;
      case SurfaceKind::kSphere:
        v = std::atan2(p[2], rho);
        break;
      default: {
        const Real outer = std::abs(std::hypot(rho - s.r1, p[2]) - s.r2),
                   inner = std::abs(std::hypot(rho + s.r1, p[2]) - s.r2);
        v = inner < outer ? std::atan2(p[2], -rho - s.r1) : std::atan2(p[2], rho - s.r1);
        if (inner < outer) u = std::atan2(-p[1], -p[0]);
        break;
      }
    }
    const auto in = [&](Real x, Real lower, Real upper, bool turns) {
      const Real grown = wider * (upper - lower);
      if (!turns) return x >= lower - grown && x <= upper + grown;
      if (upper - lower > kTurn - 1e-9) return true;
      for (int k = -2; k <= 2; ++k)
        if (x + k * static_cast<Real>(kTurn) >= lower - grown &&
            x + k * static_cast<Real>(kTurn) <= upper + grown)
          return true;
      return false;
    };
    if (!in(u, spec.uv_box.lower.x, spec.uv_box.upper.x, s.kind != SurfaceKind::kPlane)) continue;
    const bool whole_sphere =
        s.kind == SurfaceKind::kSphere && std::abs(std::abs(v) - kQuarter) < 1e-6 &&
        std::abs(v > 0 ? spec.uv_box.upper.y - kQuarter : spec.uv_box.lower.y + kQuarter) < 1e-9;
    if (!whole_sphere && !in(v, spec.uv_box.lower.y, spec.uv_box.upper.y, s.kind == SurfaceKind::kTorus))
      continue;
    const Real t = l.t0 + root;
    if (t >= 0 && t < best.t) best = {t, face};
  }
}

struct SceneCase {
  std::string name;
  std::vector<FaceSpec> faces;  // analytic
  dvec3 center{0.0};
  double diagonal = 1.0;
  bool as_nurbs = false;
};

std::vector<SceneCase> cases() {
  std::vector<SceneCase> all;
  for (const bool as_nurbs : {false, true}) {
    for (const bool far : {false, true}) {
      const dvec3 at = far ? dvec3(1e5, -1e5, 1e5) : dvec3(0.0);
      const Frame3 up{at, {1, 0, 0}, {0, 0, 1}}, tilted{at, {1, 0, 0}, glm::normalize(dvec3(1, -2, 2))};
      const Frame3& f = far ? tilted : up;
      const Frame3& g = far ? up : tilted;
      const auto add = [&](const char* name, std::vector<FaceSpec> faces, double diagonal) {
        all.push_back({std::string(name) + (as_nurbs ? "_nurbs" : "") + (far ? "_far" : ""), faces, at,
                       diagonal, as_nurbs});
      };
      const auto box = [](double u0, double v0, double u1, double v1) { return Box2{{u0, v0}, {u1, v1}}; };
      add("sphere", {nurbs::full_sphere(f, 2)}, 7);
      add("sphere_part", {{nurbs::make_sphere(g, 2), box(0.5, -0.8, 4.0, 1.1), false, false}}, 7);
      add("tube", {nurbs::tube(f, 1.5, -2, 2)}, 6);
      add("tube_sector", {{nurbs::make_cylinder(g, 1.5), box(1, -2, 5, 2), false, false}}, 6);
      add("cone", {{nurbs::make_cone(f, 1.0, 0.4), box(0, -1, kTurn, 2), false, false}}, 6);
      add("cone_apex",
          {{nurbs::make_cone(g, 1.0, 0.5), box(0, -1.0 / std::sin(0.5), kTurn, 1), false, false}}, 6);
      add("torus", {nurbs::full_torus(f, 2, 0.7)}, 7.8);
      add("torus_part", {{nurbs::make_torus(g, 2, 0.7), box(0.3, 1.0, 4.4, 5.5), false, false}}, 7.8);
      add("thin_torus", {nurbs::full_torus(g, 2, 0.05)}, 7);
      add("plane", {{nurbs::make_plane(g), box(-1, -2, 2, 1), false, false}}, 5);
      add("nested", {nurbs::full_sphere(f, 1), nurbs::full_torus(g, 2, 0.5), nurbs::tube(f, 2.7, -1, 1)}, 8);
      add("crossing",
          {{nurbs::make_plane(f), box(-2, -2, 2, 2), false, false},
           nurbs::tube(g, 1, -2, 2),
           {nurbs::make_cone(f, 0.8, -0.3), box(0, -2, kTurn, 2), true, false}},
          7);
      if (!as_nurbs) {
        add("horn_torus", {nurbs::full_torus(f, 1.5, 1.5)}, 9);
        add("spindle_torus", {nurbs::full_torus(g, 1, 1.6)}, 8);
      }
    }
  }
  return all;
}

void PrintTo(const SceneCase& c, std::ostream* out) { *out << c.name; }

class ClosedFormSceneTest : public testing::TestWithParam<SceneCase> {};

TEST_P(ClosedFormSceneTest, FirstHitsAreRightFromAllSides) {
  const SceneCase& c = GetParam();
  std::vector<FaceSpec> traced = c.faces;
  for (FaceSpec& face : traced)
    if (c.as_nurbs) face.surface = nurbs::as_nurbs(face.surface);
  const Scene scene(std::make_shared<nurbs::NurbsStore>(nurbs::make_store(traced)), 2);
  constexpr int kSize = 11;
  std::vector<Ray> rays;
  for (int view = 0; view < 27; ++view) {
    const dvec3 axis(view % 3 - 1, view / 3 % 3 - 1, view / 9 - 1);
    if (axis == dvec3(0.0)) continue;
    const dvec3 dir = glm::normalize(axis);
    const dvec3 right =
        glm::normalize(glm::cross(dir, std::abs(dir.z) > 0.9 ? dvec3(0, 1, 0) : dvec3(0, 0, 1)));
    const dvec3 up = glm::cross(right, dir);
    for (int i = 0; i < kSize; ++i)
      for (int j = 0; j < kSize; ++j) {
        const double x = (i - kSize / 2) * 0.8 / kSize, y = (j - kSize / 2) * 0.8 / kSize;
        rays.push_back({c.center + c.diagonal * (x * right + y * up - 2.0 * dir), dir, 0.0, kInf});
      }
  }
  std::vector<Hit> hits(rays.size());
  scene.cast(rays, hits, 2);
  int wrong = 0, judged = 0, hit_count = 0;
  double worst = 0.0;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    // A ray inside a plane meets it everywhere or nowhere.
    const bool edge_on = std::any_of(c.faces.begin(), c.faces.end(), [&](const FaceSpec& f) {
      const nurbs::Surface& s = f.surface.surface;
      return s.kind == SurfaceKind::kPlane && std::abs(glm::dot(s.z_axis, rays[k].dir)) < 1e-9 &&
             std::abs(glm::dot(s.z_axis, rays[k].org - s.location)) < 1e-9 * c.diagonal;
    });
    if (edge_on) continue;
    // A ray is judged when the answer does not hang on the last 1e-9 of radius or extent.
    Expected expected[3];
    const Real grow[3] = {0, 1e-9L, -1e-9L};
    for (int e = 0; e < 3; ++e)
      for (std::size_t f = 0; f < c.faces.size(); ++f)
        first_hit(c.faces[f], static_cast<int>(f), rays[k].org, rays[k].dir, 2 * c.diagonal, grow[e], grow[e],
                  expected[e]);
    if (expected[0].face != expected[1].face || expected[0].face != expected[2].face) continue;
    if (std::abs(expected[0].t - expected[1].t) > 1e-3 * c.diagonal && expected[0].face >= 0) continue;
    if (std::abs(expected[0].t - expected[2].t) > 1e-3 * c.diagonal && expected[0].face >= 0) continue;
    ++judged;
    if (hits[k].face != expected[0].face) {
      if (++wrong <= 5)
        ADD_FAILURE() << c.name << " ray " << k << " expected face " << expected[0].face << " t "
                      << static_cast<double>(expected[0].t) << " got " << hits[k].face << " t " << hits[k].t;
      continue;
    }
    if (hits[k].face < 0) continue;
    ++hit_count;
    const double error = static_cast<double>(std::abs(expected[0].t - hits[k].t));
    worst = std::max(worst, error);
    if (error > 1e-9 * c.diagonal && ++wrong <= 5)
      ADD_FAILURE() << c.name << " ray " << k << " t off by " << error << " at " << hits[k].t;
  }
  EXPECT_EQ(wrong, 0) << c.name;
  EXPECT_GT(judged, static_cast<int>(rays.size()) * 8 / 10) << c.name;
  EXPECT_GT(hit_count, 50) << c.name;
  RecordProperty("worst_dt_over_diagonal", std::to_string(worst / c.diagonal));
}

INSTANTIATE_TEST_SUITE_P(Scenes, ClosedFormSceneTest, testing::ValuesIn(cases()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace trimray::trace
