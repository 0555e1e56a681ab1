// The colours that a store's faces are seen in.
#pragma once

#include <vector>

#include "core/nurbs/store.h"
#include "core/trace/ray.h"
#include "core/view/shade.h"

namespace trimray::trace {

// Colour of a face in an instance: the face's, else the instance's, else the prototype's, else the neutral
// colour of a part that the file leaves uncoloured. sRGB-encoded, straight alpha.
void face_color(const nurbs::NurbsStore& store, std::int32_t face, std::int32_t instance, float srgb[4]);

// The same, linear, for all of a store's faces, which must outlive this.
class FaceColors {
 public:
  explicit FaceColors(const nurbs::NurbsStore& store);

  const view::Color& of(const Hit& hit) const {
    return store_.faces[hit.face].has_color() ? faces_[hit.face] : instances_[hit.instance];
  }

 private:
  const nurbs::NurbsStore& store_;
  std::vector<view::Color> faces_, instances_;
};

inline constexpr double kOpaque = 1.0 - 1.0 / 512.0;  // what an 8-bit picture cannot tell from opaque
inline double opacity(const view::Color& color) { return color.alpha >= kOpaque ? 1.0 : color.alpha; }

}  // namespace trimray::trace
