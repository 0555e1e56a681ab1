// Parallelepipeds that hold the leaves of a hierarchy.
#pragma once

#include "core/base/types.h"

namespace trimray::trace {

// The leaf lies in {center + x a + y b + z k : |x|, |y|, |z| <= 1}, up to the rounding of these numbers.
// Relative to the centre of the prototype's Bvh, mm.
struct LeafHull {
  float center[3], a[3], b[3], k[3];
};

}  // namespace trimray::trace
