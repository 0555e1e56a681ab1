// A camera as seen from one instance: the map to the camera's frame, where its rays are parallel to an axis
// or start at the origin.
#pragma once

#include "core/base/types.h"
#include "core/view/camera.h"

namespace trimray::hybrid {

// Camera frame: x right and y down, in px from the middle of the picture (orthographic), or in px times depth
// (perspective: a point of depth z is seen at x / z, y / z px); z the depth along `forward`, mm. The ray
// through the place (x, y) px from the middle is (x, y, 0) + s (0, 0, 1) orthographic, s (x, y, 1)
// perspective: s is depth.
struct CameraFrame {
  dmat3 linear{1.0};  // of the prototype's coordinates
  dvec3 shift{0.0};
  bool perspective = false;

  CameraFrame() = default;
  CameraFrame(const view::Camera& camera, const Transform& placement) : perspective(camera.perspective) {
    const dmat3 axes =
        glm::transpose(dmat3(camera.right / camera.pixel, -camera.up / camera.pixel, camera.forward));
    linear = axes * placement.linear;
    shift = axes * (placement.translation - camera.eye);
  }
  dvec3 point(const dvec3& p) const { return linear * p + shift; }
  dvec3 direction(const dvec3& v) const { return linear * v; }
  // The frame of coordinates relative to a centre.
  CameraFrame about(const dvec3& center) const {
    CameraFrame frame = *this;
    frame.shift = point(center);
    return frame;
  }
};

// A rectangle of places, px from the middle of the picture.
struct FrameRect {
  double x0 = 0.0, y0 = 0.0, x1 = 0.0, y1 = 0.0;
  dvec2 center() const { return {0.5 * (x0 + x1), 0.5 * (y0 + y1)}; }
};

}  // namespace trimray::hybrid
