// The shared paths of edges, cut into leaves, and the nearest point on a leaf.
#pragma once

#include <vector>

#include "core/base/box.h"
#include "core/distance/search.h"
#include "core/trace/edge_rule_path.h"

namespace trimray::distance {

// A stretch of one piece of a path, or a straight link. Coordinates relative to EdgePaths::middle.
struct EdgeLeaf {
  std::int32_t edge = -1;   // NurbsStore::edges
  std::int32_t piece = -1;  // EdgePaths::pieces; -1: the straight line from a to b
  double s0 = 0.0, s1 = 1.0;
  dvec3 a{0.0}, b{0.0};  // the stretch lies within radius of the line between them
  double radius = 0.0;
  double convex = 0.0;  // convex_radius() of it
};

struct EdgeFoot {
  double distance = kInf;
  dvec3 p{0.0};
  std::int32_t edge = -1;
  double t = 0.0;  // the edge's parameter; 0 at its start and 1 at its end where it has no pieces
};

// Does a face which can be drawn use the edge?
bool is_used(const nurbs::NurbsStore& store, const nurbs::Edge& edge);

// The leaves of all edges of one prototype that a face which can be drawn uses.
class EdgeLeaves {
 public:
  EdgeLeaves(const nurbs::NurbsStore& store, std::int32_t prototype);

  // Boxes of the leaves, in the prototype's coordinates.
  std::vector<Box3> boxes() const;
  std::size_t size() const { return leaves_.size(); }
  const EdgeLeaf& operator[](std::size_t i) const { return leaves_[i]; }

  // Replaces best by a nearer point of the leaf. slack: mm, what is nearer by less need not be found.
  bool nearest(std::size_t leaf, const dvec3& q, double slack, EdgeFoot& best, Workspace& work) const;

  std::int64_t bytes() const;

 private:
  void cut(std::int32_t edge, std::int32_t piece, double s0, double s1, int depth);
  bool offer(const EdgeLeaf& leaf, const Foot& foot, EdgeFoot& best) const;
  bool examine(const EdgeLeaf& leaf, const Domain& domain, const dvec3& q, double slack, EdgeFoot& best,
               Workspace& work) const;

  trace::EdgePaths paths_;
  std::vector<EdgeLeaf> leaves_;
};

}  // namespace trimray::distance
