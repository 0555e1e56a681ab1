#include "core/nurbs/surface_source.h"

#include <cmath>
#include <numbers>

#include "core/nurbs/curve_form.h"

namespace trimray::nurbs {
namespace {

constexpr double kPi = std::numbers::pi;

using Kind = brep::SurfaceKind;

bool sound(const dvec3& v) {
  const dvec3 a = glm::abs(v);
  return a.x < kMaxCoordinate && a.y < kMaxCoordinate && a.z < kMaxCoordinate;  // false for NaN
}

bool sound_frame(const Surface& f) {
  if (!sound(f.location) || !sound(f.x_axis) || !sound(f.y_axis) || !sound(f.z_axis)) return false;
  if (!(std::abs(f.r1) < kMaxCoordinate) || !(std::abs(f.r2) < kMaxCoordinate) ||
      !std::isfinite(f.semi_angle))
    return false;
  const double volume = glm::dot(glm::cross(f.x_axis, f.y_axis), f.z_axis);
  return std::abs(std::abs(volume) - 1.0) < 1e-3;
}

SurfaceKind plain_kind(Kind kind) {
  switch (kind) {
    case Kind::kPlane:
      return SurfaceKind::kPlane;
    case Kind::kCylinder:
      return SurfaceKind::kCylinder;
    case Kind::kCone:
      return SurfaceKind::kCone;
    case Kind::kSphere:
      return SurfaceKind::kSphere;
    case Kind::kTorus:
      return SurfaceKind::kTorus;
    case Kind::kExtrusion:
      return SurfaceKind::kExtrusion;
    case Kind::kRevolution:
      return SurfaceKind::kRevolution;
    case Kind::kBezier:
      return SurfaceKind::kBezier;
    case Kind::kBspline:
      return SurfaceKind::kBspline;
    default:
      return SurfaceKind::kNone;
  }
}

// Poles, weights, knots and axes of everything but the closed forms.
bool sound_definition(const brep::Model& model, const brep::Surface& b) {
  if (b.kind == Kind::kBezier || b.kind == Kind::kBspline) {
    if (b.count_u < 2 || b.count_v < 2) return false;
    const std::size_t poles = static_cast<std::size_t>(b.count_u) * b.count_v;
    if (b.poles.size() != poles || (!b.weights.empty() && b.weights.size() != poles)) return false;
    for (const dvec3& p : b.poles)
      if (!sound(p)) return false;
    for (const double w : b.weights)
      if (!(w > 0.0) || !(w < kMaxCoordinate)) return false;
    if (b.kind == Kind::kBezier) return b.count_u - 1 <= kMaxDegree && b.count_v - 1 <= kMaxDegree;
    return knots_valid(b.knots_u, b.multiplicities_u, b.degree_u, b.count_u, b.periodic_u) &&
           knots_valid(b.knots_v, b.multiplicities_v, b.degree_v, b.count_v, b.periodic_v);
  }
  if (b.kind == Kind::kExtrusion || b.kind == Kind::kRevolution)
    return b.basis_curve >= 0 && sound(b.location) && sound(b.z_axis) &&
           std::abs(glm::length(b.z_axis) - 1.0) < 1e-3 &&
           static_cast<std::size_t>(b.basis_curve) < model.curves3.size();
  return true;
}

// Offset surfaces that are again of the same closed form. The normal Su x Sv of a right-handed frame points
// outward.
bool absorb_offset(Surface& f, double offset) {
  const double outward = glm::dot(glm::cross(f.x_axis, f.y_axis), f.z_axis) > 0.0 ? offset : -offset;
  switch (f.kind) {
    case SurfaceKind::kPlane:
      f.location += offset * glm::normalize(glm::cross(f.x_axis, f.y_axis));
      return true;
    case SurfaceKind::kCylinder:
    case SurfaceKind::kSphere:
      f.r1 += outward;
      return f.r1 > 0.0;
    case SurfaceKind::kTorus:
      f.r2 += outward;
      return f.r2 > 0.0 && f.r1 > f.r2;
    default:
      return false;
  }
}

void set_periods(SurfaceSource& s, const brep::Model& model) {
  Surface& f = s.form.surface;
  const brep::Surface& b = *s.definition;
  const auto set = [&](int d, double period) {
    (d == 0 ? f.periodic_u : f.periodic_v) = period > 0.0;
    (d == 0 ? f.period_u : f.period_v) = period;
  };
  s.natural = {dvec2(-kInf), dvec2(kInf)};
  switch (s.basis_kind) {
    case SurfaceKind::kCylinder:
    case SurfaceKind::kCone:
    case SurfaceKind::kSphere:
    case SurfaceKind::kTorus:
    case SurfaceKind::kRevolution:
      set(0, 2.0 * kPi);
      s.natural.lower.x = 0.0, s.natural.upper.x = 2.0 * kPi;
      break;
    default:
      break;
  }
  if (s.basis_kind == SurfaceKind::kSphere) s.natural.lower.y = -kPi / 2, s.natural.upper.y = kPi / 2;
  if (s.basis_kind == SurfaceKind::kTorus) {
    set(1, 2.0 * kPi);
    s.natural.lower.y = 0.0, s.natural.upper.y = 2.0 * kPi;
  }
  if (s.basis_kind == SurfaceKind::kExtrusion || s.basis_kind == SurfaceKind::kRevolution) {
    const CurveDomain d = curve_domain<3>(model.curves3, b.basis_curve);
    const int axis = s.basis_kind == SurfaceKind::kExtrusion ? 0 : 1;
    set(axis, d.period);
    s.natural.lower[axis] = d.lower, s.natural.upper[axis] = d.upper;
    if (d.period > 0.0 && !std::isfinite(d.lower))
      s.natural.lower[axis] = 0.0, s.natural.upper[axis] = d.period;
  }
  if (s.basis_kind == SurfaceKind::kBezier) s.natural = {dvec2(0.0), dvec2(1.0)};
  if (s.basis_kind == SurfaceKind::kBspline) {
    const auto ends = [](const std::vector<double>& knots, const std::vector<std::int32_t>& m, int degree,
                         int count, bool periodic) {
      if (periodic) return dvec2(knots.front(), knots.back());
      const FlatKnots flat = flatten_knots(knots, m, degree, count, false, 0.0, 0.0);
      return dvec2(flat.knots[degree], flat.knots[count]);
    };
    const dvec2 u = ends(b.knots_u, b.multiplicities_u, b.degree_u, b.count_u, b.periodic_u);
    const dvec2 v = ends(b.knots_v, b.multiplicities_v, b.degree_v, b.count_v, b.periodic_v);
    s.natural = {{u.x, v.x}, {u.y, v.y}};
    if (b.periodic_u) set(0, u.y - u.x);
    if (b.periodic_v) set(1, v.y - v.x);
  }
}

// The direction or axis of a sweep; a map that is not rigid leaves none.
void place_sweep(SurfaceSource& s, const Transform& t, bool rigid) {
  Surface& f = s.form.surface;
  if (s.basis_kind != SurfaceKind::kExtrusion && s.basis_kind != SurfaceKind::kRevolution) return;
  s.form.conic = rigid ? placed(s.form.conic, t) : std::nullopt;
  f.location = rigid ? t.point(f.location) : dvec3(0.0);
  f.z_axis = rigid ? t.vector(f.z_axis) : dvec3(0.0);
  // A mirror turns the other way round the axis.
  if (s.basis_kind == SurfaceKind::kRevolution && glm::determinant(t.linear) < 0.0) f.z_axis = -f.z_axis;
}

// Puts a closed form in place by its frame where the map is rigid (or uniform, for the kinds whose parameters
// are all angles); everything else moves its control points and is a B-spline from then on.
void place(SurfaceSource& s, const Transform& t) {
  Surface& f = s.form.surface;
  const double scale = std::cbrt(std::abs(glm::determinant(t.linear)));
  const dmat3 gram = glm::transpose(t.linear) * t.linear;
  double skew = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) skew = std::max(skew, std::abs(gram[i][j] - (i == j ? scale * scale : 0.0)));
  const bool similar = skew <= 1e-9 * scale * scale, rigid = similar && std::abs(scale - 1.0) <= 1e-12;
  if (!(scale > 0.0) || !std::isfinite(scale)) {
    s.status = FaceStatus::kBadSurface;
    return;
  }
  if (f.offset != 0.0) {
    if (!similar) s.status = FaceStatus::kUnsupported;
    f.offset *= glm::determinant(t.linear) > 0.0 ? scale : -scale;
  }
  const bool angles = s.basis_kind == SurfaceKind::kSphere || s.basis_kind == SurfaceKind::kTorus;
  if (has_closed_form(s.basis_kind) && (rigid || (similar && angles))) {
    f.location = t.point(f.location);
    f.x_axis = t.vector(f.x_axis) / scale, f.y_axis = t.vector(f.y_axis) / scale,
    f.z_axis = t.vector(f.z_axis) / scale;
    f.r1 *= scale, f.r2 *= scale;
    return;
  }
  s.transformed = true, s.placement = t;
  if (has_closed_form(f.kind)) f.kind = SurfaceKind::kBspline;
  if (has_closed_form(f.basis)) f.basis = SurfaceKind::kBspline;
  place_sweep(s, t, rigid);
}

bool identity(const Transform& t) { return t.linear == dmat3(1.0) && t.translation == dvec3(0.0); }

}  // namespace

