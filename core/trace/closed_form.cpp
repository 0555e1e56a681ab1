#include "core/trace/closed_form.h"

#include <algorithm>
#include <cmath>

#include "core/trace/closed_form_lanes.h"
#include "core/trace/closed_form_local.h"

namespace trimray::trace {

using nurbs::SurfaceKind;

namespace {

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

// uv of a point on a torus; false when it is not in the box. The cheap coordinate is tested first.
bool accept(const ClosedForm& form, const LocalRoot& p, const Box2& box, dvec2& uv) {
  // A spindle torus has an inner sheet, where r1 + r2 cos v is negative.
  const double rho = std::sqrt(p.x * p.x + p.y * p.y);
  const double outer = std::abs(std::hypot(rho - form.r1, p.z) - form.r2);
  const double inner = std::abs(std::hypot(rho + form.r1, p.z) - form.r2);
  const bool is_inner = inner < outer;
  uv.y = is_inner ? angle(p.z, -rho - form.r1) : angle(p.z, rho - form.r1);
  if (!in_turn(uv.y, box.lower.y, box.upper.y)) return false;
  uv.x = is_inner ? angle(-p.y, -p.x) : angle(p.y, p.x);
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

namespace {

int torus_roots_in(const ClosedForm& form, dvec3 org, dvec3 dir, const Box2& box, double tmin, double tmax,
                   ClosedRoot* out) {
  const LocalRay ray = local_ray(form, org, dir);
  LocalRoot roots[kMaxClosedRoots];
  const int found = torus_roots(form, ray, roots);
  int count = 0;
  for (int i = 0; i < found; ++i) {
    const double t = ray.t0 + roots[i].t;
    if (!(t >= tmin && t <= tmax)) continue;
    dvec2 uv;
    if (accept(form, roots[i], box, uv)) out[count++] = {t, uv, closed_form_normal(form, uv)};
  }
  return count;
}

}  // namespace

int closed_form_roots(const ClosedForm& form, dvec3 org, dvec3 dir, const Box2& box, double tmin, double tmax,
                      ClosedRoot* out) {
  if (form.kind == SurfaceKind::kTorus) return torus_roots_in(form, org, dir, box, tmin, tmax, out);
  RayLanes rays = {};
  rays.org_x[0] = org.x, rays.org_y[0] = org.y, rays.org_z[0] = org.z;
  rays.dir_x[0] = dir.x, rays.dir_y[0] = dir.y, rays.dir_z[0] = dir.z;
  rays.active = 1;
  const double near[kLanes] = {tmin}, far[kLanes] = {tmax};
  ClosedRootLanes roots;
  closed_form_lanes(form, rays, box, near, far, roots);
  int count = 0;
  for (int k = 0; k < kLaneRoots; ++k)
    if (roots.found[k] & 1u)
      out[count++] = {roots.t[k][0],
                      {roots.u[k][0], roots.v[k][0]},
                      {roots.normal_x[k][0], roots.normal_y[k][0], roots.normal_z[k][0]}};
  return count;
}

}  // namespace trimray::trace
