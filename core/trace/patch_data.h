// What a PatchSet holds, for the files that build it (patch_build), search it (newton, clipping) and prove
// things about it (certificate). Internal to core/trace.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/box.h"
#include "core/nurbs/store.h"
#include "core/trace/patch.h"

namespace trimray::trace {

inline constexpr int kMaxPowerDegree = 5;  // above, Bernstein form: the power basis loses digits

// From a patch's own parameter x in [0, 1] to uv_face in one direction. x is linear in the NURBS parameter
// s = s0 + x ds, which lies (but for extrapolation) in the knot interval [a, a + d].
struct ParamCurve {
  nurbs::ParamMap map = nurbs::ParamMap::kIdentity;
  double s0 = 0.0, ds = 1.0;
  double a = 0.0, d = 1.0;
  double to_face(double x) const;
  double from_face(double u) const;
};

enum Side : std::uint8_t { kSideU0 = 1, kSideU1 = 2, kSideV0 = 4, kSideV1 = 8 };

// One Bezier patch, never cut: roots of all its leaves are polished on this one form.
struct Patch {
  std::int32_t face = kNoFace;
  std::uint8_t degree_u = 1, degree_v = 1;
  bool rational = false, power = true, reversed = false;
  std::uint8_t poles = 0;   // sides that collapse to a point
  double size = 0.0;        // diagonal of the control hull, mm
  double pole_reach = 0.0;  // a line that passes a collapsed side's point this near meets the side, mm; the
                            // same for all patches of a face, so that those around a pole agree
  double offset = 0.0;
  double max_weight = 1.0;  // of net; the first is 1
  double bend = 0.0;        // half the second derivative of P - w o, for o on the patch, along steps of 1 in
                            // both parameters: what a Newton step leaves is at most bend * step^2, mm
  double bend_uu = 0.0, bend_vv = 0.0;  // the parts of `bend` along u and v alone
  std::int32_t cells = 0;  // PatchPool::leaf_cells: 2^log_u rows of 2^log_v, each as LeafSplit::child
  std::uint8_t log_u = 0, log_v = 0;
  dvec3 origin{0.0};      // everything below is relative to it
  std::int64_t net = 0;   // PatchPool::net: Bernstein control points (wx, wy, wz, w), [i][j]
  std::int64_t coef = 0;  // PatchPool::coef: 4 doubles each, [i][j]; power basis in (u - 1/2, v - 1/2) or
                          // the Bernstein points once more
  ParamCurve u, v;
};

// A leaf's share of the certificate; see certificate.h for the proof.
struct alignas(64) LeafBound {
  // The leaf lies in the parallelepiped {center + a x + b y + k z : |x|, |y|, |z| <= 1}; a and b are tangents
  // at its middle, k runs along the normal. Relative to Patch::origin.
  double center[3], a[3], b[3], k[3];
  double ab[3], ak[3], bk[3];           // a x b, a x k, b x k
  double mid_u, mid_v, half_u, half_v;  // in patch parameters
  // At most one root on the leaf extended by kExtend where |ab . dir| is above `unique`, or above
  // unique_a |ak . dir| + unique_b |bk . dir|.
  double unique, unique_a, unique_b;
};

// Where a patch, or a part of it, was halved. child: PatchPool::splits, or ~leaf.
struct LeafSplit {
  float at =
      0.0f;  // rounded, unless the cut was a halving: a root that near it may be looked for on the wrong side
  bool in_u = false;
  std::int32_t child[2] = {-1, -1};  // below `at`, above it
};

// A face's patches in rows and columns of its uv.
struct PatchGrid {
  std::int32_t count_u = 0, count_v = 0;
  std::int64_t breaks = 0;  // PatchPool::breaks: count_u - 1 of u, then count_v - 1 of v, uv_face, increasing
  std::int64_t cells = 0;   // PatchPool::cells: [i][j]
};

// The uniqueness proof covers the leaf widened by this factor about its middle.
inline constexpr double kExtend = 1.3;

// Patch::pole_reach as a fraction of the largest patch of the face.
inline constexpr double kPoleReach = 1e-10;

struct PatchPool {
  std::vector<Patch> patches;
  std::vector<dvec4> net;
  std::vector<double> coef;
  std::vector<LeafBound> bounds;  // by leaf
  std::vector<PatchLeaf> leaves;
  std::vector<LeafSplit> splits;
  std::vector<std::int32_t> leaf_cells;
  std::vector<PatchGrid> grids;  // by face
  std::vector<double> breaks;
  std::vector<std::int32_t> cells;  // patches; -1 only in faces without any
  std::int64_t refused = 0;         // patches with a weight that is not positive, even without the margin
};

struct PatchSet::Impl : PatchPool {
  std::int32_t first_face = 0;
};

}  // namespace trimray::trace
