// Points, normals, boxes and lengths of the closed forms.
#include <algorithm>
#include <cmath>

#include "core/trace/closed_form_local.h"

namespace trimray::trace {

using nurbs::SurfaceKind;

namespace {

struct Interval {
  double lower, upper;
};

// Range of a cos t + b sin t over [t0, t1].
Interval sinusoid(double a, double b, double t0, double t1) {
  const double start = a * std::cos(t0) + b * std::sin(t0), stop = a * std::cos(t1) + b * std::sin(t1);
  Interval range{std::min(start, stop), std::max(start, stop)};
  const double amplitude = std::hypot(a, b), peak = std::atan2(b, a);
  const auto reaches = [&](double angle) { return angle + kTwoPi * std::ceil((t0 - angle) / kTwoPi) <= t1; };
  if (reaches(peak)) range.upper = amplitude;
  if (reaches(peak + 0.5 * kTwoPi)) range.lower = -amplitude;
  return range;
}

Interval join(Interval a, Interval b) { return {std::min(a.lower, b.lower), std::max(a.upper, b.upper)}; }

// Cylinder and cone: linear in v for every u, so the ends of the v range hold the extremes.
Interval ruled(double radius0, double radius1, double z0, double z1, Interval g, double axis) {
  const auto at = [&](double radius, double z) {
    const double p = radius * g.lower + z * axis, q = radius * g.upper + z * axis;
    return Interval{std::min(p, q), std::max(p, q)};
  };
  return join(at(radius0, z0), at(radius1, z1));
}

// Sphere (r1 = 0) and torus: (r1 + r2 cos v) g + r2 sin v axis is linear in g for every v.
Interval turned(double r1, double r2, Interval g, double axis, double v0, double v1) {
  const auto at = [&](double side) {
    const Interval s = sinusoid(r2 * side, r2 * axis, v0, v1);
    return Interval{s.lower + r1 * side, s.upper + r1 * side};
  };
  return join(at(g.lower), at(g.upper));
}

}  // namespace

dvec3 closed_form_point(const ClosedForm& f, dvec2 uv) {
  if (f.kind == SurfaceKind::kPlane) return f.location + uv.x * f.x + uv.y * f.y;
  const dvec3 radial = std::cos(uv.x) * f.x + std::sin(uv.x) * f.y;
  switch (f.kind) {
    case SurfaceKind::kCylinder:
      return f.location + f.r1 * radial + uv.y * f.z;
    case SurfaceKind::kCone:
      return f.location + (f.r1 + uv.y * f.sin_a) * radial + uv.y * f.cos_a * f.z;
    case SurfaceKind::kSphere:
      return f.location + f.r1 * (std::cos(uv.y) * radial + std::sin(uv.y) * f.z);
    default:
      return f.location + (f.r1 + f.r2 * std::cos(uv.y)) * radial + f.r2 * std::sin(uv.y) * f.z;
  }
}

dvec3 closed_form_normal(const ClosedForm& f, dvec2 uv) {
  if (f.kind == SurfaceKind::kPlane) return f.hand * f.z;
  const dvec3 radial = std::cos(uv.x) * f.x + std::sin(uv.x) * f.y;
  switch (f.kind) {
    case SurfaceKind::kCylinder:
      return f.hand * radial;
    case SurfaceKind::kCone: {
      // |Su| carries the sign of the radius: beyond the apex the normal turns over.
      const double side = f.r1 + uv.y * f.sin_a < 0.0 ? -f.hand : f.hand;
      return side * (f.cos_a * radial - f.sin_a * f.z);
    }
    case SurfaceKind::kSphere:
      return f.hand * (std::cos(uv.y) * radial + std::sin(uv.y) * f.z);
    default: {
      const double side = f.r1 + f.r2 * std::cos(uv.y) < 0.0 ? -f.hand : f.hand;
      return side * (std::cos(uv.y) * radial + std::sin(uv.y) * f.z);
    }
  }
}

Box3 closed_form_box(const ClosedForm& f, const Box2& uv) {
  Box3 box;
  const double u0 = uv.lower.x, u1 = uv.upper.x, v0 = uv.lower.y, v1 = uv.upper.y;
  double size = 0.0;
  for (int a = 0; a < 3; ++a) {
    Interval range{0.0, 0.0};
    const double z = f.z[a];
    if (f.kind == SurfaceKind::kPlane) {
      range.lower = std::min(u0 * f.x[a], u1 * f.x[a]) + std::min(v0 * f.y[a], v1 * f.y[a]);
      range.upper = std::max(u0 * f.x[a], u1 * f.x[a]) + std::max(v0 * f.y[a], v1 * f.y[a]);
    } else {
      const Interval g = sinusoid(f.x[a], f.y[a], u0, u1);
      switch (f.kind) {
        case SurfaceKind::kCylinder:
          range = ruled(f.r1, f.r1, v0, v1, g, z);
          break;
        case SurfaceKind::kCone:
          range = ruled(f.r1 + v0 * f.sin_a, f.r1 + v1 * f.sin_a, v0 * f.cos_a, v1 * f.cos_a, g, z);
          break;
        case SurfaceKind::kSphere:
          range =
              turned(0.0, f.r1, g, z, std::clamp(v0, -kHalfPi, kHalfPi), std::clamp(v1, -kHalfPi, kHalfPi));
          break;
        default:
          range = turned(f.r1, f.r2, g, z, v0, v1);
          break;
      }
    }
    box.lower[a] = f.location[a] + range.lower, box.upper[a] = f.location[a] + range.upper;
    size = std::max({size, std::abs(f.location[a]), std::abs(range.lower), std::abs(range.upper)});
  }
  box.dilate(1e-14 * size);  // the rounding of the sums above
  return box;
}

OrientedBox closed_form_oriented_box(const ClosedForm& f, const Box2& uv) {
  const dvec2 middle = uv.center();
  const dvec3 pivot = closed_form_point(f, middle);
  // Tangent along u; the frame of a plane, the meridian's normal of the others.
  const dvec3 normal = closed_form_normal(f, middle);
  const dvec3 across =
      f.kind == SurfaceKind::kPlane ? f.x : -std::sin(middle.x) * f.x + std::cos(middle.x) * f.y;
  const dvec3 frame[3] = {across, glm::cross(normal, across), normal};
  const auto turned_in = [&](const dvec3& p) {
    return dvec3(glm::dot(p, frame[0]), glm::dot(p, frame[1]), glm::dot(p, frame[2]));
  };
  ClosedForm local = f;
  local.location = turned_in(f.location - pivot);
  local.x = turned_in(f.x), local.y = turned_in(f.y), local.z = turned_in(f.z);
  Box3 box = closed_form_box(local, uv);
  // The frame is orthonormal up to rounding.
  box.dilate(1e-14 * (glm::length(f.location) + glm::length(pivot) + box.diagonal()));
  OrientedBox out;
  const dvec3 center = box.center(), half = 0.5 * box.extent();
  out.center = pivot + center.x * frame[0] + center.y * frame[1] + center.z * frame[2];
  for (int a = 0; a < 3; ++a) out.axis[a] = half[a] * frame[a];
  return out;
}

dvec2 closed_form_lengths(const ClosedForm& f, const Box2& uv) {
  const dvec2 extent = uv.extent();
  switch (f.kind) {
    case SurfaceKind::kCylinder:
      return {extent.x * f.r1, extent.y};
    case SurfaceKind::kCone:
      return {
          extent.x * std::max(std::abs(f.r1 + uv.lower.y * f.sin_a), std::abs(f.r1 + uv.upper.y * f.sin_a)),
          extent.y};
    case SurfaceKind::kSphere: {
      const double flat =
          uv.lower.y <= 0.0 && uv.upper.y >= 0.0 ? 1.0 : std::max(std::cos(uv.lower.y), std::cos(uv.upper.y));
      return {extent.x * f.r1 * flat, extent.y * f.r1};
    }
    case SurfaceKind::kTorus:
      return {extent.x * (f.r1 + f.r2), extent.y * f.r2};
    default:
      return extent;
  }
}

}  // namespace trimray::trace
