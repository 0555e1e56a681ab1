#include "core/nurbs/mesh_store.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/base/error.h"
#include "core/nurbs/curve_form.h"

namespace trimray::nurbs {
namespace {

[[noreturn]] void fail(const std::string& what) { throw ArgumentError("mesh: " + what); }

void check(std::span<const dvec3> vertices, std::span<const Triangle> triangles,
           std::span<const MeshGroup> groups) {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (vertices.size() > kMost || triangles.size() > kMost) fail("too many vertices or triangles");
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (!sound_vertex(vertices[i])) fail("vertex " + std::to_string(i) + " is not finite");
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (const std::int32_t v : triangles[i])
      if (v < 0 || static_cast<std::size_t>(v) >= vertices.size())
        fail("triangle " + std::to_string(i) + " names a vertex that is not there");
  std::int32_t last = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].end <= last) fail("group " + std::to_string(i) + " has no triangles");
    last = groups[i].end;
  }
  if (static_cast<std::size_t>(last) != triangles.size()) fail("the groups do not cover the triangles");
}

// For every vertex, the first of those at its place.
std::vector<std::int32_t> places(std::span<const dvec3> vertices) {
  const auto key = [&](std::int32_t i) { return std::tuple(vertices[i].x, vertices[i].y, vertices[i].z, i); };
  std::vector<std::int32_t> order(vertices.size()), place(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) { return key(a) < key(b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    place[order[i]] = same ? place[order[i - 1]] : order[i];
  }
  return place;
}

// Is there, for every side of a triangle, exactly one that runs the other way, and none that runs with it?
// corner[v - first] stands for vertex v.
bool pairs_up(std::span<const Triangle> triangles, std::int32_t first, std::span<const std::int32_t> corner) {
  const auto for_sides = [&](const auto& use) {
    for (const Triangle& t : triangles) {
      const std::int32_t v[3] = {corner[t[0] - first], corner[t[1] - first], corner[t[2] - first]};
      if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
      for (int k = 0; k < 3; ++k) use(v[k], v[(k + 1) % 3]);
    }
  };
  // By the smaller end: twice the larger one, and one more where the side runs down.
  std::vector<std::size_t> begin(corner.size() + 1, 0);
  for_sides([&](std::int32_t a, std::int32_t b) { ++begin[static_cast<std::size_t>(std::min(a, b)) + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> sides(begin.back());
  std::vector<std::size_t> end = begin;
  for_sides([&](std::int32_t a, std::int32_t b) {
    sides[end[std::min(a, b)]++] = static_cast<std::uint32_t>(std::max(a, b)) << 1 | (a > b ? 1u : 0u);
  });
  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    const auto from = sides.begin() + static_cast<std::ptrdiff_t>(begin[v]),
               to = sides.begin() + static_cast<std::ptrdiff_t>(begin[v + 1]);
    std::sort(from, to);
    if ((to - from) % 2 != 0) return false;
    for (auto i = from; i != to; i += 2) {
      const bool pair = i[0] % 2 == 0 && i[1] == i[0] + 1;
      if (!pair || (i + 2 != to && i[2] == i[1])) return false;
    }
  }
  return !sides.empty();
}

}  // namespace

bool sound_vertex(const dvec3& p) {
  const dvec3 q = glm::abs(p);
  return q.x < kMaxCoordinate && q.y < kMaxCoordinate && q.z < kMaxCoordinate;  // false for NaN
}

void make_mesh_face(Face& face, Range triangles) {
  face.triangles = triangles;
  face.status = FaceStatus::kOk;
  face.reversed = false;
  face.iso_rectangle = true;
  face.uv_box.lower = dvec2(0.0), face.uv_box.upper = dvec2(1.0);
}

bool closes_up(std::span<const dvec3> vertices, std::span<const Triangle> triangles) {
  if (triangles.empty()) return false;
  std::int32_t first = triangles[0][0], last = first;  // a shell uses neighbouring vertices
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) first = std::min(first, v), last = std::max(last, v);
  std::vector<std::int32_t> corner(static_cast<std::size_t>(last - first) + 1);
  std::iota(corner.begin(), corner.end(), 0);
  return pairs_up(triangles, first, corner) ||
         pairs_up(triangles, first, places(vertices.subspan(first, corner.size())));
}

NurbsStore mesh_store(std::vector<dvec3> vertices, std::vector<Triangle> triangles,
                      std::span<const MeshGroup> groups, std::string meta) {
  check(vertices, triangles, groups);
  NurbsStore store;
  store.mesh_vertices = std::move(vertices), store.mesh_triangles = std::move(triangles);
  store.meta = std::move(meta);
  const auto faces = static_cast<std::int32_t>(groups.size());
  Prototype prototype;
  prototype.faces = {0, faces};
  for (const Triangle& t : store.mesh_triangles)
    for (const std::int32_t v : t) prototype.bounds.add(store.mesh_vertices[v]);
  if (faces > 0) {
    prototype.shells = {0, 1};
    store.shells.push_back({0, {0, faces}, closes_up(store.mesh_vertices, store.mesh_triangles)});
    store.surfaces.emplace_back().kind = SurfaceKind::kMesh;  // shared: it says nothing else
  }
  std::int32_t last = 0;
  for (const MeshGroup& group : groups) {
    Face& face = store.faces.emplace_back();
    face.surface = face.prototype = face.shell = 0;
    face.shape = static_cast<std::int32_t>(store.faces.size());
    make_mesh_face(face, {last, group.end});
    std::copy_n(group.color, 4, face.color);
    last = group.end;
  }
  store.prototypes.push_back(prototype);
  store.instances.emplace_back().prototype = 0;
  return store;
}

}  // namespace trimray::nurbs
