// Faces of triangles in the mesh of their prototype.
#pragma once

#include <array>
#include <unordered_map>

#include "core/nurbs/store.h"
#include "core/tess/tri_mesh.h"

namespace trimray::tess {

// Triangles of a file meet where their corners have the same coordinates, whichever face they belong to.
class MeshFaces {
 public:
  // Appends the face's own triangles; deviation 0.
  void add(const nurbs::NurbsStore& store, std::int32_t face, TriMesh& out);

 private:
  struct PlaceHash {
    std::size_t operator()(const std::array<double, 3>& p) const;
  };
  std::unordered_map<std::array<double, 3>, std::int32_t, PlaceHash> numbers_;  // of vertices
};

}  // namespace trimray::tess
