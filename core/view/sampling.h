// Where in a pixel its rays go: one fixed pattern for every pixel, so that pictures repeat to the byte.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace trimray::view {

// count points of the unit square: the centre for 1, the rotated grid for 4, otherwise a lattice along the
// golden ratio, centred. count >= 1. No two points share a row, so near-horizontal edges get count levels.
std::vector<dvec2> sample_pattern(int count);

}  // namespace trimray::view
