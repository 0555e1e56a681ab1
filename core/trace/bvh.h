// A bounding volume hierarchy over boxes, four children a node, in floats relative to a centre.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/box.h"

namespace trimray::trace {

inline constexpr int kBvhWidth = 4;

// Structure of arrays over the children. child >= 0 is a node, child < 0 the primitive ~child. Unused
// slots stand at the end.
struct alignas(64) BvhNode {
  float lower[3][kBvhWidth], upper[3][kBvhWidth];
  std::int32_t child[kBvhWidth];
  std::int32_t count = 0;
};

// Boxes were moved by -center, widened by `dilation` and rounded outward to float. nodes[0] is the root;
// no nodes when there was no box that is not empty.
struct Bvh {
  std::vector<BvhNode> nodes;
  std::vector<std::int32_t> below;  // by node: primitives in it and below; set by renumber_primitives()
  dvec3 center{0.0};
  double radius = 0.0;  // of a ball about the center that holds every box
  double dilation = 0.0;
  std::int64_t bytes() const {
    return static_cast<std::int64_t>(nodes.size() * sizeof(BvhNode) + below.size() * sizeof(below[0]));
  }
};

// Rays are followed in float, from an origin within `radius` of the center, so a box face may be seen
// displaced by a few float ulp of the radius: rounding of the origin, of the direction over a way of up to
// 2 radii, and of the slab test. Boxes grow by this fraction of the radius to cover it.
inline constexpr double kRayDilation = 3e-6;

// Longest path from the root to a primitive, so that a traversal needs a stack of kBvhDepth * kBvhWidth.
inline constexpr int kBvhDepth = 64;

// Binned surface-area heuristic. Empty boxes are left out. The same tree for the same boxes.
Bvh build_bvh(std::span<const Box3> boxes);

// Numbers the primitives in the order of the nodes, so that neighbours lie side by side in memory. Returns
// the old number of each; primitives that are not in the hierarchy are left out.
std::vector<std::int32_t> renumber_primitives(Bvh& bvh);

}  // namespace trimray::trace
