// Stores of mesh faces: models that come as triangles.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/nurbs/store.h"

namespace trimray::nurbs {

// Triangles that make one face: from the end of the group before to `end`.
struct MeshGroup {
  std::int32_t end = 0;
  float color[4] = {Face::kNoColor, 0, 0, 1};  // sRGB-encoded, straight alpha; a negative red: none
};

// One prototype, one shell, one face a group, and one instance at the origin. mm. Throws ArgumentError when a
// coordinate is not finite (or beyond 1e12 mm), a corner names no vertex, or the groups do not cover the
// triangles in order, each with at least one. Vertices that no triangle uses are kept.
NurbsStore mesh_store(std::vector<dvec3> vertices, std::vector<Triangle> triangles,
                      std::span<const MeshGroup> groups, std::string meta);

// Finite, and no farther out than anything real.
bool sound_vertex(const dvec3& p);

// What is_mesh() promises of a face with these triangles; its surface is to be of kind kMesh.
void make_mesh_face(Face& face, Range triangles);

// Is every side of a triangle the side of exactly one other, turned round? If not as the corners are
// numbered, then with those at the same place taken for one. Triangles with twice the same corner do not
// count.
bool closes_up(std::span<const dvec3> vertices, std::span<const Triangle> triangles);

}  // namespace trimray::nurbs
