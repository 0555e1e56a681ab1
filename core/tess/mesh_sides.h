// The sides of a mesh's triangles, sorted so that those of one edge stand together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace trimray::tess {

// One side of a triangle: corner -> next corner, seen as the edge low -- high.
struct Side {
  std::int32_t low = -1, high = -1;  // vertices, low < high
  std::int32_t triangle = -1;
  std::int8_t corner = 0;  // where the side starts
  bool forward = false;    // runs low -> high
  bool same_edge(const Side& s) const { return low == s.low && high == s.high; }
};

// All sides, by (low, high, forward, triangle), so the same mesh always gives the same order. Triangles that
// name a vertex twice have no sides. Throws ArgumentError for a vertex that does not exist.
std::vector<Side> sorted_sides(std::size_t vertex_count,
                               std::span<const std::array<std::int32_t, 3>> triangles);

// Calls group(begin, end) for the sides of each edge, in order.
template <typename Group>
void for_each_edge(const std::vector<Side>& sides, const Group& group) {
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin + 1;
    while (end < sides.size() && sides[end].same_edge(sides[begin])) ++end;
    group(begin, end);
    begin = end;
  }
}

// How an edge is used: by one triangle, by two that run against each other, or else.
enum class EdgeUse : std::uint8_t { kOpen, kPaired, kNonManifold };
EdgeUse edge_use(std::span<const Side> edge);

}  // namespace trimray::tess
