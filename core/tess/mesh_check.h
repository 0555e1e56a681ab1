// Is a mesh closed, manifold, oriented, without degenerate triangles?
#pragma once

#include "core/tess/tri_mesh.h"

namespace trimray::tess {

struct MeshCheck {
  std::int64_t open_edges = 0;          // sides of one triangle only
  std::int64_t non_manifold_edges = 0;  // sides of three or more triangles, or of two that run the same way
  std::int64_t non_manifold_vertices = 0;  // whose triangles form more than one fan
  std::int64_t degenerate_triangles = 0;   // a vertex twice, or a height below 1e-12 of the mesh's diagonal
  double volume = 0.0;                     // mm^3, signed; meaningful where there are no open edges
  double area = 0.0;                       // mm^2
};

MeshCheck check(const TriMesh& mesh);

}  // namespace trimray::tess
