// TriMesh: triangles over exact surfaces, in flat arrays.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace trimray::tess {

// A vertex is a place in space: faces that share an edge share its vertices, a pole is one vertex, a seam is
// one row of vertices with two uv. The uv of a place depends on the face, so it stands with the triangle's
// corner. Triangles run counter-clockwise seen from outside.
struct TriMesh {
  std::vector<dvec3> vertices;                         // mm
  std::vector<std::array<std::int32_t, 3>> triangles;  // into vertices
  std::vector<std::array<dvec2, 3>> corner_uv;         // uv_face, by triangle; barycentric for mesh faces
  std::vector<std::int32_t> face;                      // NurbsStore::faces, by triangle
  // By triangle, mm, proven: no point of the triangle is farther from the face's surface (untrimmed); and
  // for a side on an edge of the model no point of the side is farther from the edge's curve, nor any point
  // of the curve between the side's ends from the side. 0 for mesh faces, whose triangles are the truth.
  // kInf where nothing is proven (fallback).
  std::vector<double> deviation;
};

}  // namespace trimray::tess
