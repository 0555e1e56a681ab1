// Ranges of a surface's derivatives over a box of its chart: what the proven deviations are made of.
#pragma once

#include "core/nurbs/store.h"
#include "core/tess/interval.h"

namespace trimray::tess {

// Every value of the second derivatives lies in the boxes; |Su| <= su, |Sv| <= sv.
struct DerivativeRange {
  Box3 uu, uv, vv;
  double su = 0.0, sv = 0.0;
  void add(const DerivativeRange& r) {
    uu.add(r.uu), uv.add(r.uv), vv.add(r.vv);
    su = std::max(su, r.su), sv = std::max(sv, r.sv);
  }
};

// Plane ... torus, from their formulas.
DerivativeRange closed_form_range(const nurbs::Surface& surface, const Box2& box);

// A rational Bezier patch over a box of the given extent: hulls of the derivatives' control points, the
// quotient rule in interval arithmetic, relative to a point of the patch. net[i * (degree_v + 1) + j];
// A weight that is not positive makes the ranges infinite.
DerivativeRange patch_range(const dvec4* net, int degree_u, int degree_v, dvec2 extent, bool rational);

}  // namespace trimray::tess
