// A face's loops as polygons in its chart, made of the polylines that the face shares with its neighbours.
#pragma once

#include <vector>

#include "core/tess/edge_polyline.h"

namespace trimray::tess {

// Vertices of the mesh of a prototype: first the model's vertices, then the inner samples of its edges, edge
// by edge. A negative number -1 - k is the k-th point that a face has of its own.
// What a vertex of the mesh stands for, the same in all faces: a vertex of the model, an inner sample of an
// edge, or (negative, -1 - k) the k-th point that a face has of its own.
using VertexKey = std::int64_t;
inline constexpr VertexKey kInnerSample = VertexKey{1} << 60;
inline VertexKey inner_key(std::int32_t edge, int sample) {
  return kInnerSample + (VertexKey{edge} << 28) + sample;
}
inline std::int32_t key_edge(VertexKey key) { return static_cast<std::int32_t>((key - kInnerSample) >> 28); }
inline int key_sample(VertexKey key) { return static_cast<int>(key & ((VertexKey{1} << 28) - 1)); }

struct BoundaryPoint {
  dvec2 p{0.0};      // in the chart
  dvec3 place{0.0};  // the vertex
  VertexKey vertex = -1;
  // The side to the next point: a segment of an edge, or -1: the face's own.
  std::int32_t edge = -1, segment = -1;
  double side_deviation = kInf;  // of that side from the edge's curve, proven
};

struct FacePolygon {
  std::vector<std::vector<BoundaryPoint>> loops;
  Box2 box;                         // of all points, in the chart
  std::vector<dvec3> own_vertices;  // of natural borders, which have no edges
};

// What is known of a prototype's edges and vertices.
struct Wireframe {
  std::int32_t vertex_begin = 0, edge_begin = 0;
  std::vector<EdgePolyline> polylines;  // by edge, less edge_begin; empty where nothing is drawn
  std::vector<std::int32_t> one;        // by vertex, less vertex_begin: the first of those that are one place
  const EdgePolyline& polyline(std::int32_t edge) const { return polylines[edge - edge_begin]; }
};

FacePolygon make_polygon(const nurbs::NurbsStore& store, std::int32_t face, const Chart& chart,
                         const Wireframe& wireframe, const EdgeLimits& limits);

}  // namespace trimray::tess
