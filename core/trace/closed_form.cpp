#include "core/trace/closed_form.h"

#include <algorithm>
#include <cmath>

#include "core/trace/closed_form_local.h"

namespace trimray::trace {

using nurbs::SurfaceKind;

namespace {

// x axis through the ray's closest approach to the axis of a circle of radius r1: the chord is symmetric
// about it. h is the distance of the ray from the axis, so r^2 - h^2 is computed as (r - h)(r + h), which
// keeps its digits where the ray grazes.
int cylinder_roots(const ClosedForm& form, const LocalRay& ray, LocalRoot* out) {
  const double a = ray.dx * ray.dx + ray.dy * ray.dy;
  if (!(a > 1e-30)) return 0;  // along the axis: the ray never crosses
  const double middle = -(ray.ox * ray.dx + ray.oy * ray.dy) / a;
  const double qx = ray.ox + middle * ray.dx, qy = ray.oy + middle * ray.dy;
  const double c = qx * ray.dy - qy * ray.dx;
  const double h = std::abs(c) / std::sqrt(a);
  const double chord = (form.r1 - h) * (form.r1 + h);
  if (!(chord > 0.0)) return 0;
  const double half = std::sqrt(chord / a);
  for (int i = 0; i < 2; ++i) {
    const double s = i == 0 ? -half : half;
    const double t = middle + s;
    // The foot of the perpendicular, exactly perpendicular to the ray, then along the chord.
    out[i] = {t, c / a * ray.dy + s * ray.dx, -c / a * ray.dx + s * ray.dy, ray.oz + t * ray.dz};
  }
  return 2;
}

int sphere_roots(const ClosedForm& form, const LocalRay& ray, LocalRoot* out) {
  const double middle = -(ray.ox * ray.dx + ray.oy * ray.dy + ray.oz * ray.dz);
  const double qx = ray.ox + middle * ray.dx, qy = ray.oy + middle * ray.dy, qz = ray.oz + middle * ray.dz;
  const double h = std::sqrt(qx * qx + qy * qy + qz * qz);
  const double chord = (form.r1 - h) * (form.r1 + h);
  if (!(chord > 0.0)) return 0;
  const double half = std::sqrt(chord);
  for (int i = 0; i < 2; ++i) {
    const double s = i == 0 ? -half : half;
    out[i] = {middle + s, qx + s * ray.dx, qy + s * ray.dy, qz + s * ray.dz};
  }
  return 2;
}

// rho^2 = w^2 with w = r1 + z tan a. In the Minkowski metric (x, y, w) the discriminant is a difference of
// squares of 2x2 minors, computed as a product so that grazing rays keep their digits.
int cone_roots(const ClosedForm& form, const LocalRay& ray, LocalRoot* out) {
  const double k = form.sin_a / form.cos_a;
  const double w = form.r1 + k * ray.oz, wd = k * ray.dz;
  const double a = (ray.dx * ray.dx + ray.dy * ray.dy) - wd * wd;
  const double b = ray.ox * ray.dx + ray.oy * ray.dy - w * wd;
  const double c = ray.ox * ray.ox + ray.oy * ray.oy - w * w;
  const double m1 = ray.ox * wd - w * ray.dx, m2 = ray.oy * wd - w * ray.dy;
  const double m3 = ray.ox * ray.dy - ray.oy * ray.dx;
  const double g = std::sqrt(m1 * m1 + m2 * m2);
  const double disc = (g - std::abs(m3)) * (g + std::abs(m3));
  if (!(disc > 0.0)) return 0;
  const double root = std::sqrt(disc);
  const double q = b > 0.0 ? -(b + root) : root - b;
  double t[2] = {q / a, c / q};
  if (t[1] < t[0]) std::swap(t[0], t[1]);
  int count = 0;
  for (int i = 0; i < 2; ++i) {
    if (!std::isfinite(t[i])) continue;  // parallel to a generator: one root is at infinity
    LocalRoot r{t[i], 0.0, 0.0, 0.0};
    // Newton's steps with the residual taken at the root, where it has all its digits.
    for (int step = 0; step < 2; ++step) {
      r.x = ray.ox + r.t * ray.dx, r.y = ray.oy + r.t * ray.dy, r.z = ray.oz + r.t * ray.dz;
      const double rho = std::sqrt(r.x * r.x + r.y * r.y), wr = std::abs(form.r1 + k * r.z);
      const double slope = 2.0 * (r.x * ray.dx + r.y * ray.dy - (form.r1 + k * r.z) * wd);
      const double move = (rho - wr) * (rho + wr) / slope;
      // Beyond the neighbour root's side the step would leave the basin: a tangent ray keeps what it has.
      if (!(std::abs(move) <= 1e-3 * std::abs(t[1] - t[0])) && std::isfinite(t[1] - t[0])) break;
      if (!std::isfinite(move)) break;
      r.t -= move;
    }
    r.x = ray.ox + r.t * ray.dx, r.y = ray.oy + r.t * ray.dy, r.z = ray.oz + r.t * ray.dz;
    out[count++] = r;
  }
  return count;
}

int plane_roots(const LocalRay& ray, LocalRoot* out) {
  if (ray.dz == 0.0) return 0;
  const double t = -ray.oz / ray.dz;
  if (!std::isfinite(t)) return 0;
  out[0] = {t, ray.ox + t * ray.dx, ray.oy + t * ray.dy, 0.0};
  return 1;
}

double angle(double y, double x) {
  const double u = std::atan2(y, x);
  return u < 0.0 ? std::min(u + kTwoPi, std::nextafter(kTwoPi, 0.0)) : u;
}

// True where x, up to a full turn, lies in [lower, upper].
bool in_turn(double x, double lower, double upper) {
  const double middle = 0.5 * (lower + upper);
  x += kTwoPi * std::round((middle - x) / kTwoPi);
  return x >= lower && x <= upper;
}

// uv of a point on the surface; false when it is not in the box. The cheap coordinate is tested first.
bool accept(const ClosedForm& form, const LocalRoot& p, const Box2& box, dvec2& uv) {
  switch (form.kind) {
    case SurfaceKind::kPlane:
      uv = {p.x, p.y};
      return box.contains(uv);
    case SurfaceKind::kCylinder:
      uv.y = p.z;
      if (!(uv.y >= box.lower.y && uv.y <= box.upper.y)) return false;
      uv.x = angle(p.y, p.x);
      break;
    case SurfaceKind::kCone: {
      uv.y = p.z / form.cos_a;
      if (!(uv.y >= box.lower.y && uv.y <= box.upper.y)) return false;
      const bool beyond_apex = form.r1 + uv.y * form.sin_a < 0.0;
      uv.x = beyond_apex ? angle(-p.y, -p.x) : angle(p.y, p.x);
      break;
    }
    case SurfaceKind::kSphere:
      uv.y = std::atan2(p.z, std::sqrt(p.x * p.x + p.y * p.y));
      if (!(uv.y >= box.lower.y && uv.y <= box.upper.y)) return false;
      uv.x = angle(p.y, p.x);
      break;
    default: {
      // A spindle torus has an inner sheet, where r1 + r2 cos v is negative.
      const double rho = std::sqrt(p.x * p.x + p.y * p.y);
      const double outer = std::abs(std::hypot(rho - form.r1, p.z) - form.r2);
      const double inner = std::abs(std::hypot(rho + form.r1, p.z) - form.r2);
      const bool is_inner = inner < outer;
      uv.y = is_inner ? angle(p.z, -rho - form.r1) : angle(p.z, rho - form.r1);
      if (!in_turn(uv.y, box.lower.y, box.upper.y)) return false;
      uv.x = is_inner ? angle(-p.y, -p.x) : angle(p.y, p.x);
      break;
    }
  }
  return in_turn(uv.x, box.lower.x, box.upper.x);
}

}  // namespace

bool solves_closed_form(SurfaceKind kind) {
  return kind == SurfaceKind::kPlane || kind == SurfaceKind::kCylinder || kind == SurfaceKind::kCone ||
         kind == SurfaceKind::kSphere || kind == SurfaceKind::kTorus;
}

ClosedForm make_closed_form(const nurbs::Surface& surface, const Box2& uv_box, double margin_mm) {
  ClosedForm form;
  form.kind = surface.kind;
  form.location = surface.location;
  form.x = surface.x_axis, form.y = surface.y_axis, form.z = surface.z_axis;
  form.hand = glm::dot(glm::cross(form.x, form.y), form.z) < 0.0 ? -1.0 : 1.0;
  form.r1 = surface.r1, form.r2 = surface.r2;
  form.sin_a = std::sin(surface.semi_angle), form.cos_a = std::cos(surface.semi_angle);
  form.uv = uv_box;
  // The margin as a step in uv; a full turn where the circle of latitude is no longer than the margin.
  const double least = 1e-9;
  double radius = form.r1, step_v = margin_mm;
  if (form.kind == SurfaceKind::kCone) {
    radius = std::min(std::abs(form.r1 + uv_box.lower.y * form.sin_a),
                      std::abs(form.r1 + uv_box.upper.y * form.sin_a));
  } else if (form.kind == SurfaceKind::kSphere) {
    step_v = margin_mm / form.r1;
    radius = form.r1 * std::min(std::cos(uv_box.lower.y), std::cos(uv_box.upper.y));
  } else if (form.kind == SurfaceKind::kTorus) {
    step_v = margin_mm / form.r2;
    radius = std::max(form.r1 - form.r2, 0.0);
  }
  const double step_u = form.kind == SurfaceKind::kPlane ? margin_mm
                        : radius > margin_mm / 3.0       ? margin_mm / radius
                                                         : kTwoPi;
  form.uv.lower -= dvec2(step_u + least, step_v + least);
  form.uv.upper += dvec2(step_u + least, step_v + least);
  const dvec2 middle = uv_box.center();
  form.reference = closed_form_point(form, middle);
  return form;
}

int closed_form_roots(const ClosedForm& form, dvec3 org, dvec3 dir, const Box2& box, double tmin, double tmax,
                      ClosedRoot* out) {
  const LocalRay ray = local_ray(form, org, dir);
  LocalRoot roots[kMaxClosedRoots];
  int found = 0;
  switch (form.kind) {
    case SurfaceKind::kPlane:
      found = plane_roots(ray, roots);
      break;
    case SurfaceKind::kCylinder:
      found = cylinder_roots(form, ray, roots);
      break;
    case SurfaceKind::kCone:
      found = cone_roots(form, ray, roots);
      break;
    case SurfaceKind::kSphere:
      found = sphere_roots(form, ray, roots);
      break;
    case SurfaceKind::kTorus:
      found = torus_roots(form, ray, roots);
      break;
    default:
      break;
  }
  int count = 0;
  for (int i = 0; i < found; ++i) {
    const double t = ray.t0 + roots[i].t;
    if (!(t >= tmin && t <= tmax)) continue;
    dvec2 uv;
    if (accept(form, roots[i], box, uv)) out[count++] = {t, uv};
  }
  return count;
}

}  // namespace trimray::trace
