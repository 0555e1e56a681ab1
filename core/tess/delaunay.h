// Constrained Delaunay triangulation of polygons with holes and inner points, by the library CDT.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "core/base/types.h"

namespace trimray::tess {

struct Delaunay {
  enum class Outcome {
    kDone,
    kCrossing,  // sides cross or touch: see crossings
    kFailed,    // no triangles at all
  };
  Outcome outcome = Outcome::kFailed;
  std::vector<std::array<int, 3>> triangles;   // counter-clockwise, what lies inside by the even-odd rule
  std::vector<std::pair<int, int>> crossings;  // indices of sides
};

// points: all different. sides: index pairs; a side that stands there twice has material on both sides or on
// none.
Delaunay triangulate(const std::vector<dvec2>& points, const std::vector<std::array<int, 2>>& sides);

// The same where sides may cross: new points are made there and appended to points.
Delaunay triangulate_crossing(std::vector<dvec2>& points, const std::vector<std::array<int, 2>>& sides);

}  // namespace trimray::tess
