// The kernel of the closed forms: the same bits on every instruction set and from every lane, and its angles.
// First of all includes, and again in angle-inl.h: see there. Here for the scalar twin alone.
#include "core/base/simd.h"

#include "core/trace/closed_form_lanes.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <cmath>
#include <cstring>
#include <random>

#include "core/trace/angle-inl.h"

namespace trimray::trace {
namespace {

namespace lanes = trimray::HWY_NAMESPACE;
using nurbs::SurfaceKind;

constexpr double kPi = 3.14159265358979323846;

double one_lane(lanes::Lanes x) {
  double out[8];
  lanes::store(x, out);
  return out[0];
}

double ulps(double got, long double want) {
  const double near = static_cast<double>(want);
  const double ulp = std::nextafter(std::fabs(near), kInf) - std::fabs(near);
  return static_cast<double>(std::fabs(static_cast<long double>(got) - want)) / ulp;
}

TEST(Angle, IsWithinTwoUlpOfTheArcTangent) {
  std::mt19937_64 rng(41);
  std::uniform_real_distribution<double> unit(-1.0, 1.0), exponent(-40.0, 40.0);
  const long double two_pi = 2 * std::acos(-1.0L);
  double worst_turn = 0.0, worst_latitude = 0.0;
  for (int k = 0; k < 500000; ++k) {
    double y = unit(rng), x = unit(rng);
    if (k % 3 == 0) y = std::ldexp(y, static_cast<int>(exponent(rng)));
    if (k % 7 == 0) x = std::ldexp(y, k % 2 ? 0 : 1) * (1.0 + 1e-13 * unit(rng));
    long double want = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    const double v = one_lane(lanes::latitude(lanes::Lanes(y), lanes::Lanes(std::fabs(x))));
    worst_latitude =
        std::max(worst_latitude,
                 ulps(v, std::atan2(static_cast<long double>(y), std::fabs(static_cast<long double>(x)))));
    const double u = one_lane(lanes::turn_angle(lanes::Lanes(y), lanes::Lanes(x)));
    ASSERT_TRUE(u >= 0.0 && u < 2 * kPi) << y << ' ' << x;
    if (want < 0) want += two_pi;
    if (want < 2 * kPi - 1e-15) worst_turn = std::max(worst_turn, ulps(u, want));
  }
  EXPECT_LE(worst_turn, 2.0);
  EXPECT_LE(worst_latitude, 2.0);
}

TEST(Angle, OfTheAxes) {
  const auto turn = [](double y, double x) {
    return one_lane(lanes::turn_angle(lanes::Lanes(y), lanes::Lanes(x)));
  };
  EXPECT_EQ(turn(0.0, 0.0), 0.0);
  EXPECT_EQ(turn(0.0, 3.0), 0.0);
  EXPECT_EQ(turn(-0.0, 3.0), 0.0);
  EXPECT_EQ(turn(2.0, 0.0), kPi / 2);
  EXPECT_EQ(turn(0.0, -1.0), kPi);
  EXPECT_EQ(turn(-1.0, 0.0), 3 * (kPi / 2));
  EXPECT_EQ(turn(-1e-30, 1.0), std::nextafter(2 * kPi, 0.0));
  EXPECT_EQ(one_lane(lanes::latitude(lanes::Lanes(-2.0), lanes::Lanes(0.0))), -kPi / 2);
}

nurbs::Surface surface(SurfaceKind kind, double r1, double angle, dvec3 location) {
  nurbs::Surface s;
  s.kind = kind, s.r1 = r1, s.semi_angle = angle, s.location = location;
  s.z_axis = glm::normalize(dvec3(1, 2, 3));
  s.x_axis = glm::normalize(glm::cross(s.z_axis, dvec3(0, 0, 1)));
  s.y_axis = glm::cross(s.z_axis, s.x_axis);
  return s;
}

struct Shape {
  const char* name;
  ClosedForm form;
};

std::vector<Shape> shapes() {
  std::vector<Shape> all;
  for (const dvec3 at : {dvec3(0.3, -0.2, 0.7), dvec3(1e4, -1e4, 5e3)}) {
    const auto add = [&](const char* name, SurfaceKind kind, double r1, double a, Box2 uv) {
      all.push_back({name, make_closed_form(surface(kind, r1, a, at), uv, 1e-6)});
    };
    add("plane", SurfaceKind::kPlane, 0, 0, {{-3, -2}, {2, 4}});
    add("cylinder", SurfaceKind::kCylinder, 2, 0, {{0.5, -3}, {2 * kPi, 3}});
    add("cone", SurfaceKind::kCone, 2, 0.4, {{-1, -3}, {3, 3}});
    add("cone through its apex", SurfaceKind::kCone, 1, 0.6, {{0, -4}, {2 * kPi, 3}});
    add("sphere", SurfaceKind::kSphere, 3, 0, {{0, -kPi / 2}, {5, kPi / 2}});
  }
  return all;
}

// Through points of the surface, across it or along it, beside it by 1e-1 ... 1e-16, from near and far.
RayLanes rays_at(std::mt19937_64& rng, const ClosedForm& form, bool grazing) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> normal;
  RayLanes rays = {};
  rays.active = 0xff;
  for (int i = 0; i < kLanes; ++i) {
    const dvec2 uv = form.uv.lower + form.uv.extent() * dvec2(unit(rng), unit(rng));
    const dvec3 n = closed_form_normal(form, uv);
    dvec3 p = closed_form_point(form, uv), d(normal(rng), normal(rng), normal(rng));
    if (grazing) {
      d -= glm::dot(d, n) * n;
      p += n * (std::pow(10.0, -1.0 - 15.0 * unit(rng)) * (unit(rng) < 0.5 ? -1.0 : 1.0));
    }
    d = unit(rng) < 0.01 ? form.z : glm::normalize(d);
    const dvec3 o = p - d * std::pow(10.0, 5.0 * unit(rng));
    rays.org_x[i] = o.x, rays.org_y[i] = o.y, rays.org_z[i] = o.z;
    rays.dir_x[i] = d.x, rays.dir_y[i] = d.y, rays.dir_z[i] = d.z;
  }
  return rays;
}

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Do the lanes of `which` say the same in a and b?
void expect_same(const ClosedRootLanes& a, const ClosedRootLanes& b, std::uint32_t which, const char* name) {
  for (int k = 0; k < kLaneRoots; ++k) {
    ASSERT_EQ(a.found[k] & which, b.found[k] & which) << name;
    for (int i = 0; i < kLanes; ++i)
      if (a.found[k] & which & (1u << i)) {
        ASSERT_TRUE(same(a.t[k][i], b.t[k][i]) && same(a.u[k][i], b.u[k][i]) && same(a.v[k][i], b.v[k][i]) &&
                    same(a.normal_x[k][i], b.normal_x[k][i]) && same(a.normal_y[k][i], b.normal_y[k][i]) &&
                    same(a.normal_z[k][i], b.normal_z[k][i]))
            << name << " root " << k;
      }
  }
}

// A batch of rays, because to choose an instruction set takes a while.
struct Batch {
  static constexpr int kCount = 16000;
  double tmin[kLanes], tmax[kLanes];
  std::vector<RayLanes> rays;

