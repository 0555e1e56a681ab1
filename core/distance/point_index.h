// Exact distances from points to a trimmed model: a hierarchy over the pieces of its faces and edges,
// searched nearest first. A piece is dropped only when a proven bound shows that nothing on it is nearer than
// what is known; on the others Newton's method is trusted only where the distance is proven convex, and
// elsewhere pieces are halved (patches), or there is a closed form (planes ... tori), or they are triangles.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/distance/nearest.h"
#include "core/nurbs/store.h"

namespace trimray::distance {

struct IndexStats {
  std::int64_t surface_leaves = 0, closed_leaves = 0, triangle_blocks = 0, edge_leaves = 0, bytes = 0;
};

class PointIndex {
 public:
  // Instances share the index of their prototype, but where a placement stretches directions differently.
  explicit PointIndex(std::shared_ptr<const nurbs::NurbsStore> store, int threads = 0);
  PointIndex(PointIndex&&) noexcept;
  ~PointIndex();

  // The nearest points of the faces, or of the edges alone: those that faces which can be drawn use. In the
  // world; out has the length of points. The same bits for any number of threads.
  void nearest(std::span<const dvec3> points, std::span<Nearest> out, int threads = 0,
               bool edges_only = false) const;
  Nearest nearest(const dvec3& point, bool edges_only = false) const;

  // Of the box of all that was indexed, in the world, mm.
  double diagonal() const;
  // Faces of which something is missing, ascending: those that cannot be drawn, and those that hold numbers
  // which cannot be searched.
  std::span<const std::int32_t> left_out() const;
  const IndexStats& stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trimray::distance
