// The trim loops of one face, cut into segments that are monotone in u and in v.
#pragma once

#include <cstdint>
#include <vector>

#include "core/nurbs/store.h"

namespace trimray::nurbs {

// A piece of a trim loop, turned so that it runs upwards in v, from lo to hi (lo.y < hi.y; horizontal parts
// are never crossed by the horizontal test ray and are left out). Where two pieces meet, both hold the same
// bits, so the half-open rule lo.y <= v < hi.y counts a joint once.
struct alignas(64) TrimSegment {
  dvec2 lo, hi;
  // Every point c of the curve has cross(hi - lo, c - lo) in [cross_min, cross_max]; both 0 for a line.
  double cross_min = 0.0, cross_max = 0.0;
  std::uint32_t ctrl = 0;  // first control point, from lo to hi; lines have none
  std::int32_t degree = 1;
};

struct TrimSegments {
  std::vector<TrimSegment> segments;
  std::vector<dvec3> ctrl_h;  // (w u, w v, w)
  Box2 box;                   // of every loop, tight
};

// All loops of a face as closed curves: a piece's end is joined to the next one's start by a straight line
// wherever they differ, seam jumps included.
// Throws ArgumentError for a degree above kMaxPieceDegree.
TrimSegments cut_trim_loops(const NurbsStore& store, std::int32_t face);

// Whether the segment's point at height v lies strictly to the right of u, for lo.y <= v < hi.y.
// The slow path: bisection that ends when both ends lie on one side of u.
bool curve_is_right(const TrimSegment& segment, const dvec3* ctrl_h, dvec2 uv);

// The same, decided by the chord and its band whenever they can.
inline bool segment_is_right(const TrimSegment& s, const dvec3* ctrl_h, dvec2 uv) {
  const double cross = (s.hi.x - s.lo.x) * (uv.y - s.lo.y) - (s.hi.y - s.lo.y) * (uv.x - s.lo.x);
  if (cross > s.cross_max) return true;
  if (cross < s.cross_min || s.degree == 1) return false;
  return curve_is_right(s, ctrl_h, uv);
}

}  // namespace trimray::nurbs
