// Signed crossings of plane curves with the half-line from the origin along +x.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace trimray::reference {

// Of one Bezier curve given by homogeneous control points without their (positive) weights. Upward crossings
// count +1, downward ones -1; y >= 0 is above, so curves that share an end point never count it twice.
// Only end points and halving decide: the same curve gives the same number every time.
int half_line_crossings(const std::vector<dvec2>& curve);

}  // namespace trimray::reference
