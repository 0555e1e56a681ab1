// From a prototype's coordinates to a window of the picture, and the triangles that can be seen there.
#pragma once

#include <algorithm>
#include <vector>

#include "core/base/box.h"
#include "core/view/camera.h"
#include "raster/draw_mesh.h"

namespace trimray::raster {

// Pixels [x0, x0 + width) x [y0, y0 + height) of a picture, drawn in bands of rows: each on a thread of its
// own, into a target of its own. All but the last have band_height rows.
struct Window {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  int band_height = 0;
  int bands() const { return (height + band_height - 1) / band_height; }
  int rows(int band) const { return std::min(band_height, height - band * band_height); }
};

// Distances along the view that something may have, mm; both above 0, or empty.
struct DepthRange {
  double near = kInf, far = -kInf;
};
DepthRange depth_range(const tess::ViewMeshes& meshes, std::span<const std::shared_ptr<const DrawMesh>> drawn,
                       const nurbs::NurbsStore& store, const view::Camera& camera);

// A point p has clip coordinates (x, y, w) = rows * p + shift; y points down, so that the first row that is
// drawn is the picture's first. Depth is reversed: 1 at `near`, 0 at `far` (at infinity for perspective).
class Projection {
 public:
  Projection(const view::Camera& camera, const Transform& placement, const Window& window,
             const DepthRange& range);

  dvec3 rows[3];
  dvec3 shift;
  dvec3 depth_row{0.0};  // orthographic: depth = depth_row * p + depth_shift
  double depth_shift = 0.0;
  bool perspective = false;
  bool mirrored = false;  // the placement turns triangles over
  double near = 0.0;
  Window window;

  // Whether the box may be seen, and whether all of it lies behind the near plane as the eye sees it.
  bool sees(const Box3& box) const;
  bool beyond_near(const Box3& box) const;
};

// As the vertex shader gets it.
struct ClipVertex {
  float x, y, z, w;
  float u, v;
  std::uint32_t id;
};

// Triangles that may cover a pixel's centre; adds to what is there. first_id: added to all ids.
class VisibleTriangles {
 public:
  std::vector<ClipVertex> vertices;
  std::vector<std::vector<std::uint32_t>> indices;  // by band of the window: what may cover a centre in it

  void start(int bands) {
    vertices.clear(), indices.resize(static_cast<std::size_t>(bands));
    for (auto& band : indices) band.clear();
  }
  void add(const DrawMesh& mesh, const DrawBlock& block, const Projection& projection,
           std::uint32_t first_id);

 private:
  void transform(const DrawMesh& mesh, const DrawBlock& block, const Projection& projection);

  // By vertex of the block: clip coordinates, the place in the window in px, and the vertex's new number.
  std::vector<float> clip_[4], px_, py_;
  std::vector<std::uint32_t> number_;
};

}  // namespace trimray::raster
