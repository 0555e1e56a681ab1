// Every root of a line on one leaf, certain: subdivision of the distance net with convex hull exclusion along
// the leaf's own directions (Nishita, Sederberg, Kakimoto 1990; Campagna, Slusallek, Seidel 1997 for several
// roots) and a uniqueness proof that hands over to Newton.
#pragma once

#include <vector>

#include "core/trace/newton.h"
#include "core/trace/patch_data.h"

namespace trimray::trace {

// Counters of one search, for tests.
struct ClipStats {
  int boxes = 0;           // examined
  int unresolved = 0;      // too small to split further: roots closer than rounding, dropped
  bool exhausted = false;  // given up: roots may be missing
};

// Boxes examined before a search is given up: a ray that lies in the surface.
inline constexpr int kMaxClipBoxes = 8192;

// Appends the roots of the ray's whole line on the leaf, in patch parameters, in no particular order.
// Not for offset patches.
ClipStats clip_roots(const Patch& patch, const PatchPool& pool, const LeafBound& leaf, const Ray& ray,
                     std::vector<PatchRoot>& roots);

}  // namespace trimray::trace
