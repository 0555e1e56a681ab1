// The nearest point on one rational Bezier net, curve or surface, by branch and bound.
#pragma once

#include <vector>

#include "core/distance/bezier_net.h"

namespace trimray::distance {

// A rectangle of a net's [0, 1]^2.
struct Domain {
  double u0 = 0.0, u1 = 1.0, v0 = 0.0, v1 = 1.0;
};

struct Foot {
  double u = 0.0, v = 0.0;
  dvec3 p{0.0};
  double square = kInf;  // of the distance
};

// Half the squared distance from q, minimized over the rectangle from a start: Newton's method where the
// Hessian is positive, else downhill, never leaving the rectangle. Certain where it is convex there.
Foot descend(const dvec4* net, int du, int dv, const Domain& in, const dvec3& q, double u, double v);

// A critical point of the distance from q in the rectangle, of any kind, by Newton's method from its middle;
// square is kInf where it does not get to one. settled: it did.
struct Critical {
  Foot foot;
  bool settled = false;
};
Critical critical_point(const dvec4* net, int du, int dv, const Domain& in, const dvec3& q);

// A part of a net that may still hold something nearer. Kept in a heap, the nearest bound on top.
struct Part {
  Domain domain;
  double bound = 0.0;   // mm
  bool inside = false;  // certainly within the trim loops
  bool halve_u = true;
};

// What a search reads and leaves; one a thread, used again.
struct Workspace {
  std::vector<Part> heap;
  std::vector<dvec4> net;
  std::vector<double> coefficients;
  NetBound bound;
  int parts_left = 0;        // of kMaxParts
  double unsearched = kInf;  // least bound of what was given up
};

}  // namespace trimray::distance
