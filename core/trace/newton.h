// Newton iteration on one Bezier patch in SIMD lanes: the only code that turns a start into a root.
//
// A root of the line org + t dir on S(u, v) is a zero of (S - org) x dir. Every evaluation uses the whole
// patch's coefficients relative to the patch's origin, the ray re-originated at its point closest to that
// origin, and the homogeneous form P - w org, which has the same zeros and needs no division.
#pragma once

#include "core/trace/patch_data.h"

namespace trimray::trace {

// Newton steps before a lane is given up.
inline constexpr int kMaxNewtonSteps = 12;

// A converged iterate is rounded to this grid in patch parameters, and one full step from the grid point is
// the answer. Two starts that converge to the same root thus give the same bits, unless the root lies within
// rounding (1e-16) of the middle between two grid points: once in some 1e7 roots. Near a collapsed side the
// grid is finer in proportion to the distance from it.
inline constexpr double kRootGrid = 1.0 / (1 << 28);

// Roots this far outside a leaf, in patch parameters, still count as on it: neighbours overlap, so that
// rounding cannot hide a root from both.
inline constexpr double kLeafSlack = 1e-12;

// PatchSet::solve on one leaf. For offset patches misses only: their leaves' bounds claim no uniqueness.
void solve_leaf(const Patch& patch, const double* coef, const LeafBound& leaf, const RayLanes& rays,
                RootLanes& out);

// One polished root in patch parameters. The same code as in solve_leaf, on one lane: the same bits.
struct PatchRoot {
  double u = 0.0, v = 0.0, t = 0.0;
  dvec3 normal{0.0};  // unit, Su x Sv; not finite where that vanishes
};

// Newton from start, steps no longer than max_step in either parameter. False when it does not converge.
bool polish(const Patch& patch, const double* coef, const Ray& ray, dvec2 start, double max_step,
            PatchRoot& root);

// Name of the instruction set in use, for reports.
const char* simd_target_name();

}  // namespace trimray::trace
