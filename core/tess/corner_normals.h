// Normals for file formats and shading: exact, smooth where faces meet tangentially, sharp at creases.
#pragma once

#include <vector>

#include "core/nurbs/store.h"
#include "core/tess/tri_mesh.h"

namespace trimray::tess {

// Normals that turn by more than this (rad) from one triangle's corner to its neighbour's form a crease.
inline constexpr double kCreaseAngle = 0.035;

// Outward unit normals of the corners, 3 a triangle. Each is the surface's own at the corner's uv, at a pole
// its limit from within the triangle; around a vertex those that agree are averaged by the triangles'
// angles, so that both sides of a smooth edge get the same bits. Triangles of mesh faces, and of faces that
// cannot be evaluated, take their plane's normal. Throws ArgumentError for a mesh that does not fit the
// store.
std::vector<dvec3> corner_normals(const nurbs::NurbsStore& store, const TriMesh& mesh, int threads = 0);

}  // namespace trimray::tess
