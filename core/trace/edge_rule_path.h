// The 3D paths of a prototype's edges, and how often each crosses a half-line seen along a ray.
#pragma once

#include <cstdint>
#include <vector>

#include "core/nurbs/store.h"
#include "core/trace/ray.h"

namespace trimray::trace {

// A ray as the edges see it: everything projected along dir onto (e1, e2), the ray at the origin.
// e1 x e2 = dir, built from dir alone.
struct RayFrame {
  dvec3 org{0.0};  // on the ray, next to the prototype's middle, relative to it
  dvec3 dir{0.0}, e1{0.0}, e2{0.0};
  double t_shift = 0.0;  // t of org
  dvec2 project(dvec3 local) const { return {glm::dot(e1, local - org), glm::dot(e2, local - org)}; }
};

// One rational Bezier piece of an edge, relative to the prototype's middle.
struct PathPiece {
  std::int32_t ctrl = 0, degree = 0;  // EdgePaths::ctrl_h
  double t0 = 0.0, t1 = 0.0;          // the edge's parameter
};

// joints: vertex 0, piece starts, last piece's end, vertex 1. Both are contiguous per edge. An edge without
// pieces has its two vertices only.
struct PathEdge {
  std::int32_t joint = 0, joint_count = 0;
  std::int32_t piece = 0, piece_count = 0;
  double band = 0.0;
  dvec3 center{0.0}, half{0.0};  // of a box round the whole path, a little larger for rounding
};

// Paths of the edges store.prototypes[p].edges, in that order. Coordinates are relative to `middle`.
struct EdgePaths {
  EdgePaths(const nurbs::NurbsStore& store, std::int32_t prototype);

  RayFrame frame(const Ray& ray) const;

  // Signed crossings of the path with the half-line {y = 0, x > 0}: +1 from y < 0 to y >= 0. Depends on
  // the path and the ray alone. Where a point of the path is too close to the origin for double, either
  // answer may come, but the same one every time.
  int crossings(std::int32_t local_edge, const RayFrame& frame) const;

  // Does the ray pass to the left (+1) or right (-1) of a piece near its parameter s, the piece seen from the
  // tip of dir? 0 at the piece's ends, and where the piece runs along the ray. Agrees with crossings().
  int side(std::int32_t local_edge, std::int32_t piece, double s, const RayFrame& frame) const;

  dvec3 middle{0.0};
  double diagonal = 0.0;  // of the box of all paths; every path lies within diagonal / 2 of middle
  std::int32_t first_edge = 0;
  std::vector<PathEdge> edges;
  std::vector<PathPiece> pieces;
  std::vector<dvec3> joints;
  std::vector<dvec4> ctrl_h;  // (w x, w y, w z, w)
};

}  // namespace trimray::trace
