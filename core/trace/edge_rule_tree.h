// A hierarchy over the edge paths of a prototype that finds those a ray passes closely.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/trace/edge_rule.h"
#include "core/trace/edge_rule_path.h"

namespace trimray::trace {

class EdgeTree {
 public:
  // paths must outlive the tree.
  explicit EdgeTree(const EdgePaths& paths);

  // EdgeRule::near_edges; appends in the order of (edge, edge_t).
  void near_edges(const Ray& ray, const RayFrame& frame, std::vector<NearEdge>& out) const;

  // False only if near_edges would find nothing. Cheaper: stops at the first stretch that may be near.
  bool may_be_near(const Ray& ray, const RayFrame& frame) const;

  std::int64_t bytes() const;

 private:
  // A stretch of a path: everything on it lies within `radius` of the straight line a - b, band included.
  struct Stretch {
    dvec3 a{0.0}, b{0.0};
    double radius = 0.0;
    double s0 = 0.0, s1 = 1.0;           // of the piece's own [0, 1]
    std::int32_t edge = -1, piece = -1;  // local edge; piece -1: a straight link, s0 = s1 the end it is at
    bool straight = false;               // a - b is the path itself, s linear along it
  };
  static constexpr int kWidth = 8;
  // Children's boxes in float, relative to the prototype's middle, dilated by the band and by what rounding
  // to float can do. child >= 0: a node; < 0: ~(first stretch * kWidth + count); empty children never hit.
  struct alignas(64) Node {
    float lower[3][kWidth], upper[3][kWidth];
    std::int32_t child[kWidth];
  };

  void add_edge(const EdgePaths& paths, std::int32_t edge);
  void add_stretches(std::int32_t edge, std::int32_t piece, const std::vector<dvec4>& ctrl_h, double s0,
                     double s1, int depth);
  struct Part;
  Part make_part(const std::vector<std::int32_t>& order, std::size_t begin, std::size_t end) const;
  std::size_t cut(std::vector<std::int32_t>& order, const Part& part) const;
  std::int32_t build(std::vector<std::int32_t>& order, std::size_t begin, std::size_t end);
  Box3 stretch_box(const Stretch& s) const;
  bool passes(const Stretch& s, const RayFrame& frame) const;
  bool closest(const Stretch& s, const Ray& ray, const RayFrame& frame, NearEdge& found) const;
  template <typename Visit>
  bool traverse(const Ray& ray, const RayFrame& frame, const Visit& visit) const;

  const EdgePaths* paths_;
  double float_margin_ = 0.0;
  double sphere_radius_ = 0.0;  // round the middle, bands included
  std::vector<Stretch> stretches_;
  std::vector<Node> nodes_;
};

}  // namespace trimray::trace
