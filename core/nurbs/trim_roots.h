// Where a coordinate of a rational Bezier piece turns round.
#pragma once

#include <span>
#include <vector>

#include "core/base/types.h"

namespace trimray::nurbs {

// Appends the parameters in (0, 1), ascending, at which coordinate axis (0: u, 1: v) of the piece has an
// extremum: the sign changes of the numerator of its derivative. Between two of them the coordinate is
// monotone up to rounding. Control points are (w u, w v, w), weights > 0.
void append_extrema(std::span<const dvec3> ctrl_h, int axis, std::vector<double>& parameters);

}  // namespace trimray::nurbs
