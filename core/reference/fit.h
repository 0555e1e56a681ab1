// Polynomial approximation of a smooth surface over the unit square.
#pragma once

#include <functional>

#include "core/reference/bezier.h"

namespace trimray::reference {

inline constexpr int kFitDegree = 8;

// Fills out.p, out.q, out.ctrl (weights 1) with the polynomial of degree 8 x 8 that agrees with f at
// Chebyshev points. Returns the largest distance seen at points between them.
double fit(const std::function<Vec3(Real, Real)>& f, Patch& out);

}  // namespace trimray::reference
