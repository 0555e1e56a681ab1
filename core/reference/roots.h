// All common roots of two bivariate polynomials on the unit square, by subdivision: a box is given up when
// its Bernstein coefficients lie on one side of a line through the origin, and settled when a
// contraction proves that it holds one root or none.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace trimray::reference {

// Two polynomials of degree (p, q) in Bernstein form; c[i * (q + 1) + j].
struct Net {
  int p = 0, q = 0;
  std::vector<dvec2> c;
};

// Appends every root, each good to about 1e-6 of the square or better (the caller polishes), and those on
// the border up to 1e-12 outside. Roots on the border between two inner boxes may come twice.
// noise: what rounding may have done to a coefficient. False when some box stays undecided down to noise (a
// tangent line, a collapsed side): no root is reported there.
bool common_roots(const Net& net, double noise, std::vector<dvec2>& roots);

}  // namespace trimray::reference
