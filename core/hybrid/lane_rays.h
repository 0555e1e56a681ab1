// The rays of several pixels at once, in an instance's own coordinates.
#pragma once

#include <span>

#include "core/hybrid/instance_view.h"
#include "core/trace/patch.h"
#include "core/trace/tile.h"

namespace trimray::hybrid {

// t in the instance = t in the world * scale; depth = t in the world * depth, up to rounding.
struct LaneScales {
  alignas(64) double scale[trace::kLanes], depth[trace::kLanes];
  bool unit = true;  // every scale is 1
  double world(double t, int lane) const { return unit ? t : t / scale[lane]; }
};

// Rays of up to kLanes places of the picture, px from its left and top: bit by bit those of Camera::ray and
// InstanceScene::local. Lanes beyond count hold the first ray; rays.active is set.
void lane_rays(const view::Camera& camera, const InstanceView& view, const double* x_px, const double* y_px,
               int count, trace::RayLanes& rays, LaneScales& scales);

}  // namespace trimray::hybrid
