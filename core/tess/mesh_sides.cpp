#include "core/tess/mesh_sides.h"

#include <algorithm>
#include <string>
#include <tuple>

#include "core/base/error.h"

namespace trimray::tess {

std::vector<Side> sorted_sides(std::size_t vertex_count,
                               std::span<const std::array<std::int32_t, 3>> triangles) {
  // Sides are counted by their lower vertex, put into its part of the array and sorted there: a vertex has
  // about three, so this is linear where one big sort is not.
  std::vector<std::size_t> first(vertex_count + 1, 0);
  const auto distinct = [](const std::array<std::int32_t, 3>& t) {
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
  };
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& t = triangles[i];
    for (const std::int32_t v : t) {
      if (v < 0 || static_cast<std::size_t>(v) >= vertex_count)
        throw ArgumentError("triangle " + std::to_string(i) + " names vertex " + std::to_string(v) + " of " +
                            std::to_string(vertex_count));
    }
    if (!distinct(t)) continue;
    for (int k = 0; k < 3; ++k) ++first[std::min(t[k], t[(k + 1) % 3]) + 1];
  }
  for (std::size_t v = 0; v < vertex_count; ++v) first[v + 1] += first[v];

  std::vector<Side> sides(first[vertex_count]);
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& t = triangles[i];
    if (!distinct(t)) continue;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      sides[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), static_cast<std::int32_t>(i),
                                       static_cast<std::int8_t>(k), a < b};
    }
  }
  const auto before = [](const Side& a, const Side& b) {
    return std::tuple(a.high, a.forward, a.triangle) < std::tuple(b.high, b.forward, b.triangle);
  };
  for (std::size_t v = 0; v < vertex_count; ++v)
    std::sort(sides.begin() + static_cast<std::ptrdiff_t>(first[v]),
              sides.begin() + static_cast<std::ptrdiff_t>(first[v + 1]), before);
  return sides;
}

EdgeUse edge_use(std::span<const Side> edge) {
  if (edge.size() == 1) return EdgeUse::kOpen;
  return edge.size() == 2 && edge[0].forward != edge[1].forward ? EdgeUse::kPaired : EdgeUse::kNonManifold;
}

}  // namespace trimray::tess
