// CurvatureTree: bounds on a face's second derivatives over any part of its chart, and from them where
// interior points are wanted.
//
// The root is the face's box; a node is halved at a knot while it holds several Bezier patches, and then
// until its bounds are tight enough for the tolerance that holds there. A leaf carries a regular grid that is
// as coarse as its curvature allows.
#pragma once

#include <vector>

#include "core/nurbs/bezier.h"
#include "core/tess/chart.h"
#include "core/tess/derivative_range.h"
#include "core/tess/tolerance_field.h"

namespace trimray::tess {

// What is known over a box of the chart. At a kink line Su (or Sv) jumps by a vector of kink_u (kink_v): a
// knot of full multiplicity.
struct CurvatureRange {
  DerivativeRange second;
  Box3 kink_u, kink_v;
  int kinks_u = 0, kinks_v = 0;
  void add(const CurvatureRange& r) {
    second.add(r.second);
    kink_u.add(r.kink_u), kink_v.add(r.kink_v);
    kinks_u += r.kinks_u, kinks_v += r.kinks_v;
  }
};

struct GridLeaf {
  Box2 box;
  int count_u = 1, count_v = 1;  // cells; the tolerance is kept when each is split in two triangles
};

class CurvatureTree {
 public:
  // box: of the face's loops in the chart. angle: largest turn of the normal from grid point to grid point,
  // rad.
  CurvatureTree(const nurbs::NurbsStore& store, const Chart& chart, const Box2& box,
                const ToleranceField& tolerance, double angle);

  // sharp: leaves that the box covers in part are looked at again, for ten times the time.
  CurvatureRange over(const Box2& box, bool sharp = true) const;
  const std::vector<GridLeaf>& leaves() const { return leaves_; }

 private:
  struct Node {
    Box2 box;
    CurvatureRange range;
    int child[2] = {-1, -1};
    int patch = -1;  // of a leaf
  };
  struct Builder;

  void gather(int node, const Box2& box, bool sharp, CurvatureRange& out) const;
  DerivativeRange part_of_leaf(const Node& leaf, const Box2& box) const;

  const nurbs::Surface& surface_;
  nurbs::BezierPatches patches_;  // none for closed forms
  bool rational_ = false;
  std::vector<Node> nodes_;
  std::vector<GridLeaf> leaves_;
};

}  // namespace trimray::tess
