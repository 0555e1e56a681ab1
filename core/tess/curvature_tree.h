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

// What is known over a box of the chart: besides second derivatives, kinks. At a knot of full multiplicity Su
// or Sv jumps; kink is the box of these jumps, each times the length (in the chart) of the shorter part of
// the box beside the knot, and so what it can do to a straight interpolation, kinks their number.
struct CurvatureRange {
  DerivativeRange second;
  Box3 kink;
  int kinks = 0;
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
  // The kink in direction d (0: u) that lies between two coordinates and nearest to their middle; kNaN: none.
  double kink_between(int d, double a, double b) const;

 private:
  struct Node {
    Box2 box;
    DerivativeRange second;
    Box3 jump[2];  // of Su and of Sv, at all kinks inside
    int kinks[2] = {0, 0};
    Box3 own;             // at the line between the children
    bool kinked = false;  // there is one
    int child[2] = {-1, -1};
    int patch = -1;  // of a leaf
  };
  struct Builder;

  void gather(int node, const Box2& box, bool sharp, CurvatureRange& out) const;
  DerivativeRange part_of_leaf(const Node& leaf, const Box2& box) const;

  const nurbs::Surface& surface_;
  nurbs::BezierPatches patches_;  // none for closed forms
  bool rational_ = false;
  std::vector<double> kinks_[2];  // sorted
  std::vector<Node> nodes_;
  std::vector<GridLeaf> leaves_;
};

}  // namespace trimray::tess
