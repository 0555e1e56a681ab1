// Frame: what a render gives back, named planes of one size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace trimray::view {

// Which planes to compute.
struct Planes {
  bool color = true, depth = false, position = false, normal = false, uv = false, face = false,
       instance = false, time = false;
  bool geometric() const { return depth || position || normal || uv || face || instance; }
};

// Planes are row by row from the top, pixel (x, y) at (y * width_px + x) * channels; a plane that was not
// asked for is empty. color is filtered over the pixel; every other plane but time holds the one ray through
// the pixel's centre, never filtered, and where it meets nothing: depth inf, position, normal and uv 0, face
// and instance -1.
struct Frame {
  int width_px = 0, height_px = 0;
  std::vector<float> color;   // 4: red, green, blue sRGB-encoded in [0, 1], straight alpha
  std::vector<double> depth;  // 1: mm along the pixel's ray, from the image plane (orthographic) or the eye
  std::vector<double> position;        // 3: mm, world
  std::vector<double> normal;          // 3: unit, outward geometric normal, world
  std::vector<double> uv;              // 2: uv_face, the file's own surface parameters
  std::vector<std::int32_t> face;      // 1: number of the face in the store
  std::vector<std::int32_t> instance;  // 1
  std::vector<float> time;  // 1: ns of processor time, that of a small block of pixels shared among them

  Frame() = default;
  Frame(int width, int height, const Planes& planes);
};

}  // namespace trimray::view
