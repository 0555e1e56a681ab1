// A face's wires as closed loops of p-curves in uv_face: ordered, brought into one period, closed.
//
// What real files leave out is put in: the p-curve along a pole, the seam of a band around a cylinder, the
// way from a single rim to a pole. These synthetic co-edges use synthetic edges that only this face knows, so
// that they count nothing in any winding number:
//
//        v ^   B <------------- B          rims A and B wind around; the seam is used
//          |   |                ^          up on the right and down on the left
//          |   v   seam         |  seam
//          |   A -------------> A + period
//          +------------------------> u
#pragma once

#include <functional>
#include <vector>

#include "core/nurbs/loop_work.h"
#include "core/nurbs/shape_walk.h"
#include "core/nurbs/surface_source.h"

namespace trimray::nurbs {

// An edge that only one face knows. path: empty for a pole or for a copy of other curves.
struct SyntheticEdge {
  Pieces3 path;
  dvec3 end[2] = {dvec3(0.0), dvec3(0.0)};
  bool degenerate = true;
};

struct FaceLoops {
  FaceStatus status = FaceStatus::kOk;
  std::vector<LoopWork> loops;
  std::vector<SyntheticEdge> synthetic;
  Box2 uv_box;  // of the loops; a full turn at most in periodic directions
  bool iso_rectangle = false;
};

// One use of an edge with its p-curve, as the wire stores it.
struct WireUse {
  CoEdgeWork coedge;
  std::int32_t start_vertex = -1, end_vertex = -1;  // WalkVertex, in loop direction
  double tolerance = 0.0;                           // of the edge, mm
};

// Evaluates the face's surface wherever a loop may reach.
using SurfaceAt = std::function<dvec3(dvec2 uv_face)>;

// natural: the surface's domain; periods: 0 where not periodic.
FaceLoops close_loops(std::vector<std::vector<WireUse>> wires, const SurfaceAt& surface, const Box2& natural,
                      dvec2 periods);

}  // namespace trimray::nurbs
