// Newton's method from seeds, a patch at a time: the way of the hybrid tracer to its first hits.
#pragma once

#include "core/trace/patch_data.h"

namespace trimray::trace {

// Steps from a seed before it counts as a bad one.
inline constexpr int kMaxSeededSteps = 6;

// PatchSet::solve_seeded. A lane's answer is the last step from a grid point (kRootGrid), and which grid
// point another start would have been rounded to is certain where no middle between two of them is within
// reach of both iterates' errors; these are bounded by Patch::bend, the last step and the rounding of the
// residual.
void solve_from_seeds(const Patch& patch, const PatchPool& pool, const RayLanes& rays, const SeedLanes& seeds,
                      SeededRoots& out);

// PatchSet::rules_out.
std::uint32_t lies_beside(const LeafBound& leaf, const RayLanes& rays, const double* param_u,
                          const double* param_v);

}  // namespace trimray::trace