  Batch(std::mt19937_64& rng, const ClosedForm& form) {
    for (int i = 0; i < kLanes; ++i) tmin[i] = i == 3 ? 50.0 : 0.0, tmax[i] = i == 5 ? 500.0 : kInf;
    for (int k = 0; k < kCount; ++k) rays.push_back(rays_at(rng, form, k % 2 == 1));
  }

  std::vector<ClosedRootLanes> roots(const ClosedForm& form, std::int64_t target) const {
    std::vector<ClosedRootLanes> out(rays.size());
    hwy::SetSupportedTargetsForTest(target);
    for (std::size_t k = 0; k < rays.size(); ++k)
      closed_form_lanes(form, rays[k], form.uv, tmin, tmax, out[k]);
    hwy::SetSupportedTargetsForTest(0);
    return out;
  }
};

TEST(ClosedFormLanes, EveryInstructionSetGivesTheSameBits) {
  std::mt19937_64 rng(42);
  for (const Shape& shape : shapes()) {
    const Batch batch(rng, shape.form);
    const std::vector<ClosedRootLanes> best = batch.roots(shape.form, 0);
    int found = 0;
    for (const ClosedRootLanes& roots : best)
      for (int i = 0; i < kLanes; ++i) found += static_cast<int>((roots.found[0] | roots.found[1]) >> i & 1u);
    EXPECT_GT(found, Batch::kCount * 3) << shape.name;
    for (const std::int64_t target : {std::int64_t{HWY_AVX2}, std::int64_t{HWY_STATIC_TARGET}}) {
      if ((hwy::SupportedTargets() & target) == 0) continue;
      const std::vector<ClosedRootLanes> other = batch.roots(shape.form, target);
      for (std::size_t k = 0; k < best.size(); ++k) expect_same(best[k], other[k], 0xff, shape.name);
    }
  }
}

TEST(ClosedFormLanes, ALanesBitsDoNotDependOnTheOthers) {
  std::mt19937_64 rng(44);
  for (const Shape& shape : shapes())
    for (int k = 0; k < 2000; ++k) {
      RayLanes rays = rays_at(rng, shape.form, k % 2 == 1);
      const double tmin[kLanes] = {}, tmax[kLanes] = {kInf, 50.0, kInf, 1e3, kInf, kInf, kInf, kInf};
      ClosedRootLanes all;
      closed_form_lanes(shape.form, rays, shape.form.uv, tmin, tmax, all);
      for (int i = 0; i < kLanes; ++i) {
        rays.active = 1u << i;
        ClosedRootLanes alone;
        closed_form_lanes(shape.form, rays, shape.form.uv, tmin, tmax, alone);
        ASSERT_EQ((alone.found[0] | alone.found[1]) & ~rays.active, 0u);
        expect_same(all, alone, rays.active, shape.name);
        ClosedRoot roots[kMaxClosedRoots];
        const int count = closed_form_roots(shape.form, {rays.org_x[i], rays.org_y[i], rays.org_z[i]},
                                            {rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]}, shape.form.uv,
                                            tmin[i], tmax[i], roots);
        int expected = 0;
        for (int j = 0; j < kLaneRoots; ++j)
          if (all.found[j] >> i & 1u) {
            ASSERT_LT(expected, count);
            EXPECT_TRUE(same(roots[expected].t, all.t[j][i]) && same(roots[expected].uv.x, all.u[j][i]) &&
                        same(roots[expected].uv.y, all.v[j][i]) &&
                        same(roots[expected].normal.x, all.normal_x[j][i]));
            ++expected;
          }
        EXPECT_EQ(count, expected);
      }
    }
}

// Normals taken from the point against those of its parameters.
TEST(ClosedFormLanes, NormalsAreThoseOfTheParameters) {
  std::mt19937_64 rng(43);
  for (const Shape& shape : shapes()) {
    double worst = 0.0;
    for (int k = 0; k < 5000; ++k) {
      const RayLanes rays = rays_at(rng, shape.form, false);
      const double tmin[kLanes] = {}, tmax[kLanes] = {kInf, kInf, kInf, kInf, kInf, kInf, kInf, kInf};
      ClosedRootLanes all;
      closed_form_lanes(shape.form, rays, shape.form.uv, tmin, tmax, all);
      for (int j = 0; j < kLaneRoots; ++j)
        for (int i = 0; i < kLanes; ++i) {
          if (!(all.found[j] >> i & 1u)) continue;
          const dvec3 n(all.normal_x[j][i], all.normal_y[j][i], all.normal_z[j][i]);
          EXPECT_NEAR(glm::length(n), 1.0, 1e-15);
          worst =
              std::max(worst, glm::length(n - closed_form_normal(shape.form, {all.u[j][i], all.v[j][i]})));
        }
    }
    EXPECT_LT(worst, 1e-14) << shape.name;
  }
}

}  // namespace
}  // namespace trimray::trace
