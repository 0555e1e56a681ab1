// Area and moments of one face, by adaptive quadrature over its strips.
#pragma once

#include <cstdint>

#include "core/mass/integrals.h"
#include "core/nurbs/store.h"

namespace trimray::mass {

struct FaceIntegrals {
  Integrals value{};
  // What each may be off by: the sum, over all parts, of the difference of the last two rules, and rounding.
  // No strict bound, but a large overestimate wherever the rules converge: it is the error of the last but
  // one.
  Integrals error{};
};

// origin: of the moments. reach: mm, how far from it the body reaches, for what counts as small. Aims at a
// relative error of 1e-13 of the face's area (of its share of reach * area for the volume, and so on).
// cofactor: of a placement that changes angles, for the area there; null otherwise.
FaceIntegrals integrate_face(const nurbs::NurbsStore& store, std::int32_t face, dvec3 origin, double reach,
                             const dmat3* cofactor = nullptr);

}  // namespace trimray::mass
