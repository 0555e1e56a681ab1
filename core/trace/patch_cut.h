// Cuts a Bezier patch into the leaves of the hierarchy.
#pragma once

#include "core/trace/patch_build.h"

namespace trimray::trace {

// Appends the leaves of a patch that is in the pool. Returns the root of their tree, as LeafSplit::child.
std::int32_t cut_patch(std::int32_t index, const PatchInput& input, PatchPool& pool);

}  // namespace trimray::trace
