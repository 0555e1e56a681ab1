#include "core/tess/mesh_check.h"

#include <algorithm>

#include "core/base/box.h"
#include "core/tess/corner_sets.h"
#include "core/tess/mesh_sides.h"

namespace trimray::tess {
namespace {

// The triangles around a vertex form one fan when its corners hang together over edges of two triangles.
std::int64_t count_fanned_vertices(std::size_t vertex_count,
                                   std::span<const std::array<std::int32_t, 3>> triangles,
                                   const std::vector<Side>& sides) {
  CornerSets sets(3 * triangles.size());
  const auto corner_at = [&](const Side& s, std::int32_t vertex) {
    const auto& t = triangles[s.triangle];
    const int k = t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
    return 3 * static_cast<std::size_t>(s.triangle) + k;
  };
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin != 2) return;
    const Side &a = sides[begin], &b = sides[begin + 1];
    sets.unite(corner_at(a, a.low), corner_at(b, a.low));
    sets.unite(corner_at(a, a.high), corner_at(b, a.high));
  });
  std::vector<std::uint8_t> fans(vertex_count, 0);
  for (const Side& s : sides) {  // every corner starts one side
    const std::size_t corner = 3 * static_cast<std::size_t>(s.triangle) + s.corner;
    std::uint8_t& n = fans[triangles[s.triangle][s.corner]];
    if (sets.root(corner) == corner && n < 2) ++n;
  }
  return std::count(fans.begin(), fans.end(), 2);
}

}  // namespace

double smallest_height(const dvec3& a, const dvec3& b, const dvec3& c) {
  const double twice = glm::length(glm::cross(b - a, c - a));
  const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  return longest > 0.0 ? twice / longest : 0.0;
}

MeshCheck check(std::span<const dvec3> vertices, std::span<const std::array<std::int32_t, 3>> triangles) {
  const std::vector<Side> sides = sorted_sides(vertices.size(), triangles);
  MeshCheck result;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    const EdgeUse use = edge_use({sides.data() + begin, end - begin});
    result.open_edges += use == EdgeUse::kOpen;
    result.non_manifold_edges += use == EdgeUse::kNonManifold;
  });
  result.non_manifold_vertices = count_fanned_vertices(vertices.size(), triangles, sides);

  Box3 box;
  for (const auto& t : triangles)
    for (const std::int32_t v : t) box.add(vertices[v]);
  // About the middle, so that a part far from the origin loses no digits.
  const dvec3 middle = box.empty() ? dvec3(0.0) : box.center();
  const double least = kDegenerateHeight * box.diagonal();
  for (const auto& t : triangles) {
    const dvec3 a = vertices[t[0]] - middle, b = vertices[t[1]] - middle, c = vertices[t[2]] - middle;
    const bool twice = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    // A height that is no number counts, too.
    result.degenerate_triangles += twice || !(smallest_height(a, b, c) > least);
    if (twice) continue;
    result.volume += glm::dot(a, glm::cross(b, c)) / 6.0;
    result.area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return result;
}

MeshCheck check(const TriMesh& mesh) { return check(mesh.vertices, mesh.triangles); }

}  // namespace trimray::tess
