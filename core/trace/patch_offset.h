// Roots on an offset surface S + offset n, n = S_u x S_v / |S_u x S_v|, which has no Bezier form.
#pragma once

#include <vector>

#include "core/trace/certificate.h"
#include "core/trace/clipping.h"
#include "core/trace/newton.h"
#include "core/trace/patch_data.h"
#include "core/trace/patch_interval.h"

namespace trimray::trace {

// The offset surface over a box of parameters, enclosed with interval arithmetic from its base's control
// nets. The parameters (x, y) run over [0, 1]^2 of the box; where the box touches a collapsed side they are
// turned so that this side is y = 0, and the enclosure of the normal is that of (S_x / y) x S_y, which does
// not vanish there.
struct OffsetBox {
  dvec3 center{0.0};  // what base and middle are relative to
  dmat3 frame{
      1.0};        // turns directions into the frame of the intervals, along the surface's tangent and normal
  Interval3 base;  // S
  bool swapped = false;  // x is v
  bool regular = false;  // below is set: the normal does not vanish anywhere on the box
  Interval3 normal;      // n
  Interval3 px, py;      // derivatives of S + offset n
  dvec3 middle{0.0};     // S + offset n at (1/2, 1/2)
  double error = 0.0;    // of it
};
// domain widened on every side, but not across a collapsed side: the surface turns back over itself there.
SubDomain widened(const Patch& patch, const SubDomain& domain, double by_u, double by_v);
OffsetBox enclose_offset(const Patch& patch, const dvec4* net, const SubDomain& domain);

// Point, derivatives and the base's normal at patch parameters (u, v); the point relative to Patch::origin.
struct OffsetJet {
  dvec3 p, pu, pv, normal;
  double error;  // of p, mm: rounding turns the normal the further, the shorter the tangents are
};
OffsetJet offset_jet(const Patch& patch, const dvec4* net, double u, double v);

// Boxes examined before a search is given up: a line in the surface, or one that passes
// the offset of a collapsed side's point nearer than some 1e-3 of the offset.
inline constexpr int kMaxOffsetBoxes = 16384;

// Appends the roots of the ray's whole line on the leaf, by subdivision. A box is dropped when its enclosure,
// or the linear bound from its middle, misses the line; Newton takes over where the enclosed Jacobian proves
// that there is at most one root. As for clip_roots, roots closer than rounding can tell are dropped
// together.
ClipStats offset_roots(const Patch& patch, const PatchPool& pool, const LeafBound& leaf, const Ray& ray,
                       std::vector<PatchRoot>& roots);

}  // namespace trimray::trace
