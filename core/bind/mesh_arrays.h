// Meshes as NumPy arrays.
#pragma once

#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "core/bind/bind.h"
#include "core/tess/tessellate.h"

namespace trimray::bind {

// vertices (n, 3), triangles (m, 3), corner_uv (m, 3, 2), face (m,), deviation (m,).
using MeshArrays = std::tuple<Out<double>, Out<std::int32_t>, Out<double>, Out<std::int32_t>, Out<double>>;
using Issues = std::vector<std::pair<std::int32_t, std::string>>;

inline MeshArrays mesh_arrays(const tess::TriMesh& mesh) {
  const std::size_t n = mesh.vertices.size(), m = mesh.triangles.size();
  std::vector<double> vertices, uv;
  std::vector<std::int32_t> triangles;
  vertices.reserve(3 * n), uv.reserve(6 * m), triangles.reserve(3 * m);
  for (const dvec3& v : mesh.vertices) vertices.insert(vertices.end(), {v.x, v.y, v.z});
  for (const auto& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  for (const auto& t : mesh.corner_uv)
    for (const dvec2& p : t) uv.insert(uv.end(), {p.x, p.y});
  auto face = mesh.face;
  auto deviation = mesh.deviation;
  return {array(std::move(vertices), {n, 3}), array(std::move(triangles), {m, 3}),
          array(std::move(uv), {m, 3, 2}), array(std::move(face), {m}), array(std::move(deviation), {m})};
}

inline Issues issues_of(const tess::Tessellation& t) {
  Issues issues;
  for (const tess::TessIssue& issue : t.issues) issues.push_back({issue.face, issue.reason});
  return issues;
}

}  // namespace trimray::bind
