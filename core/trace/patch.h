// Bezier patches of the faces that have no closed form, cut into leaves for the hierarchy, and the one kernel
// that finds and polishes roots on them. Every path of the tracer (standard, later hybrid) uses this kernel.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/box.h"
#include "core/nurbs/store.h"
#include "core/trace/ray.h"

namespace trimray::trace {

// A part of one Bezier patch small enough that most rays meet it at most once. Boxes are conservative:
// control hull of the sub-patch, the offset where there is one, and rounding. Neighbouring leaves overlap
// slightly in uv so that no root falls between them; leaves at the rim of a face reach beyond its uv_box
// by at least the largest band of the face's edges, so that a root just outside the trim is still found.
struct PatchLeaf {
  Box3 box;
  Box2 uv_face;  // the part of the surface it answers for
  std::int32_t face = kNoFace;
  std::int32_t patch = -1;  // internal to PatchSet
  std::int32_t sub = -1;    // internal to PatchSet
};

// What solve() is certain of, a bit a lane. Lanes of `active` in neither mask are not decided: open_roots().
struct RootLanes {
  alignas(64) double t[kLanes], u[kLanes], v[kLanes];  // valid where one; u, v are uv_face
  alignas(64) double normal_x[kLanes], normal_y[kLanes],
      normal_z[kLanes];                                 // Su x Sv, unit, not yet turned outward
  std::uint32_t one = 0;                                // exactly one root on this leaf, polished
  std::uint32_t none = 0;                               // certainly no root on this leaf
  std::uint32_t steps = 0;                              // Newton steps taken, for the counters
  alignas(64) double param_u[kLanes], param_v[kLanes];  // where one: the root in parameters of `patch`
  std::int32_t patch = -1;                              // the leaf's
};

// Starts for Newton's method, a lane each, in uv_face. Anything goes: a wrong one costs time.
struct SeedLanes {
  alignas(64) double u[kLanes], v[kLanes];
};

// What solve_seeded() is certain of. Lanes that are not in `one` say nothing.
struct SeededRoots {
  alignas(64) double t[kLanes], u[kLanes], v[kLanes];  // as in RootLanes
  alignas(64) double normal_x[kLanes], normal_y[kLanes], normal_z[kLanes];
  alignas(64) double param_u[kLanes], param_v[kLanes];
  std::int32_t leaf[kLanes];  // where the root lies, of this patch
  std::uint32_t one = 0;      // leaf[i] has exactly one root on the line of ray i, and this is it
  std::uint32_t steps = 0;    // Newton steps taken, for the counters
};

// Two reports of one root: a root on a knot line is found on both of its patches, one on a seam at both ends
// of the period, one at a pole at any u, and the polished numbers may differ: by their last bits, or where
// the line grazes one side of a crease, by what kLeafSlack is worth along it. A surface cannot be crossed
// twice in the same direction without being crossed back in between, so the face, the sign and t settle it,
// of neighbours in the order of t. diagonal: of the prototype, mm.
inline bool same_root(const Root& a, const Root& b, double diagonal) {
  return a.face == b.face && a.sign == b.sign &&
         std::fabs(a.t - b.t) <= 1e-9 * diagonal + 1e-14 * std::fabs(a.t);
}

// A root of one lane.
struct LaneRoot {
  int lane = 0;
  Root root;
};

// Lanes that solve() has left open on one leaf, gathered from several calls: open_roots() wants full lanes.
struct OpenLanes {
  RayLanes rays = {};
  int index[kLanes];  // the caller's, of each lane
  int count = 0;
  void add(const RayLanes& from, int i, int caller_index) {
    copy_lane(from, i, rays, count);
    index[count++] = caller_index;
    rays.active = (1u << count) - 1u;
  }
};

// How often all_roots() has returned false on this thread: callers count by the difference.
std::uint64_t searches_given_up();

// How small leaves are made: a surface is cut into at least `parts` x `parts` leaves, each no farther from
// flat than the fraction `flatness` of the surface's size, and so that each is proven to have one root for
// rays that make an angle with its tangent plane whose sine is above `sine`.
struct LeafDetail {
  int parts = 1;
  double flatness = kInf;
  double sine = 0.25;
};

class PatchSet {
 public:
  // Patches of all faces of one prototype that need them: kExtrusion, kRevolution, kBezier, kBspline,
  // kOffset. margin_mm[face - prototype.faces.begin]: how far, in mm, leaves must reach beyond the face's
  // uv_box.
  PatchSet(const nurbs::NurbsStore& store, std::int32_t prototype, std::span<const double> margin_mm,
           int threads = 0, const LeafDetail& detail = {});
  PatchSet(PatchSet&&) noexcept;
  ~PatchSet();

  std::span<const PatchLeaf> leaves() const;
  // A box along the leaf's own directions that holds it: as closed_form_oriented_box, but skewed.
  OrientedBox oriented_box(std::int32_t leaf) const;
  std::int64_t bytes() const;

  // Bezier patches that are missing because a weight is not positive. 0 for every surface whose weights are.
  std::int64_t refused() const;

  // SIMD: rays against one leaf, on the whole line (no t limits). A root is reported by polish() from its
  // last Newton step, so the same root found through a neighbouring leaf or from another seed has the same
  // bits.
  void solve(std::int32_t leaf, const RayLanes& rays, RootLanes& out) const;

  // The patch of `face` whose part of the surface holds uv_face, or one near it; -1 for a face without
  // patches. Time: the logarithm of the number of knot spans.
  std::int32_t patch_at(std::int32_t face, dvec2 uv_face) const;

  // Newton's method from seeds on one patch, on the whole line. Where `one` is set, the uniqueness proof of
  // leaf[i] holds for ray i, its root has been found, and its numbers are to the last bit those that
  // solve(leaf[i]) reports for it, or all_roots() where solve() leaves the leaf open. Lanes for which that is
  // not certain are left out: solve() is for them. Never set on offset patches.
  void solve_seeded(std::int32_t patch, const RayLanes& rays, const SeedLanes& seeds, SeededRoots& out) const;

  // Active lanes whose root, at param_u, param_v of the leaf's own patch, lies beside the leaf but within
  // reach of its uniqueness proof: the leaf has no root on that line. The parameters are those of
  // solve_seeded() or solve() on that patch, of lanes where one; they are read on the other lanes, too.
  std::uint32_t rules_out(std::int32_t leaf, const RayLanes& rays, const double* param_u,
                          const double* param_v) const;

  // Scalar, certain: appends every root of the line on the leaf (Bezier clipping on the distance net, Nishita
  // 1990, with subdivision; offsets by interval subdivision), each polished. Two roots closer than rounding
  // can tell (a tangent ray) are dropped together. Sets t, uv_face, normal (outward), face and sign; leaves
  // inside false. False, and roots may be missing, where the search was given up: only for a line that lies
  // in the surface.
  bool all_roots(std::int32_t leaf, const Ray& ray, std::vector<Root>& out) const;

  // SIMD: appends what all_roots() finds on the lines of the active lanes, a lane's roots in no particular
  // order. For the lanes that solve() leaves open. Returns how many scalar searches that took.
  int open_roots(std::int32_t leaf, const RayLanes& rays, std::vector<LaneRoot>& out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trimray::trace
