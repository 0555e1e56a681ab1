// Where a face's grid has points: inside its polygon and not too near to it.
#pragma once

#include <vector>

#include "core/tess/curvature_tree.h"
#include "core/tess/face_polygon.h"

namespace trimray::tess {

// Grid points of the tree's leaves in the chart.
std::vector<dvec2> inner_points(const CurvatureTree& tree, const FacePolygon& polygon);

}  // namespace trimray::tess
