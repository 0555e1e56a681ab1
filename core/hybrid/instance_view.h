// One instance as a camera sees it.
#pragma once

#include "core/hybrid/camera_frame.h"
#include "core/trace/scene_impl.h"

namespace trimray::hybrid {

struct InstanceView {
  const trace::InstanceScene* instance = nullptr;
  const trace::PrototypeScene* prototype = nullptr;
  std::int32_t index = -1;
  CameraFrame frame;
  double stretch_across = 1.0, stretch_along = 1.0;  // of lengths, in the frame: x and y together, and z
  dvec3 dir{0.0};                                    // orthographic: the same for all rays, in the prototype
  double scale = 1.0;  // orthographic: t in the prototype = t in the world * scale

  InstanceView() = default;
  InstanceView(const trace::Scene::Impl& scene, const view::Camera& camera, std::int32_t i)
      : instance(&scene.instances[i]),
        prototype(scene.prototypes[instance->prototype].get()),
        index(i),
        frame(camera, scene.store->instances[i].placement) {
    const dmat3 rows = glm::transpose(frame.linear);
    stretch_across = std::sqrt(glm::dot(rows[0], rows[0]) + glm::dot(rows[1], rows[1]));
    stretch_along = glm::length(rows[2]);
    if (!camera.perspective) dir = instance->local({camera.eye, camera.forward, 0.0, kInf}, scale).dir;
  }
};

}  // namespace trimray::hybrid
