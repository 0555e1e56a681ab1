// A mesh as the raster pass wants it: blocks of triangles that lie together, each with vertices of its own.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "core/nurbs/store.h"
#include "core/tess/mesh_levels.h"
#include "raster/seed_buffers.h"

namespace trimray::raster {

// What is drawn, culled and sent as one: a few thousand triangles keep in cache whatever they need.
inline constexpr int kBlockTriangles = 4096;

// Which triangles of a block the rest of their closed shell hides.
enum class Hidden : std::int8_t {
  kNever,     // an open shell is seen from both sides
  kBack,      // those turned away from the eye
  kInsideOut  // those turned to the eye: the shell is closed with its normals inward
};

struct DrawBlock {
  nurbs::Range vertices, triangles;  // of the DrawMesh
  Hidden hidden = Hidden::kNever;
  Box3 bounds;
};

// A prototype's mesh. Vertices are split where faces meet or uv jumps, so that each has one uv and one id.
struct DrawMesh {
  std::vector<double> x, y, z;           // by vertex, mm, as the TriMesh has them
  std::vector<std::array<float, 2>> uv;  // by vertex; kUv: fractions of the face's uv_box
  std::vector<std::uint32_t> id;         // by vertex: into targets. A triangle's last vertex tells its id.
  std::vector<std::array<std::uint16_t, 3>> triangles;  // into its block's vertices
  std::vector<DrawBlock> blocks;
  std::vector<SeedTarget> targets;  // instance is not set
  Box3 bounds;
};

// One entry a triangle: the surface's number in the order of first use, and by number its target. For kId the
// number is the triangle's own and the target holds the mean of its corners' uv.
struct MeshTargets {
  std::vector<std::uint32_t> of_triangle;
  std::vector<SeedTarget> targets;
};

// Throw ArgumentError where the mesh's indices do not fit, or name no face of the store.
MeshTargets mesh_targets(const tess::TriMesh& mesh, const nurbs::NurbsStore& store, SeedProcess process);
DrawMesh draw_mesh(const tess::InstanceMesh& instance, const nurbs::NurbsStore& store, SeedProcess process);

// uv as fractions of a face's uv_box; 0.5 across a box without extent.
std::array<float, 2> uv_fraction(const nurbs::Face& face, const dvec2& uv);

// Draw meshes of the views drawn last. Thread-safe.
class DrawMeshes {
 public:
  // By instance of `meshes`; what is at hand is taken over, what this view does not use is forgotten.
  std::vector<std::shared_ptr<const DrawMesh>> of(const tess::ViewMeshes& meshes,
                                                  const nurbs::NurbsStore& store, SeedProcess process,
                                                  int threads);

 private:
  struct Kept {
    std::weak_ptr<const tess::Tessellation> source;
    const nurbs::NurbsStore* store;
    SeedProcess process;
    std::shared_ptr<const DrawMesh> mesh;
  };
  std::mutex mutex_;
  std::vector<Kept> kept_;
};

}  // namespace trimray::raster
