// Random tiles of random cameras on a random instance, and their rays in the
// camera frame.
#pragma once

#include <algorithm>

#include "core/hybrid/camera_frame.h"
#include "tests/core/hybrid/scenes.h"

namespace trimray::testing {

struct TileView {
  view::Camera camera;
  Transform placement;
  hybrid::CameraFrame frame;  // of the prototype's coordinates
  int x0 = 0, y0 = 0, width = 0, height = 0;
  hybrid::FrameRect rect;
  double size = 1.0;   // mm: of what is looked at
  double depth = 1.0;  // of its middle
  dvec3 target{0.0};   // its middle, in the prototype

  // The place of a sample of a pixel of the tile, px from the middle of the
  // picture.
  dvec2 at(int x, int y, dvec2 place) const { return dvec2(rect.x0 + x, rect.y0 + y) + place; }
  // The camera frame's point at a depth.
  dvec3 point(dvec2 at, double s) const { return frame.perspective ? dvec3(at * s, s) : dvec3(at, s); }
  dvec3 to_prototype(const dvec3& p) const { return glm::inverse(frame.linear) * (p - frame.shift); }
};

// far: how far from the origin the prototype lies, in sizes of what is looked
// at. zoom: above 1 the picture shows a part only.
inline TileView random_tile(Random& random, double far, double zoom) {
  TileView v;
  v.size = random.log_between(1e-2, 1e4);
  const dmat3 axes = random.rotation();
  v.camera.right = axes[0], v.camera.up = axes[1], v.camera.forward = -axes[2];
  v.camera.perspective = random.chance(0.5);
  v.camera.width_px = 40 + static_cast<int>(random.below(2000));
  v.camera.height_px = 40 + static_cast<int>(random.below(2000));
  const double shorter = std::min(v.camera.width_px, v.camera.height_px);
  v.depth = v.size * random.log_between(0.6, 20.0);
  v.camera.pixel = v.size / shorter / zoom;
  if (v.camera.perspective) v.camera.pixel /= v.depth;
  const dmat3 turn = random.rotation();
  switch (random.below(4)) {
    case 0:
      break;
    case 1:
      v.placement.linear = turn;
      break;
    case 2:
      v.placement.linear = -random.log_between(0.1, 10.0) * turn;
      break;
    default:
      v.placement.linear = turn * dmat3(dvec3(random.between(0.2, 3), 0, 0),
                                        dvec3(random.between(-1, 1), random.between(0.2, 3), 0),
                                        dvec3(0, random.between(-1, 1), random.between(0.2, 3)));
  }
  v.placement.translation = far * v.size * random.direction();
  v.target = far * v.size * random.direction();
  v.camera.eye = v.placement.point(v.target) - v.depth * v.camera.forward +
                 0.3 * v.size * random.between(-1, 1) * v.camera.right +
                 0.3 * v.size * random.between(-1, 1) * v.camera.up;
  v.frame = hybrid::CameraFrame(v.camera, v.placement);
  const int widths[] = {5, 8, 32, 64, 64, 17, 1};
  v.width = widths[random.below(7)], v.height = widths[random.below(7)];
  v.x0 = static_cast<int>(random.below(std::max(1, v.camera.width_px - v.width + 1)));
  v.y0 = static_cast<int>(random.below(std::max(1, v.camera.height_px - v.height + 1)));
  const double mx = 0.5 * v.camera.width_px, my = 0.5 * v.camera.height_px;
  v.rect = {v.x0 - mx, v.y0 - my, v.x0 + v.width - mx, v.y0 + v.height - my};
  return v;
}

}  // namespace trimray::testing
