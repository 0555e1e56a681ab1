// Rays against planes, cylinders, cones, spheres and tori without iteration over patches: every root of the
// whole line on the surface that falls into a uv box, in double.
//
// A root is a function of the surface and the ray alone, never of the uv box asked for, so the same root
// found through two boxes has the same bits.
#pragma once

#include "core/base/box.h"
#include "core/nurbs/store.h"

namespace trimray::trace {

// The analytic surface of one face, prepared. uv and formulas as in core/brep/topology.h.
struct ClosedForm {
  nurbs::SurfaceKind kind = nurbs::SurfaceKind::kNone;
  dvec3 location{0.0}, x{0.0}, y{0.0}, z{0.0};  // orthonormal, either hand
  double hand = 1.0;                            // +1 for a right-handed frame, -1 for a left-handed one
  double r1 = 0.0, r2 = 0.0;
  double sin_a = 0.0, cos_a = 1.0;  // of the cone's semi-angle
  dvec3 reference{0.0};             // a point near the face: rays are re-originated next to it
  Box2 uv;                          // the face's uv box, widened by the margin
};

struct ClosedRoot {
  double t = 0.0;
  dvec2 uv{0.0};      // angles in [0, 2 pi), the sphere's v in [-pi/2, pi/2]
  dvec3 normal{0.0};  // Su x Sv, unit; at a pole or apex, a limit along some meridian
};

inline constexpr int kMaxClosedRoots = 4;

bool solves_closed_form(nurbs::SurfaceKind kind);

// margin_mm: how far beyond uv_box roots are still wanted, as a length on the surface.
ClosedForm make_closed_form(const nurbs::Surface& surface, const Box2& uv_box, double margin_mm);

// Roots with t in [tmin, tmax] and uv (angles up to full turns) in the box, by increasing t. dir has unit
// length. Error of t: a few ulp of the distances involved, divided by the sine of the grazing angle. A
// tangent ray has both of its roots or none. Returns their number, at most kMaxClosedRoots.
int closed_form_roots(const ClosedForm& form, dvec3 org, dvec3 dir, const Box2& uv, double tmin, double tmax,
                      ClosedRoot* out);

// Su x Sv, unit; at a pole or apex, the limit along the meridian of uv.
dvec3 closed_form_normal(const ClosedForm& form, dvec2 uv);

dvec3 closed_form_point(const ClosedForm& form, dvec2 uv);

// Conservative box of the surface over a uv box (finite, at most one turn).
Box3 closed_form_box(const ClosedForm& form, const Box2& uv);

// The same along the surface's tangents and normal at the middle of the uv box.
OrientedBox closed_form_oriented_box(const ClosedForm& form, const Box2& uv);

// Length in mm of the uv box's longest iso-line in u and in v.
dvec2 closed_form_lengths(const ClosedForm& form, const Box2& uv);

// Which coordinates of uv are angles with period 2 pi.
inline bool is_angle_u(nurbs::SurfaceKind kind) { return kind != nurbs::SurfaceKind::kPlane; }
inline bool is_angle_v(nurbs::SurfaceKind kind) { return kind == nurbs::SurfaceKind::kTorus; }

}  // namespace trimray::trace
