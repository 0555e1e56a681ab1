// The moments of bodies, which can be moved, placed and added.
#pragma once

#include "core/mass/integrals.h"

namespace trimray::mass {

// Integrals over a body of 1, r and r r^T, r from the origin; and what each entry may be off by.
struct Moments {
  double volume = 0.0;
  dvec3 first{0.0};
  dmat3 second{0.0};
  dvec3 origin{0.0};
  double volume_error = 0.0, first_error = 0.0, second_error = 0.0;
};

Moments moments_of(const Integrals& value, const Integrals& error, dvec3 origin);
// The same about another origin.
Moments moved(const Moments& m, dvec3 origin);
// Of the body placed. Mirrored bodies keep the sign of their volume.
Moments placed(const Moments& m, const Transform& placement);
// About a's origin.
Moments operator+(const Moments& a, const Moments& b);

// Both about the centroid, of density 1: the integral of (r r) 1 - r r^T.
struct Body {
  dvec3 centroid{0.0};
  dmat3 inertia{0.0};
  double centroid_error = 0.0, inertia_error = 0.0;  // inf where the volume may be 0
};
Body body_of(const Moments& m);

}  // namespace trimray::mass
