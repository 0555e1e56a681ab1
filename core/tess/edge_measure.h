// Which sides of a mesh lie on which edges of the model, and how far the exact edges are from them: a judge
// of meshes, not part of their making.
#pragma once

#include <cstdint>
#include <vector>

#include "core/nurbs/store.h"
#include "core/tess/tri_mesh.h"

namespace trimray::tess {

// A side of a triangle where its face ends: next to another face, to itself across a seam, or to nothing.
struct BorderSide {
  std::int32_t triangle = -1, corner = -1;  // the side starts at this corner
  std::int32_t edge = -1;                   // NurbsStore::edges; -1: it lies on no edge of its face
  bool open = false;                        // no other triangle beside it
  double from = 0.0, to = 0.0;              // where its ends lie on the edge, in pieces: [0, pieces.size()]
  double edge_to_side = 0.0;  // mm: largest distance of the edge's points between them from the side
  double side_to_edge = 0.0;  // mm: largest distance of the side's points from the edge
};

struct EdgeMeasure {
  std::vector<BorderSide> sides;
  // By edge of the store, mm: length of its uses by faces that have triangles, and how much of it no side (or
  // more than one side a use) lies on. Edges without such uses have 0.
  std::vector<double> length, missing;
};

// Every border side of the mesh of a prototype, each measured at `points` places. Throws ArgumentError for a
// mesh that does not fit the store.
EdgeMeasure measure_edges(const nurbs::NurbsStore& store, const TriMesh& mesh, int points = 16,
                          int threads = 0);

}  // namespace trimray::tess
