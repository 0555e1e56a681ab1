// The half-edge mesh of a TriMesh, and its improvement by edge flips.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include <OpenMesh/Core/Mesh/Traits.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "core/tess/tri_mesh.h"

namespace trimray::tess {

struct HalfEdgeTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using HalfEdgeKernel = OpenMesh::TriMesh_ArrayKernelT<HalfEdgeTraits>;

// A half-edge mesh holds two-sided edges and one fan a vertex; triangles that would break this are refused,
// those that come first stay. Vertices keep their indices.
struct HalfEdgeMesh {
  HalfEdgeKernel kernel;
  std::vector<std::int32_t> triangles;  // of the TriMesh, by face of the kernel
  std::vector<std::int32_t> refused;    // of the TriMesh

  // Every triangle is in, every edge has two sides, every vertex one fan: as MeshCheck says of the same mesh.
  bool closed_manifold() const;
};

// Throws ArgumentError for a vertex that does not exist.
HalfEdgeMesh half_edges(const TriMesh& mesh);

// The proven deviation (mm) of a triangle of a face: corners in uv_face and in space.
using DeviationProof = std::function<double(std::int32_t face, const std::array<dvec2, 3>& corner_uv,
                                            const std::array<dvec3, 3>& corners)>;

// Flips edges inside faces where that lowers the larger of the two triangles' proven deviations, until no
// flip helps. Leaves alone: edges whose triangles are both proven within `enough` (mm) or one of them is not
// proven, borders of faces, seams, and flips that would turn a triangle over in uv or in space, make it
// degenerate or make an edge that exists. Returns the number of flips; triangles keep their places in the
// arrays, and the result depends on the mesh alone. One thread.
std::int64_t improve(TriMesh& mesh, const DeviationProof& proof, double enough = 0.0);

}  // namespace trimray::tess
