// The rational Bezier patches of a surface's NURBS form, by knot insertion.
#pragma once

#include <vector>

#include "core/base/box.h"
#include "core/nurbs/store.h"

namespace trimray::nurbs {

// Patch k = iu * spans_v + iv has control points ctrl_h[k * points() ...], [i * (degree_v + 1) + j], and
// covers uv_face[k], a box between knots; inside, its own [0, 1]^2 is linear in the NURBS parameter.
struct BezierPatches {
  int degree_u = 0, degree_v = 0;
  int spans_u = 0, spans_v = 0;
  std::vector<Box2> uv_face;
  std::vector<dvec4> ctrl_h;
  int points() const { return (degree_u + 1) * (degree_v + 1); }
};

// kMesh and kNone give no patch. For kOffset these are the basis surface's patches.
BezierPatches bezier_patches(const NurbsStore& store, const Surface& surface);

}  // namespace trimray::nurbs
