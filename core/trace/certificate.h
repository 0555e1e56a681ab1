// What can be proven about a leaf once, for all rays.
//
// None. The leaf lies in the hull of its control points, and that in a parallelepiped along its own tangents
// and normal: a line that is separated from it by one of the three axes dir x edge misses the leaf.
//
// One. Let e be the point of the leaf where a line meets it; its roots are the zeros across the line of the
// polynomial F = P - w e. Two roots x, y give M (x - y) parallel to dir, where the columns of M are means of
// F_u = P_u - w_u e and F_v over the segment between them. Their control points, widened by what e may be,
// span boxes U and V; all products U x V lie in a cone about the normal n. A line with |n . dir| above the
// sine of the cone's half angle has (M_u x M_v) . dir != 0, so x = y. The same with the cone over a
// parallelogram along n x a and n x b, which serves leaves that bend in one direction only. Proven on the
// leaf extended by kExtend, so that a root beside the leaf proves that there is none on it.
#pragma once

#include "core/trace/patch_data.h"

namespace trimray::trace {

// A part of a patch, in patch parameters.
struct SubDomain {
  double u0, u1, v0, v1;
};

struct LeafProof {
  LeafBound bound;
  Box3 box;           // of the control hull, relative to Patch::origin; offset included
  double sine = 2.0;  // uniqueness holds where |n.d| exceeds it; above 1: never
  double tilt_a = kInf,
         tilt_b = kInf;               // the parallelogram: largest parts along n x a, n x b over that along n
  double bend_u = 0.0, bend_v = 0.0;  // what halving the leaf in u or v would win; only their order matters
};

// net: the patch's Bernstein control points. Rounding is covered by widening the bounds by 1e-9 of
// themselves.
LeafProof prove_leaf(const Patch& patch, const dvec4* net, const SubDomain& domain);

}  // namespace trimray::trace
