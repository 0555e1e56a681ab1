// Foot points on planes, cylinders, cones, spheres and tori.
#pragma once

#include "core/trace/closed_form.h"

namespace trimray::distance {

struct ClosedFoot {
  dvec2 uv{0.0};  // angles up to full turns
  dvec3 p{0.0};
};

// The points of the whole surface where its distance from q has a local minimum, at most two: a cone has one
// on each side of its axis, a torus that meets itself has an outer and an inner one. Where a whole circle (or
// sphere) is nearest, one of its points: a face has all of the circle, or an edge that crosses it.
int closed_feet(const trace::ClosedForm& form, const dvec3& q, ClosedFoot (&out)[2]);

}  // namespace trimray::distance
