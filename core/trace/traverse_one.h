// The scalar twin of traverse(): one ray, in double, against the same boxes.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/trace/traverse.h"

namespace trimray::trace {

template <typename Visit>
void traverse_one(const Bvh& bvh, dvec3 org, dvec3 dir, double tmin, double tmax, const Visit& visit) {
  if (bvh.nodes.empty()) return;
  // The origin moves next to the center; a direction of zero becomes one so small that it stays in its slab.
  const double t0 = glm::dot(bvh.center - org, dir);
  const dvec3 o = (org - bvh.center) + t0 * dir;
  dvec3 inv;
  for (int a = 0; a < 3; ++a)
    inv[a] = 1.0 / (std::abs(dir[a]) < 1e-30 ? std::copysign(1e-30, dir[a]) : dir[a]);
  const double near = tmin - t0, far = tmax - t0;
  std::int32_t stack[kBvhDepth * kBvhWidth];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const BvhNode& node = bvh.nodes[stack[--top]];
    for (int i = 0; i < node.count; ++i) {
      double enter = near, leave = far;
      for (int a = 0; a < 3; ++a) {
        const double p = (node.lower[a][i] - o[a]) * inv[a], q = (node.upper[a][i] - o[a]) * inv[a];
        enter = std::max(enter, std::min(p, q)), leave = std::min(leave, std::max(p, q));
      }
      if (!(enter <= leave)) continue;
      if (node.child[i] < 0)
        visit(~node.child[i]);
      else
        stack[top++] = node.child[i];
    }
  }
}

}  // namespace trimray::trace
