#include "core/view/frame.h"

namespace trimray::view {

Frame::Frame(int width, int height, const Planes& planes) : width_px(width), height_px(height) {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (planes.color) color.assign(4 * pixels, 0.0f);
  if (planes.depth) depth.assign(pixels, kInf);
  if (planes.position) position.assign(3 * pixels, 0.0);
  if (planes.normal) normal.assign(3 * pixels, 0.0);
  if (planes.uv) uv.assign(2 * pixels, 0.0);
  if (planes.face) face.assign(pixels, kNoFace);
  if (planes.instance) instance.assign(pixels, -1);
  if (planes.time) time.assign(pixels, 0.0f);
}

}  // namespace trimray::view
