// What a triangle renderer gives for a view: Embree's packets through a mesh, with the tracer's outputs.
#pragma once

#include <memory>
#include <span>

#include "core/nurbs/store.h"
#include "core/tess/mesh_levels.h"
#include "core/trace/ray.h"
#include "core/view/camera.h"

namespace bench {

// Triangles of all instances in the world, in a hierarchy of Embree's best quality; corners have the exact
// uv and the exact normals of their surfaces.
class EmbreeMesh {
 public:
  EmbreeMesh(const trimray::tess::ViewMeshes& meshes, const trimray::nurbs::NurbsStore& store);
  ~EmbreeMesh();

  // Rows [y0, y1) of the picture, both multiples of 4 or the picture's end, in coherent packets of 4 x 4
  // pixels (rtcIntersect16). hits: of the whole picture, row by row; t, face, instance, and uv and normal
  // interpolated between the corners; where nothing is met, face alone is set. May be called from many
  // threads.
  void trace(const trimray::view::Camera& camera, int y0, int y1, std::span<trimray::trace::Hit> hits) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bench
