// What can be proven about a leaf once, for all rays.
//
// Let x in [-1, 1]^2 run over the leaf, C = S(0), A = S_u, B = S_v there (per half width), N = A x B. Over the
// leaf extended by kExtend let the second derivatives be bounded, separately in the tangent plane (t) and
// along the normal (n): |S_uu| <= U_t, U_n and so on. Then S = C + A x_u + B x_v + r with |r_t|, |r_n| <= R_t, R_n,
// and the tangents stay within (a_t, a_n), (b_t, b_n) of A, B.
//
// None. At a root q = C - o satisfies (q + A x_u + B x_v + r) x d = 0, so x_u N.d = g.B + (r x B).d (up to sign,
// g = q x d) and |(r x B).d| <= |B| (R_t |N.d| / |N| + R_n): the in-plane part of r turns into a multiple of the
// normal, the normal part into an in-plane vector. |g.B| beyond |N.d| (1 + |B| R_t / |N|) + |B| R_n is a miss.
//
// One. Two roots x, y give M (x - y) x d = 0 where the columns of M are means of tangents over the segment
// between them, inside the same balls. (M_u x M_v).d is N.d up to T |N.d| / |N| along the normal and Q in the plane:
//   T = a_t |B| + b_t |A| + a_t b_t,   Q = (|A| + a_t) b_n + (|B| + b_t) a_n.
// So |n.d| (|N| - T) > Q sqrt(1 - (n.d)^2), n = N / |N|, leaves no two roots.
#pragma once

#include "core/trace/patch_data.h"

namespace trimray::trace {

// A part of a patch, in patch parameters.
struct SubDomain {
  double u0, u1, v0, v1;
};

struct LeafProof {
  LeafBound bound;
  double sine = 2.0;           // uniqueness holds where |n.d| exceeds it; above 1: never
  double bend_u = 0.0, bend_v = 0.0;  // what halving the leaf in u or v would win; only their order matters
};

// net: the patch's Bernstein control points. Rounding is covered by widening the bounds by 1e-9 of themselves.
LeafProof prove_leaf(const Patch& patch, const dvec4* net, const SubDomain& domain);

// Box of the part's control hull, relative to Patch::origin, offset included.
Box3 hull_box(const Patch& patch, const dvec4* net, const SubDomain& domain);

}  // namespace trimray::trace