SurfaceSource read_surface(const brep::Model& model, std::int32_t index, const Transform& placement) {
  SurfaceSource s;
  if (index < 0) {
    s.status = FaceStatus::kNoSurface;
    return s;
  }
  double offset = 0.0;
  const brep::Surface* b = &model.surfaces[index];
  Box2 trim{dvec2(-kInf), dvec2(kInf)};
  while (b->kind == Kind::kTrimmed || b->kind == Kind::kOffset) {
    if (b->kind == Kind::kOffset)
      offset += b->offset;
    else
      trim = {glm::max(trim.lower, dvec2(b->u0, b->v0)), glm::min(trim.upper, dvec2(b->u1, b->v1))};
    if (b->basis < 0) {
      s.status = FaceStatus::kBadSurface;
      return s;
    }
    b = &model.surfaces[b->basis];
  }
  s.definition = b;
  s.basis_kind = plain_kind(b->kind);
  Surface& f = s.form.surface;
  f.kind = s.basis_kind;
  if (has_closed_form(f.kind)) {
    f.location = b->location, f.x_axis = b->x_axis, f.y_axis = b->y_axis, f.z_axis = b->z_axis;
    f.r1 = b->r1, f.r2 = b->r2, f.semi_angle = b->semi_angle;
    const bool radii = f.kind == SurfaceKind::kPlane || f.kind == SurfaceKind::kCone ||
                       (f.r1 > 0.0 && (f.kind != SurfaceKind::kTorus || f.r2 > 0.0));
    if (!sound_frame(f) || !radii) s.status = FaceStatus::kBadSurface;
  } else if (f.kind == SurfaceKind::kNone || !sound_definition(model, *b)) {
    s.status = FaceStatus::kBadSurface;
  }
  f.basis = f.kind;
  if (s.status == FaceStatus::kOk &&
      (f.kind == SurfaceKind::kExtrusion || f.kind == SurfaceKind::kRevolution)) {
    f.location = f.kind == SurfaceKind::kRevolution ? b->location : dvec3(0.0);
    f.z_axis = glm::normalize(b->z_axis);
    s.form.conic = conic_of<3>(model.curves3, b->basis_curve);
  }
  if (!(std::abs(offset) < kMaxCoordinate)) s.status = FaceStatus::kBadSurface;
  if (s.status != FaceStatus::kOk) return s;
  if (offset != 0.0) {
    Surface moved = f;
    if (absorb_offset(moved, offset)) {
      f = moved;
    } else {
      f.kind = SurfaceKind::kOffset, f.offset = offset;
    }
  }
  set_periods(s, model);
  // A trimmed surface's range is the natural one of a face without loops.
  if (trim.upper.x > trim.lower.x && trim.upper.y > trim.lower.y)
    for (int d = 0; d < 2; ++d) {
      const bool periodic = d == 0 ? f.periodic_u : f.periodic_v;
      if (periodic && std::isfinite(trim.lower[d]))
        s.natural.lower[d] = trim.lower[d], s.natural.upper[d] = trim.upper[d];
    }
  if (!identity(placement)) place(s, placement);
  return s;
}

}  // namespace trimray::nurbs
