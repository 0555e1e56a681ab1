// Prototypes under placements that change angles: their analytic surfaces are no longer what they were.
#pragma once

#include "core/nurbs/store.h"

namespace trimray::distance {

// A copy of the store whose prototype lies placed in the world, every surface of it in its NURBS form, which
// any affine map takes exactly to the mapped surface's. Offset surfaces have none: their faces become
// kUnsupported. False where the placement has no inverse.
bool stretch_prototype(const nurbs::NurbsStore& store, std::int32_t prototype, const Transform& placement,
                       nurbs::NurbsStore& out);

}  // namespace trimray::distance
