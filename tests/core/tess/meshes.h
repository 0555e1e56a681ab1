// Meshes whose counts, area and volume are known.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "core/tess/tri_mesh.h"

namespace trimray::tess {

inline void add_triangle(TriMesh& mesh, std::int32_t a, std::int32_t b, std::int32_t c,
                         std::int32_t face = 0) {
  mesh.triangles.push_back({a, b, c});
  mesh.corner_uv.push_back({});
  mesh.face.push_back(face);
  mesh.deviation.push_back(0.0);
}

// An icosahedron whose triangles are split into four, `levels` times, vertices on the unit sphere.
inline TriMesh icosphere(int levels) {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  TriMesh mesh;
  for (const dvec3& p : {dvec3(-1, g, 0),
                         {1, g, 0},
                         {-1, -g, 0},
                         {1, -g, 0},
                         {0, -1, g},
                         {0, 1, g},
                         {0, -1, -g},
                         {0, 1, -g},
                         {g, 0, -1},
                         {g, 0, 1},
                         {-g, 0, -1},
                         {-g, 0, 1}})
    mesh.vertices.push_back(glm::normalize(p));
  std::vector<std::array<std::int32_t, 3>> faces{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const auto key = std::minmax(a, b);
      const auto [at, added] =
          middles.emplace(std::pair(key.first, key.second), static_cast<std::int32_t>(mesh.vertices.size()));
      if (added) mesh.vertices.push_back(glm::normalize(mesh.vertices[a] + mesh.vertices[b]));
      return at->second;
    };
    std::vector<std::array<std::int32_t, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = finer;
  }
  for (const auto& [a, b, c] : faces) add_triangle(mesh, a, b, c);
  return mesh;
}

// nu x nv cells of a grid; point(i, j) for 0 <= i <= nu, 0 <= j <= nv. Wrapped directions share the vertices
// of their two ends; corner uv are (i, j), the last one not wrapped. flip_u: the last column meets the
// first one upside down.
template <typename Point>
TriMesh grid(int nu, int nv, bool wrap_u, bool wrap_v, const Point& point, bool flip_u = false) {
  TriMesh mesh;
  const int pu = wrap_u ? nu : nu + 1, pv = wrap_v ? nv : nv + 1;
  for (int i = 0; i < pu; ++i)
    for (int j = 0; j < pv; ++j) mesh.vertices.push_back(point(i, j));
  const auto at = [&](int i, int j) {
    if (wrap_u && i == nu) i = 0, j = flip_u ? nv - j : j;
    return (i % pu) * pv + (wrap_v ? j % pv : j);
  };
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < nv; ++j) {
      const dvec2 uv(i, j);
      add_triangle(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.corner_uv.back() = {uv, uv + dvec2(1, 0), uv + dvec2(1, 1)};
      add_triangle(mesh, at(i, j), at(i + 1, j + 1), at(i, j + 1));
      mesh.corner_uv.back() = {uv, uv + dvec2(1, 1), uv + dvec2(0, 1)};
    }
  }
  return mesh;
}

inline TriMesh flat_grid(int nu, int nv) {
  return grid(nu, nv, false, false, [](int i, int j) { return dvec3(i, j, 0.0); });
}

inline TriMesh torus_grid(int nu, int nv, double major, double minor) {
  const double turn = 2.0 * std::numbers::pi;
  return grid(nu, nv, true, true, [=](int i, int j) {
    const double u = turn * i / nu, v = turn * j / nv, r = major + minor * std::cos(v);
    return dvec3(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
  });
}

// nu cells around; one boundary, and its column of cells with the last one turned over does not orient.
inline TriMesh moebius_strip(int nu) {
  const double turn = 2.0 * std::numbers::pi;
  return grid(
      nu, 1, true, false,
      [=](int i, int j) {
        const double u = turn * i / nu, w = j - 0.5, r = 2.0 + w * std::cos(u / 2.0);
        return dvec3(r * std::cos(u), r * std::sin(u), w * std::sin(u / 2.0));
      },
      true);
}

// Three triangles over one edge.
inline TriMesh three_pages() {
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}};
  for (const std::int32_t v : {2, 3, 4}) add_triangle(mesh, 0, 1, v);
  return mesh;
}

inline void add_tetrahedron(TriMesh& mesh, std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  add_triangle(mesh, a, c, b), add_triangle(mesh, a, b, d);
  add_triangle(mesh, b, c, d), add_triangle(mesh, c, a, d);
}

inline TriMesh tetrahedron() {
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  add_tetrahedron(mesh, 0, 1, 2, 3);
  return mesh;
}

// Two closed tetrahedra that share one vertex.
inline TriMesh two_tetrahedra_at_a_vertex() {
  TriMesh mesh = tetrahedron();
  mesh.vertices.insert(mesh.vertices.end(), {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  add_tetrahedron(mesh, 0, 5, 4, 6);
  return mesh;
}

// Two triangles that share one vertex.
inline TriMesh bow_tie() {
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  add_triangle(mesh, 0, 1, 2), add_triangle(mesh, 0, 3, 4);
  return mesh;
}

}  // namespace trimray::tess
