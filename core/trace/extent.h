// How far a model reaches: its tight box, and a few points that stand for its outline from every side.
#pragma once

#include <vector>

#include "core/nurbs/store.h"

namespace trimray::trace {

// bounds: of all drawable faces of all instances, in the world, mm. Each side is reached by an edge curve or
// by a point inside a face where the surface's normal is parallel to the axis, polished to 1e-12 of the size;
// the points to polish are found on a sampling grid (degree + 1 steps a knot span), so a bump narrower than
// that grid that reaches farther than everything else is not promised to be seen. points: on the model, the
// farthest in each of 1024 directions and on each side of bounds; what a camera is fitted to. A round outline
// between two of the directions stands out by at most 0.3 % of its radius. What lies a billion times the size
// of the median edge or face away from the rest counts for neither: one face with damaged coordinates must
// not blank a model. Both are empty when no face can be drawn.
struct Extent {
  Box3 bounds;
  std::vector<dvec3> points;
};

Extent model_extent(const nurbs::NurbsStore& store, int threads = 0);

// Point of an edge's piece at t in [0, 1] (de Casteljau), in the prototype's coordinates.
dvec3 edge_piece_point(const nurbs::NurbsStore& store, const nurbs::CurvePiece& piece, double t);

}  // namespace trimray::trace
