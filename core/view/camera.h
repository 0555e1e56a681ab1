// Cameras: what ray belongs to a place in the picture.
#pragma once

#include "core/base/box.h"

namespace trimray::view {

struct CameraRay {
  dvec3 org{0.0}, dir{0.0};  // dir of unit length
};

// Picture coordinates: x right in [0, width), y down in [0, height), in px; pixel (i, j) has its centre at
// (i + 0.5, j + 0.5).
struct Camera {
  dvec3 eye{0.0};             // orthographic: centre of the image plane, outside the model
  dvec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};  // orthonormal
  bool perspective = false;
  double pixel = 1.0;         // orthographic: mm per px; perspective: tangent per px
  int width_px = 512, height_px = 512;

  CameraRay ray(double x_px, double y_px) const;
};

}  // namespace trimray::view
