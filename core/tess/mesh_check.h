// Is a mesh closed, manifold, oriented, without degenerate triangles?
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tess/tri_mesh.h"

namespace trimray::tess {

struct MeshCheck {
  std::int64_t open_edges = 0;          // sides of one triangle only
  std::int64_t non_manifold_edges = 0;  // sides of three or more triangles, or of two that run the same way
  std::int64_t non_manifold_vertices = 0;  // whose triangles form more than one fan
  std::int64_t degenerate_triangles = 0;   // a vertex twice, or a height below 1e-12 of the mesh's diagonal
  double volume = 0.0;                     // mm^3, signed; meaningful where there are no open edges
  double area = 0.0;                       // mm^2

  bool closed() const { return open_edges == 0 && non_manifold_edges == 0; }
};

// A height below this fraction of the mesh's diagonal makes a triangle degenerate.
inline constexpr double kDegenerateHeight = 1e-12;

// Triangles that name a vertex twice count as degenerate and take part in nothing else. Throws ArgumentError
// for a vertex that does not exist.
MeshCheck check(std::span<const dvec3> vertices, std::span<const std::array<std::int32_t, 3>> triangles);
MeshCheck check(const TriMesh& mesh);

// The smallest height of a triangle, 0 where two vertices coincide.
double smallest_height(const dvec3& a, const dvec3& b, const dvec3& c);

}  // namespace trimray::tess
