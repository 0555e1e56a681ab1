// Closed meshes that tests trace, save and merge.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "core/nurbs/mesh_store.h"

namespace trimray::testing {

struct TestMesh {
  std::vector<dvec3> vertices;
  std::vector<nurbs::Triangle> triangles;
};

inline TestMesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

// Sides n x n squares of two triangles each, from lower to upper. Faces share no vertices where not welded.
inline TestMesh box_mesh(const dvec3& lower, const dvec3& upper, int n, bool welded = true) {
  TestMesh mesh;
  std::map<std::array<double, 3>, std::int32_t> known;
  const auto vertex = [&](const dvec3& unit) {
    const dvec3 p = lower + unit * (upper - lower);
    const auto next = static_cast<std::int32_t>(mesh.vertices.size());
    const std::int32_t v = welded ? known.try_emplace({p.x, p.y, p.z}, next).first->second : next;
    if (v == next) mesh.vertices.push_back(p);
    return v;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int a, int b) {
            dvec3 p;
            p[axis] = side, p[(axis + 1) % 3] = double(i + a) / n, p[(axis + 2) % 3] = double(j + b) / n;
            return vertex(p);
          };
          const std::int32_t p = corner(0, 0), q = corner(1, 0), r = corner(1, 1), s = corner(0, 1);
          if (side == 1)
            mesh.triangles.insert(mesh.triangles.end(), {{p, q, r}, {p, r, s}});
          else
            mesh.triangles.insert(mesh.triangles.end(), {{p, r, q}, {p, s, r}});
        }
  return mesh;
}

// An octahedron, each triangle cut into four `levels` times, put on the sphere.
inline TestMesh ball_mesh(const dvec3& center, double radius, int levels) {
  TestMesh mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::array<std::int32_t, 2>, std::int32_t> middles;
    std::vector<nurbs::Triangle> cut;
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const auto [it, fresh] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                   static_cast<std::int32_t>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back(glm::normalize(mesh.vertices[a] + mesh.vertices[b]));
      return it->second;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      cut.insert(cut.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(cut);
  }
  for (dvec3& v : mesh.vertices) v = center + radius * v;
  return mesh;
}

// One face.
inline nurbs::NurbsStore store_of(const TestMesh& mesh) {
  const nurbs::MeshGroup all{static_cast<std::int32_t>(mesh.triangles.size())};
  return nurbs::mesh_store(mesh.vertices, mesh.triangles, {&all, 1}, "{}");
}

// A face for every `each` triangles.
inline nurbs::NurbsStore store_in_groups(const TestMesh& mesh, std::int32_t each) {
  std::vector<nurbs::MeshGroup> groups;
  const auto count = static_cast<std::int32_t>(mesh.triangles.size());
  for (std::int32_t end = each; end < count + each; end += each) groups.push_back({std::min(end, count)});
  return nurbs::mesh_store(mesh.vertices, mesh.triangles, groups, "{}");
}

}  // namespace trimray::testing
