#include "core/tess/chart.h"

#include <cmath>
#include <numbers>

#include "core/nurbs/knot_vector.h"

namespace trimray::tess {

using nurbs::ParamMap;
using nurbs::Surface;
using nurbs::SurfaceKind;
using nurbs::SurfacePoint;

Chart::Chart(const nurbs::NurbsStore& store, const Surface& surface)
    : store_(&store),
      surface_(&surface),
      view_(nurbs::view(store, surface)),
      closed_form_(nurbs::has_closed_form(surface.kind)),
      mapped_(!closed_form_ &&
              (surface.map_u != ParamMap::kIdentity || surface.map_v != ParamMap::kIdentity)) {
  for (int d = 0; d < 2; ++d) {
    const double e = surface.domain.upper[d] - surface.domain.lower[d];
    if (std::isfinite(e) && e > 0.0) extent_[d] = e;
  }
}

dvec2 Chart::from_face(dvec2 uv) const {
  if (!mapped_) return uv;
  return {nurbs::nurbs_from_face(*store_, surface_->knots_u, surface_->map_u, uv.x),
          nurbs::nurbs_from_face(*store_, surface_->knots_v, surface_->map_v, uv.y)};
}

dvec2 Chart::to_face(dvec2 p) const {
  if (!mapped_) return p;
  return {nurbs::face_from_nurbs(*store_, surface_->knots_u, surface_->map_u, p.x),
          nurbs::face_from_nurbs(*store_, surface_->knots_v, surface_->map_v, p.y)};
}

dvec3 Chart::point(dvec2 p) const { return nurbs::evaluate_point(view_, to_face(p)); }

SurfacePoint Chart::at(dvec2 p) const {
  const dvec2 uv = to_face(p);
  SurfacePoint r = nurbs::evaluate(view_, uv);
  if (!mapped_) return r;
  const auto slope = [](std::span<const double> knots, int degree, ParamMap map, double u) {
    const int span = nurbs::find_span(knots, degree, u);
    return nurbs::map_parameter(map, knots[span], knots[span + 1], u).ds;
  };
  r.du /= slope(view_.knots_u, surface_->degree_u, surface_->map_u, uv.x);
  r.dv /= slope(view_.knots_v, surface_->degree_v, surface_->map_v, uv.y);
  return r;
}

dvec2 Chart::project(const dvec3& point, dvec2 guess) const {
  return closed_form_ ? project_closed_form(point, guess) : project_newton(point, guess);
}

dvec2 Chart::project_closed_form(const dvec3& point, dvec2 guess) const {
  const Surface& s = *surface_;
  const dvec3 d = point - s.location;
  const double x = glm::dot(d, s.x_axis), y = glm::dot(d, s.y_axis), z = glm::dot(d, s.z_axis);
  if (s.kind == SurfaceKind::kPlane) return {x, y};
  constexpr double kTurn = 2.0 * std::numbers::pi;
  constexpr double kSingular = 1e-9;
  const double rho = std::hypot(x, y);
  // On the far nappe of a cone, and beyond the pole of a sphere, the radius counts backwards.
  double radius = s.r1;
  if (s.kind == SurfaceKind::kCone) radius += guess.y * std::sin(s.semi_angle);
  if (s.kind == SurfaceKind::kSphere) radius *= std::cos(guess.y);
  const double side = radius < 0.0 ? -1.0 : 1.0;
  dvec2 r = guess;
  if (rho > kSingular * (std::abs(s.r1) + std::abs(radius)))
    r.x = nurbs::wrap_near(std::atan2(side * y, side * x), guess.x, kTurn);
  const double signed_rho = side * rho;
  switch (s.kind) {
    case SurfaceKind::kCylinder:
      r.y = z;
      break;
    case SurfaceKind::kCone:
      r.y = (signed_rho - s.r1) * std::sin(s.semi_angle) + z * std::cos(s.semi_angle);
      break;
    case SurfaceKind::kSphere:
      r.y = nurbs::wrap_near(std::atan2(z, signed_rho), guess.y, kTurn);
      break;
    default:  // torus; on its spine circle every v is as near
      if (std::hypot(z, rho - s.r1) > kSingular * s.r2)
        r.y = nurbs::wrap_near(std::atan2(z, rho - s.r1), guess.y, kTurn);
  }
  return r;
}

// Gauss-Newton: the points are within an edge's tolerance of the surface, so that it converges fast. A step
// that leads away, over a kink, is taken in part.
dvec2 Chart::project_newton(const dvec3& point, dvec2 guess) const {
  constexpr int kSteps = 40;
  dvec2 best = guess, move(0.0);
  double least = kInf;
  for (int step = 0; step < kSteps; ++step) {
    const dvec2 p = best + move;
    const SurfacePoint s = at(p);
    const dvec3 gap = point - s.p;
    const double distance = glm::dot(gap, gap);
    const double a = glm::dot(s.du, s.du), b = glm::dot(s.du, s.dv), c = glm::dot(s.dv, s.dv);
    const double size_u = a * extent_.x * extent_.x, size_v = c * extent_.y * extent_.y;
    const auto small = [&] {
      return !(a * move.x * move.x + c * move.y * move.y > 1e-28 * (size_u + size_v));
    };
    if (step > 0 && !(distance < least)) {
      move *= 0.25;
      if (small()) break;
      continue;
    }
    best = p, least = distance;
    const double f = glm::dot(s.du, gap), g = glm::dot(s.dv, gap);
    constexpr double kCollapsed = 1e-14;
    move = dvec2(0.0);
    if (size_u <= kCollapsed * size_v) {
      if (c > 0.0) move.y = g / c;
    } else if (size_v <= kCollapsed * size_u) {
      move.x = f / a;
    } else {
      const double det = a * c - b * b;
      if (det > 1e-12 * a * c)
        move = {(c * f - b * g) / det, (a * g - b * f) / det};
      else
        move = {0.5 * f / a, 0.5 * g / c};
    }
    move = glm::clamp(move, -0.1 * extent_, 0.1 * extent_);
    if (small()) break;
  }
  return best;
}

}  // namespace trimray::tess
