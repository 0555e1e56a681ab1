// Samples of a model's edges and faces, among which the points are sought that reach farthest.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/nurbs/store.h"
#include "core/nurbs/trim.h"
#include "core/trace/neighbours.h"

namespace trimray::trace {

inline constexpr std::size_t kCornersAtOnce = 64;

// Samples of one edge piece or of one face's inside; the neighbours of a sample are at most `gap` away. Or
// the corners of some mesh triangles, which nothing reaches beyond.
struct Samples {
  std::vector<dvec3> points;
  std::vector<dvec2> uv;  // faces only
  Box3 box;
  double gap = 0.0;
  std::int32_t face = kNoFace, piece = -1;  // one of the two; neither for corners
  dvec2 step{0.0};                          // faces only: of the grid
};

// The corners of a prototype's mesh triangles, neighbours together.
std::vector<Neighbour> mesh_corners(const nurbs::NurbsStore& store, const nurbs::Range& faces, int threads);

// The k-th kCornersAtOnce of them.
Samples sample_corners(const nurbs::NurbsStore& store, std::span<const Neighbour> corners, std::size_t k);

Samples sample_piece(const nurbs::NurbsStore& store, std::int32_t index);

// Only a surface that bends both ways can reach beyond the boundary of its face.
bool bulges(const nurbs::NurbsStore& store, const nurbs::Face& face);

bool face_contains(const nurbs::TrimIndex& trims, const nurbs::NurbsStore& store, std::int32_t face,
                   const dvec2& uv);

// Of its inside, on a grid; none where a point of it is not finite.
Samples sample_face(const nurbs::NurbsStore& store, const nurbs::TrimIndex& trims, std::int32_t index);

}  // namespace trimray::trace
