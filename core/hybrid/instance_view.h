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

  int edge_level = 0;  // of the prototype's sieves: the coarsest that looks fine here

  const trace::EdgeSieve& edges() const { return prototype->sieves[edge_level]; }

  InstanceView() = default;
  InstanceView(const trace::Scene::Impl& scene, const view::Camera& camera, std::int32_t i)
      : instance(&scene.instances[i]),
        prototype(scene.prototypes[instance->prototype].get()),
        index(i),
        frame(camera, scene.store->instances[i].placement) {
    const dmat3 rows = glm::transpose(frame.linear);
    stretch_across = std::sqrt(glm::dot(rows[0], rows[0]) + glm::dot(rows[1], rows[1]));
    stretch_along = glm::length(rows[2]);
    // Coarse paths send more rays to be asked one by one, fine ones have more segments to be drawn.
    constexpr double kFinePx = 0.08;
    const Box3& box = prototype->box;
    double depth = 1.0;
    if (camera.perspective && !box.empty())
      depth = std::max(frame.point(box.center()).z - stretch_along * 0.5 * box.diagonal(), 1e-300);
    const int levels = static_cast<int>(prototype->sieves.size());
    while (edge_level + 1 < levels &&
           prototype->sieves[edge_level + 1].chord_tolerance() * stretch_across / depth <= kFinePx)
      ++edge_level;
    if (!camera.perspective) dir = instance->local({camera.eye, camera.forward, 0.0, kInf}, scale).dir;
  }
};

}  // namespace trimray::hybrid
