// Edges as polylines that all their faces share.
#pragma once

#include <utility>
#include <vector>

#include "core/nurbs/store.h"
#include "core/tess/chart.h"
#include "core/tess/curvature_tree.h"
#include "core/tess/tolerance_field.h"

namespace trimray::tess {

// A hostile file must not fill the memory.
inline constexpr int kMostSegments = 20000;

// Of one edge. Samples run along the edge's path; the first and last are its vertices. A degenerate edge's
// samples all are its vertex.
struct EdgePolyline {
  std::vector<double> at;         // place on the path: piece index + the piece's own parameter
  std::vector<dvec3> points;      // mm
  std::vector<double> deviation;  // by segment, proven: between it and its part of the path, both ways
  int segments() const { return static_cast<int>(at.size()) - 1; }
};

// One use of an edge, as far as a polyline needs it.
struct EdgeUse {
  const Chart* chart = nullptr;
  const CurvatureTree* tree = nullptr;  // null where the face's kind needs none
  std::int32_t coedge = -1;
};

struct EdgeLimits {
  const ToleranceField* tolerance = nullptr;
  double angle = kInf;  // rad
};

// ends: where the vertices are put. As few samples as keep both the distance from the path and, in each face,
// the distance between the path and the surface along the chart's chord within the tolerance.
EdgePolyline make_polyline(const nurbs::NurbsStore& store, const nurbs::Edge& edge, const dvec3 (&ends)[2],
                           const std::vector<EdgeUse>& uses, const EdgeLimits& limits);

// Cuts segments at places of the path: (segment, place), sorted, a segment once.
using Cut = std::pair<int, double>;
void split_segments(const nurbs::NurbsStore& store, const nurbs::Edge& edge, const std::vector<Cut>& cuts,
                    EdgePolyline& line);

// Where a sample lies in a face's chart: the foot of its point near the p-curve's point at the same
// parameter. At poles the p-curve's own place along the collapsed direction.
dvec2 sample_in_chart(const nurbs::NurbsStore& store, const Chart& chart, const nurbs::CoEdge& coedge,
                      double at, const dvec3& point);

// The p-curve's point at a place of the edge's path, in uv_face.
dvec2 pcurve_point(const nurbs::NurbsStore& store, const nurbs::CoEdge& coedge, double at);

}  // namespace trimray::tess
