// Cameras: what ray belongs to a place in the picture, and where to stand to see the whole model.
#pragma once

#include <span>

#include "core/base/box.h"

namespace trimray::view {

struct CameraRay {
  dvec3 org{0.0}, dir{0.0};  // dir of unit length
};

// Picture coordinates: x right in [0, width), y down in [0, height), in px; pixel (i, j) has its centre at
// (i + 0.5, j + 0.5).
struct Camera {
  dvec3 eye{0.0};  // orthographic: centre of the image plane, outside the model
  dvec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};  // orthonormal
  bool perspective = false;
  double pixel = 1.0;  // orthographic: mm per px; perspective: tangent per px
  int width_px = 512, height_px = 512;

  CameraRay ray(double x_px, double y_px) const;
};

// The axis of the model that points up in the picture, and with it what "front" means:
//   up z: the front view looks along +y, x to the right      up -z: along -y, x to the right
//   up y: along -z, x to the right                           up -y: along +z, x to the right
//   up x: along +z, y to the right                           up -x: along -z, y to the right
enum class UpAxis { kX, kY, kZ, kMinusX, kMinusY, kMinusZ };

// Orthonormal directions of a camera that stands at an azimuth (degrees, counter-clockwise seen from above,
// 0 = front, 90 = right) and an elevation (degrees, 90 = top, -90 = bottom; clamped to [-90, 90]).
// The other fields of the camera keep their defaults.
Camera look(double azimuth_deg, double elevation_deg, UpAxis up);

// The camera of look(), moved about the upright line through pivot by an angle (degrees) that its azimuth
// grows by.
Camera turned(const Camera& camera, double angle_deg, const dvec3& pivot, UpAxis up);

// What a camera shows of the points it is fitted to.
struct FitOptions {
  int width_px = 512, height_px = 512;  // both >= 1
  bool perspective = false;
  double fov_deg = 30.0;  // perspective: full angle across the shorter side of the picture
  double margin = 0.04;   // free border, as a fraction of the shorter side, on each side
};

// Moves and scales a camera of look() so that every point lies within the picture, as large as can be:
// orthographic exactly centred; perspective with the eye as near as it may stand. The eye stands before all
// the points. An empty span is taken as the origin.
Camera fit(const Camera& directions, std::span<const dvec3> points, const FitOptions& options);

}  // namespace trimray::view
