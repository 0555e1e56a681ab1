#include "core/trace/face_colors.h"

#include <algorithm>

namespace trimray::trace {

namespace {

constexpr float kNeutral[4] = {0.79f, 0.81f, 0.84f, 1.0f};  // light steel

}  // namespace

void face_color(const nurbs::NurbsStore& store, std::int32_t face, std::int32_t instance, float srgb[4]) {
  const float* color = kNeutral;
  if (face != kNoFace && store.faces[face].has_color()) {
    color = store.faces[face].color;
  } else if (instance >= 0) {
    const nurbs::Instance& placed = store.instances[instance];
    const nurbs::Prototype& prototype = store.prototypes[placed.prototype];
    if (placed.color[0] >= 0.0f)
      color = placed.color;
    else if (prototype.color[0] >= 0.0f)
      color = prototype.color;
  }
  std::copy_n(color, 4, srgb);
}

FaceColors::FaceColors(const nurbs::NurbsStore& store) : store_(store) {
  faces_.resize(store.faces.size());
  for (std::size_t i = 0; i < store.faces.size(); ++i) {
    if (store.faces[i].has_color()) faces_[i] = view::linear_color(store.faces[i].color);
  }
  instances_.resize(store.instances.size());
  for (std::size_t i = 0; i < store.instances.size(); ++i) {
    float srgb[4];
    face_color(store, kNoFace, static_cast<std::int32_t>(i), srgb);
    instances_[i] = view::linear_color(srgb);
  }
}

}  // namespace trimray::trace
