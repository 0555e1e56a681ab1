// The edge paths of a store as the reference tracer sees them: how far a line keeps from a path, and how
// often a half-line from the line crosses it.
#pragma once

#include <vector>

#include "core/reference/line.h"

namespace trimray::reference {

// Vertex, link, pieces, link, vertex: rational Bezier curves that join end to end, in no particular order.
struct EdgePath {
  std::vector<std::vector<dvec4>> curves;
  std::vector<char> links;  // is it one?
  Box3 box;
  double band = 0.0;
};

EdgePath edge_path(const nurbs::NurbsStore& store, std::int32_t edge);

// A stretch of a path that runs within the band of a line.
struct NearStretch {
  std::int32_t edge = -1;
  double t_lower = 0.0, t_upper = 0.0;  // along the line, unit direction
  double t = 0.0, distance = kInf;      // at the closest point found
  int side =
      0;  // +1: the line passes left of the path there, seen along the line; 0: the path gives no direction
};

void near_stretches(const EdgePath& path, std::int32_t edge, const Line& line, std::vector<NearStretch>& out);

// Signed crossings of the path with a half-line fixed by the line alone.
int path_crossings(const EdgePath& path, const Line& line);

}  // namespace trimray::reference
