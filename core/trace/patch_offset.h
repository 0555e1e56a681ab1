// Roots on an offset surface S + offset n, n = S_u x S_v / |S_u x S_v|, which has no Bezier form.
#pragma once

#include <vector>

#include "core/trace/newton.h"
#include "core/trace/patch_data.h"

namespace trimray::trace {

// Appends the roots of the ray's whole line on the leaf, by subdivision: a box is dropped when the control hull
// of its base patch, widened by the offset within the cone of its normals, misses the line.
void offset_roots(const Patch& patch, const PatchPool& pool, const LeafBound& leaf, const Ray& ray,
                  std::vector<PatchRoot>& roots);

}  // namespace trimray::trace
