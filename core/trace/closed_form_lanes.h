// Rays against one plane, cylinder, cone or sphere in SIMD lanes. closed_form_roots() is this code on one
// lane, so that every way to a root gives the same bits.
#pragma once

#include "core/trace/closed_form.h"
#include "core/trace/ray.h"

namespace trimray::trace {

inline constexpr int kLaneRoots = 2;

// The first and second root of each lane's line, by increasing t.
struct ClosedRootLanes {
  alignas(64) double t[kLaneRoots][kLanes], u[kLaneRoots][kLanes], v[kLaneRoots][kLanes];
  alignas(64) double normal_x[kLaneRoots][kLanes], normal_y[kLaneRoots][kLanes],
      normal_z[kLaneRoots][kLanes];  // as ClosedRoot::normal
  std::uint32_t found[kLaneRoots];   // bit i: lane i's root lies in its [tmin, tmax] and in the box
};

// Does closed_form_lanes() know the kind? All that solves_closed_form() does but the torus.
inline bool solves_closed_form_lanes(nurbs::SurfaceKind kind) {
  return solves_closed_form(kind) && kind != nurbs::SurfaceKind::kTorus;
}

// As closed_form_roots() on each active lane. tmin, tmax: of the lanes; they are read on all of them.
void closed_form_lanes(const ClosedForm& form, const RayLanes& rays, const Box2& uv, const double* tmin,
                       const double* tmax, ClosedRootLanes& out);

}  // namespace trimray::trace
