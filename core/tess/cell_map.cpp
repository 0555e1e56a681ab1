#include "core/tess/cell_map.h"

#include <algorithm>
#include <cmath>

namespace trimray::tess {
namespace {

constexpr double kUneven = 6.0;

}  // namespace

CellMap::CellMap(const Box2& box) {
  const double size = std::max(box.extent().x, box.extent().y);
  if (!(size > 0.0)) return;
  for (int d = 0; d < 2; ++d)
    axis_[d].chart = {box.lower[d], box.lower[d] + size}, axis_[d].cells = {0.0, 1.0};
}

CellMap::CellMap(const CurvatureTree& tree, const Box2& box) {
  const dvec2 extent = box.extent();
  if (!(extent.x > 0.0 && extent.y > 0.0)) return;
  for (int d = 0; d < 2; ++d) {
    std::vector<double> at{box.lower[d], box.upper[d]};
    for (const GridLeaf& leaf : tree.leaves())
      for (const double x : {leaf.box.lower[d], leaf.box.upper[d]})
        if (x > box.lower[d] && x < box.upper[d]) at.push_back(x);
    std::sort(at.begin(), at.end());
    std::vector<double> chart{at.front()};
    for (const double x : at)
      if (x > chart.back() + 1e-9 * extent[d]) chart.push_back(x);
    if (chart.size() < 2) return;
    chart.back() = box.upper[d];
    // Cells a unit of the chart, the mean over the other direction: differences of what begins and ends.
    std::vector<double> density(chart.size(), 0.0), weight(chart.size(), 0.0);
    for (const GridLeaf& leaf : tree.leaves()) {
      const double across = std::min(leaf.box.upper[1 - d], box.upper[1 - d]) -
                            std::max(leaf.box.lower[1 - d], box.lower[1 - d]);
      if (!(across > 0.0)) continue;
      const auto index = [&](double x) {
        return std::lower_bound(chart.begin(), chart.end(), x - 1e-9 * extent[d]) - chart.begin();
      };
      const auto begin = index(std::max(leaf.box.lower[d], box.lower[d])),
                 end = index(std::min(leaf.box.upper[d], box.upper[d]));
      const double cells = (d == 0 ? leaf.count_u : leaf.count_v) / (leaf.box.upper[d] - leaf.box.lower[d]);
      if (!(begin < end) || !std::isfinite(cells)) continue;
      density[begin] += across * cells, weight[begin] += across;
      density[end] -= across * cells, weight[end] -= across;
    }
    const double even = 1.0 / extent[d];
    std::vector<double> cells{0.0};
    double sum = 0.0, all = 0.0;
    for (std::size_t i = 0; i + 1 < chart.size(); ++i) {
      sum += density[i], all += weight[i];
      const double mean = all > 1e-9 * extent[1 - d] ? std::max(sum / all, even) : even;
      cells.push_back(cells.back() + mean * (chart[i + 1] - chart[i]));
    }
    // Bending straight sides makes slivers along them, so it is done only where it is worth it.
    double least = kInf, most = 0.0;
    for (std::size_t i = 0; i + 1 < chart.size(); ++i) {
      const double slope = (cells[i + 1] - cells[i]) / (chart[i + 1] - chart[i]);
      least = std::min(least, slope), most = std::max(most, slope);
    }
    if (most < kUneven * least) chart = {chart.front(), chart.back()}, cells = {0.0, cells.back()};
    axis_[d].chart = std::move(chart), axis_[d].cells = std::move(cells);
  }
}

void CellMap::make_even() {
  for (Axis& axis : axis_)
    if (!axis.chart.empty())
      axis.chart = {axis.chart.front(), axis.chart.back()}, axis.cells = {0.0, axis.cells.back()};
}

double CellMap::Axis::map(const std::vector<double>& a, const std::vector<double>& b, double x) {
  const auto above = std::upper_bound(a.begin() + 1, a.end() - 1, x) - a.begin();
  return b[above - 1] + (x - a[above - 1]) * (b[above] - b[above - 1]) / (a[above] - a[above - 1]);
}

}  // namespace trimray::tess
