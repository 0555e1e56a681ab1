// Which way round a face's trim loops run.
#pragma once

#include <cstdint>
#include <vector>

#include "core/nurbs/store.h"

namespace trimray::trace {

// Per loop of the face: +1 when the trimmed region (even-odd) lies to the left of the loop in uv, as it
// should, -1 when to the right. The winding numbers need this, and files do not always keep it.
std::vector<int> loop_signs(const nurbs::NurbsStore& store, std::int32_t face);

}  // namespace trimray::trace
