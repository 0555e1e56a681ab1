// Internal to closed_form*: a ray in the surface's own frame, and its roots there.
#pragma once

#include <glm/gtc/constants.hpp>

#include "core/trace/closed_form.h"

namespace trimray::trace {

inline constexpr double kTwoPi = 6.283185307179586476925286766559;
inline constexpr double kHalfPi = 1.5707963267948966192313216916398;

struct LocalRay {
  double ox, oy, oz, dx, dy, dz;
  double t0;  // the ray's parameter at (ox, oy, oz)
};

struct LocalRoot {
  double t;  // from LocalRay::t0
  double x, y, z;
};

// The origin moves next to the face, so that a far camera costs no digits in what follows.
inline LocalRay local_ray(const ClosedForm& form, dvec3 org, dvec3 dir) {
  const double t0 = glm::dot(form.reference - org, dir);
  const dvec3 p = (org + t0 * dir) - form.location;
  return {glm::dot(p, form.x),
          glm::dot(p, form.y),
          glm::dot(p, form.z),
          glm::dot(dir, form.x),
          glm::dot(dir, form.y),
          glm::dot(dir, form.z),
          t0};
}

// By increasing t; 0, 2 or 4 roots.
int torus_roots(const ClosedForm& form, const LocalRay& ray, LocalRoot* out);

}  // namespace trimray::trace
