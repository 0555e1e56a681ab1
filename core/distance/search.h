// The nearest point on one rational Bezier net, curve or surface, by branch and bound.
#pragma once

#include <algorithm>
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

inline bool by_bound(const Part& a, const Part& b) { return a.bound > b.bound; }

inline void push_part(Workspace& work, const Part& part) {
  work.heap.push_back(part);
  std::push_heap(work.heap.begin(), work.heap.end(), by_bound);
}

// Branch and bound over `whole`. examine(domain, inside) looks at one part: it drops it, settles it, or puts
// it on the heap, and is true when it found something nearer; wanted() is the distance, mm, from which on
// nothing need be found; cost: what halving a part takes of parts_left. True when something nearer was found.
template <class Examine, class Wanted>
bool search_parts(const Domain& whole, bool inside, int cost, Workspace& work, const Wanted& wanted,
                  const Examine& examine) {
  work.heap.clear();
  bool found = examine(whole, inside);
  while (!work.heap.empty()) {
    std::pop_heap(work.heap.begin(), work.heap.end(), by_bound);
    const Part part = work.heap.back();
    work.heap.pop_back();
    if (!(part.bound < wanted())) break;
    if (work.parts_left <= 0) {
      work.unsearched = std::min(work.unsearched, part.bound);
      break;
    }
    work.parts_left -= cost;
    const Domain& d = part.domain;
    Domain low = d, high = d;
    if (part.halve_u)
      low.u1 = high.u0 = 0.5 * (d.u0 + d.u1);
    else
      low.v1 = high.v0 = 0.5 * (d.v0 + d.v1);
    found = examine(low, part.inside) || found;
    found = examine(high, part.inside) || found;
  }
  return found;
}

}  // namespace trimray::distance
