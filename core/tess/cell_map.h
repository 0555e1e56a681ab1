// CellMap: from the chart to a plane in which the cells of a face's grid are about unit squares. There
// Delaunay triangles are of the shape that the curvature wants, however unevenly the parametrization runs.
#pragma once

#include <vector>

#include "core/tess/curvature_tree.h"

namespace trimray::tess {

class CellMap {
 public:
  CellMap() = default;  // leaves all as it is
  // Planes: one cell, as wide as high.
  explicit CellMap(const Box2& box);
  CellMap(const CurvatureTree& tree, const Box2& box);

  // The same scale everywhere: straight lines stay straight.
  void make_even();

  // Each coordinate is mapped by itself, piecewise linearly and strictly increasing.
  dvec2 to_cells(dvec2 p) const { return {axis_[0].to(p.x), axis_[1].to(p.y)}; }
  dvec2 to_chart(dvec2 c) const { return {axis_[0].from(c.x), axis_[1].from(c.y)}; }

 private:
  struct Axis {
    std::vector<double> chart, cells;  // both increasing; empty: the identity
    double to(double x) const { return chart.empty() ? x : map(chart, cells, x); }
    double from(double x) const { return chart.empty() ? x : map(cells, chart, x); }
    static double map(const std::vector<double>& a, const std::vector<double>& b, double x);
  };
  Axis axis_[2];
};

}  // namespace trimray::tess
