// The mesh of one face within its polygon.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/tess/curvature_tree.h"
#include "core/tess/face_polygon.h"

namespace trimray::tess {

struct FaceMesh {
  std::vector<std::array<VertexKey, 3>> triangles;
  std::vector<std::array<dvec2, 3>> corner_uv;  // uv_face
  std::vector<double> deviation;                // mm, proven
  std::vector<dvec3> own_vertices;
  // Segments of edges that must be halved before the face can do better: (edge, segment).
  std::vector<std::array<std::int32_t, 2>> split;
  std::vector<dvec2> found;  // inner points, in the chart, that it has learnt to need
  bool crossed = false;      // its sides cross
  std::string failure;       // why there are no triangles, or none that keep what is promised
};

// What earlier rounds found out about a face.
struct FaceHints {
  std::vector<dvec2> points;  // chart points that the mesh must have
  int crossings = 0;          // how often its sides have crossed
};

// Needs face.status kOk and a surface. tree: of the chart, null for planes.
FaceMesh mesh_face(const nurbs::NurbsStore& store, std::int32_t face, const Chart& chart,
                   const CurvatureTree* tree, const FacePolygon& polygon, const EdgeLimits& limits,
                   const FaceHints& hints);

// Covers the face whatever its loops are like: by what is left of them when sides may cross, else by a grid
// of uv_box less the cells that are certainly outside. Nothing is proven, nor closed.
FaceMesh cover_face(const nurbs::NurbsStore& store, std::int32_t face, const Chart& chart,
                    const FacePolygon& polygon);

}  // namespace trimray::tess
