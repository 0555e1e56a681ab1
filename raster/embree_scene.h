// The triangles of a view as a scene of Embree's.
#pragma once

#include <memory>
#include <vector>

#include "core/base/box.h"
#include "core/nurbs/store.h"
#include "core/tess/mesh_levels.h"
#include "raster/draw_mesh.h"
#include "raster/embree_api.h"

namespace trimray::raster {

// One device a process: what was made before a fork is left to the parent.
struct EmbreeDevice {
  explicit EmbreeDevice(const embree::Library& library);
  ~EmbreeDevice();
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  const embree::Library& library;
  embree::Device device;
  int process;
};

// Immutable. Geometry i is instance i of the view, its primitives the mesh's triangles; coordinates are the
// world's, less `center`.
class EmbreeScene {
 public:
  EmbreeScene(std::shared_ptr<const EmbreeDevice> device, const tess::ViewMeshes& meshes,
              const nurbs::NurbsStore& store, int threads);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  // Whether it is the scene of this view, made in this process.
  bool is_of(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store) const;

  embree::Scene scene() const { return scene_; }
  const dvec3& center() const { return center_; }
  const Box3& bounds() const { return bounds_; }  // of the world
  // By instance of the view.
  const MeshTargets& targets(std::size_t instance, SeedProcess process) const {
    return *targets_[static_cast<int>(process)][instance];
  }

 private:
  void add(const tess::TriMesh& mesh, const Transform& placement);

  struct Part {
    std::int32_t instance;
    std::weak_ptr<const tess::Tessellation> mesh;
    Transform placement;
  };
  std::shared_ptr<const EmbreeDevice> device_;
  embree::Scene scene_ = nullptr;
  const nurbs::NurbsStore* store_;
  std::vector<Part> parts_;
  std::vector<std::shared_ptr<const MeshTargets>> targets_[2];
  dvec3 center_{0.0};
  Box3 bounds_;
};

}  // namespace trimray::raster
