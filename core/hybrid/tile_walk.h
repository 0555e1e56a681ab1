// A walk through a hierarchy with the rays of a tile: every primitive whose box some ray of the tile can
// meet, roughly front to back.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/hybrid/camera_frame.h"
#include "core/trace/bvh.h"

namespace trimray::hybrid {

// The space that the rays of a tile go through, in the coordinates of one Bvh: planes n . p + d >= 0, and
// depth.
class TileSpace {
 public:
  // frame: of the coordinates that bvh's boxes are relative to, before its center is taken off. reference:
  // depths count from it.
  TileSpace(const CameraFrame& frame, const trace::Bvh& bvh, const FrameRect& rect, double reference) {
    const CameraFrame local = frame.about(bvh.center);
    const glm::dmat3 rows = glm::transpose(local.linear);
    const dvec3 axis_x = rows[0], axis_y = rows[1], axis_z = rows[2];
    const auto plane = [&](int i, const dvec3& axis, double shift, double at, double sign) {
      if (local.perspective)
        set(i, sign * (axis - at * axis_z), sign * (shift - at * local.shift.z), bvh.radius);
      else
        set(i, sign * axis, sign * (shift - at), bvh.radius);
    };
    plane(0, axis_x, local.shift.x, rect.x0, 1.0), plane(1, axis_x, local.shift.x, rect.x1, -1.0);
    plane(2, axis_y, local.shift.y, rect.y0, 1.0), plane(3, axis_y, local.shift.y, rect.y1, -1.0);
    // The farthest depth must not lie behind the eye; the nearest one orders the walk.
    set(4, axis_z, local.shift.z, bvh.radius);
    set(5, -axis_z, reference - local.shift.z, bvh.radius);
  }

  // Children of the node that meet the space, with their nearest depths; returns their number.
  int children(const trace::BvhNode& node, int (&child)[trace::kBvhWidth],
               float (&near)[trace::kBvhWidth]) const {
    constexpr int kWidth = trace::kBvhWidth;
    float most[6][kWidth];
    for (int p = 0; p < 6; ++p) {
      const Plane& plane = planes_[p];
      const float(&x)[kWidth] = plane.n[0] > 0.0f ? node.upper[0] : node.lower[0];
      const float(&y)[kWidth] = plane.n[1] > 0.0f ? node.upper[1] : node.lower[1];
      const float(&z)[kWidth] = plane.n[2] > 0.0f ? node.upper[2] : node.lower[2];
      for (int i = 0; i < kWidth; ++i)
        most[p][i] = plane.n[0] * x[i] + plane.n[1] * y[i] + (plane.n[2] * z[i] + plane.d);
    }
    int count = 0;
    for (int i = 0; i < node.count; ++i) {
      const float x = std::min(most[0][i], most[1][i]), y = std::min(most[2][i], most[3][i]);
      if (!(std::min(std::min(x, y), most[4][i]) >= 0.0f)) continue;
      int at = count++;
      for (; at > 0 && near[at - 1] < -most[5][i]; --at) child[at] = child[at - 1], near[at] = near[at - 1];
      child[at] = i, near[at] = -most[5][i];
    }
    return count;
  }

 private:
  struct Plane {
    float n[3], d;
  };
  // Widened by what rounding to float, here and in children(), can amount to within the radius.
  void set(int i, const dvec3& n, double d, double radius) {
    const double slack = 1e-6 * ((std::abs(n.x) + std::abs(n.y) + std::abs(n.z)) * radius + std::abs(d));
    for (int a = 0; a < 3; ++a) planes_[i].n[a] = static_cast<float>(n[a]);
    planes_[i].d = static_cast<float>(d + slack);
  }
  Plane planes_[6];
};

// Calls visit(primitive, near) for the primitives with near <= limit(), which may shrink on the way. Returns
// the number of nodes opened.
template <typename Limit, typename Visit>
std::uint64_t walk_tile(const trace::Bvh& bvh, const TileSpace& space, const Limit& limit,
                        const Visit& visit) {
  if (bvh.nodes.empty()) return 0;
  struct Entry {
    std::int32_t node;
    float near;
  };
  Entry stack[trace::kBvhDepth * trace::kBvhWidth];
  int top = 0;
  std::uint64_t opened = 0;
  stack[top++] = {0, -INFINITY};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (entry.near > limit()) continue;
    if (entry.node < 0) {
      visit(~entry.node, entry.near);
      continue;
    }
    const trace::BvhNode& node = bvh.nodes[entry.node];
    int child[trace::kBvhWidth];
    float near[trace::kBvhWidth];
    const int count = space.children(node, child, near);
    ++opened;
    for (int i = 0; i < count; ++i) {
      const std::int32_t next = node.child[child[i]];
      if (next >= 0) __builtin_prefetch(&bvh.nodes[next]);
      stack[top++] = {next, near[i]};
    }
  }
  return opened;
}

// About how many primitives walk_tile() would visit without a limit; no more is counted beyond `most`. Small
// branches count as a whole, so it is some half too many. bvh.below must be set.
inline std::int64_t estimate_tile(const trace::Bvh& bvh, const TileSpace& space, std::int64_t most) {
  constexpr std::int32_t kSmall = 16;
  if (bvh.nodes.empty()) return 0;
  std::int32_t stack[trace::kBvhDepth * trace::kBvhWidth];
  int top = 0;
  std::int64_t sum = 0;
  stack[top++] = 0;
  while (top > 0 && sum <= most) {
    const trace::BvhNode& node = bvh.nodes[stack[--top]];
    int child[trace::kBvhWidth];
    float near[trace::kBvhWidth];
    const int count = space.children(node, child, near);
    for (int i = 0; i < count; ++i) {
      const std::int32_t next = node.child[child[i]];
      if (next < 0)
        ++sum;
      else if (bvh.below[next] <= kSmall)
        sum += bvh.below[next];
      else
        stack[top++] = next;
    }
  }
  return sum;
}

}  // namespace trimray::hybrid
