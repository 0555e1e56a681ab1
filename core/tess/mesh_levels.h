// MeshLevels: the meshes that a picture needs, kept from picture to picture.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "core/tess/tessellate.h"
#include "core/tess/view_tolerance.h"
#include "core/view/camera.h"

namespace trimray::tess {

struct LevelOptions {
  double angle = kInf;                           // rad, as TessOptions has it
  std::size_t max_bytes = std::size_t{1} << 30;  // of meshes that are kept
  double guard = 0.0;  // rim of cut meshes around the picture, as a part of its longer side
};

// An instance that is, or may be, in the picture.
struct InstanceMesh {
  std::int32_t instance = -1;
  std::shared_ptr<const Tessellation> mesh;  // of the prototype, in its coordinates
  double tolerance = 0.0;  // mm, in the prototype: the least that holds anywhere in the mesh
  bool cut = false;        // made for this instance alone; ends at the borders of the picture
};

struct ViewMeshes {
  std::vector<InstanceMesh> instances;  // in the order of their numbers
  int built = 0, reused = 0;            // meshes, each counted once
  std::size_t triangles = 0;            // of all instances
};

// Thread-safe; calls wait for one another. What a call returns depends on what was asked for before, but not
// on the number of threads.
class MeshLevels {
 public:
  explicit MeshLevels(std::shared_ptr<const nurbs::NurbsStore> store, const LevelOptions& options = {});

  // Meshes of all instances in the picture: no surface in it is seen farther from its mesh than deviation_px.
  //
  // An instance that is mostly in the picture and about equally far all over has its prototype's mesh at one
  // tolerance, a level: a power of the root of two, in mm, and the same mesh for all instances that it
  // serves. A level serves while it is fine enough, and no more than twice as fine as it must be. Any other
  // instance has a mesh of its own, as fine as every place needs and without the triangles beyond the
  // picture, unless a level that is kept serves; it is kept for it while ViewTolerance::serves. The least
  // recently used meshes are dropped when all together are too large. Throws ArgumentError for a deviation
  // that is not above 0.
  ViewMeshes meshes(const view::Camera& camera, double deviation_px, int threads = 0);

  std::size_t bytes() const;

 private:
  struct Kept;
  struct Wish;
  std::shared_ptr<Kept> level_for(std::int32_t prototype, double tolerance) const;
  std::shared_ptr<Kept> cut_for(const Wish& wish) const;
  void build(const std::vector<std::shared_ptr<Kept>>& fresh, int threads) const;
  void drop();

  std::shared_ptr<const nurbs::NurbsStore> store_;
  LevelOptions options_;
  double near_ = 1e-3;  // mm
  mutable std::mutex mutex_;
  std::vector<std::vector<std::shared_ptr<Kept>>> kept_;  // by prototype
  std::uint64_t calls_ = 0;
};

}  // namespace trimray::tess
