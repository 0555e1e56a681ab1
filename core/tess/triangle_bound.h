// The proven distance of a triangle from its surface.
#pragma once

#include "core/tess/chart.h"
#include "core/tess/curvature_tree.h"

namespace trimray::tess {

struct TriangleBound {
  // mm; no point of the triangle is farther from the (untrimmed) surface. Of offset surfaces this is an
  // estimate from samples: their second derivatives have no bound here.
  double deviation = kInf;
  // What each side would deviate alone (0: corners 0 and 1, 1: 1 and 2, 2: 2 and 0).
  double side[3] = {kInf, kInf, kInf};
  double kinks = 0.0;  // the part of the deviation that kinks inside are to blame for
};

// enough: where the deviation is above it, how far above does not matter.
// p: corners in the chart; s: the surface's points there. The triangle lies on s; one whose corners are up to
// d away from s is up to deviation + d away from the surface. tree: of the face; not asked where the closed
// form of plane, cylinder, cone or sphere is enough (needs_tree).
//
// General surfaces: with D the difference of the surface and its linear interpolation over the chart's
// triangle, and q the second derivative along a side, a component of D is at most half of what the
// interpolation of a quadratic gives (Filip, Magedson, Markot: "Surface algorithms using bounds on
// derivatives", CAGD 3, 1986, sharpened by the exact maximum over the triangle). The component along the
// triangle's normal is the distance; those within its plane only say by how much the surface's points are
// shifted sideways, and where that shift is small against the triangle, every point of the triangle has a
// point of the surface right above it (Brouwer).
TriangleBound bound_triangle(const Chart& chart, const CurvatureTree* tree, const dvec2 p[3],
                             const dvec3 s[3], double enough = kInf);

// Does bound_triangle ask the tree?
bool needs_tree(nurbs::SurfaceKind kind);

}  // namespace trimray::tess
