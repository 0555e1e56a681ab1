// Internal to core/distance: the pieces of one prototype and the hierarchy over them.
#pragma once

#include <vector>

#include "core/distance/closed_foot.h"
#include "core/distance/edge_leaf.h"
#include "core/distance/nearest.h"
#include "core/distance/surface_leaf.h"
#include "core/trace/bvh.h"
#include "core/trace/closed_form_leaves.h"
#include "core/trace/triangle_blocks.h"

namespace trimray::distance {

// In the prototype's coordinates.
struct LocalNearest {
  SurfaceFoot face;
  std::int32_t face_index = kNoFace;
  EdgeFoot edge;
  double distance() const { return std::min(face.distance, edge.distance); }
};

struct PrototypeIndex {
  PrototypeIndex(const nurbs::NurbsStore& store, std::int32_t prototype, const nurbs::TrimIndex& trims,
                 int threads);

  // Improves best, whose distances limit the search, where something is nearer. slack: an edge no farther
  // than this behind a face counts as the nearer of the two.
  void search(const dvec3& q, double slack, bool edges_only, LocalNearest& best, Workspace& work) const;

  // Completes a point on an edge: the first face with it, and the uv there.
  void place_on_face(const EdgeFoot& foot, std::int32_t& face, dvec2& uv_face) const;

  const nurbs::NurbsStore& store;
  const nurbs::TrimIndex& trims;
  SurfaceLeaves surfaces;
  EdgeLeaves edges;
  std::vector<trace::ClosedForm> forms;  // by face of the prototype
  std::vector<trace::ClosedLeaf> closed_leaves;
  trace::TriangleBlocks triangles;
  enum class Kind : std::uint8_t { kClosed, kPatch, kTriangles, kEdge };
  struct Primitive {
    Kind kind;
    std::int32_t index;
  };
  std::vector<Primitive> primitives;  // of bvh
  trace::Bvh bvh, edge_bvh;           // of all; of the leaves of edges
  Box3 box;
  std::vector<std::int32_t> left_out;

 private:
  std::int32_t first_face_;
  void append_face(std::int32_t face, std::vector<Box3>& patch_boxes);
  void visit(const Primitive& primitive, const dvec3& q, double slack, LocalNearest& best,
             Workspace& work) const;
  void visit_closed(const trace::ClosedLeaf& leaf, const dvec3& q, LocalNearest& best) const;
  void visit_triangles(std::size_t block, const dvec3& q, LocalNearest& best) const;
  void visit_edge(std::size_t leaf, const dvec3& q, double slack, LocalNearest& best, Workspace& work) const;
};

// Visits the primitives of a hierarchy whose boxes are nearer to q than limit(), the nearest first where that
// costs nothing. visit(primitive) may lower the limit.
template <typename Limit, typename Visit>
void visit_nearest(const trace::Bvh& bvh, const dvec3& point, const Limit& limit, const Visit& visit) {
  if (bvh.nodes.empty()) return;
  struct Entry {
    double square;
    std::int32_t child;
  };
  Entry stack[trace::kBvhDepth * trace::kBvhWidth];
  int size = 0;
  const dvec3 q = point - bvh.center;
  stack[size++] = {0.0, 0};
  while (size > 0) {
    const Entry top = stack[--size];
    const double most = limit();
    if (!(top.square < most * most)) continue;
    if (top.child < 0) {
      visit(~top.child);
      continue;
    }
    const trace::BvhNode& node = bvh.nodes[top.child];
    double squares[trace::kBvhWidth];
    for (int i = 0; i < trace::kBvhWidth; ++i) squares[i] = 0.0;
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < trace::kBvhWidth; ++i) {
        const double below = node.lower[axis][i] - q[axis], above = q[axis] - node.upper[axis][i];
        const double out = std::max(std::max(below, above), 0.0);
        squares[i] += out * out;
      }
    // Farthest first onto the stack; of equals, those that came first come out first.
    const int first = size;
    for (int i = node.count; i-- > 0;) {
      if (!(squares[i] < most * most)) continue;
      int k = size++;
      for (; k > first && stack[k - 1].square < squares[i]; --k) stack[k] = stack[k - 1];
      stack[k] = {squares[i], node.child[i]};
    }
  }
}

}  // namespace trimray::distance
