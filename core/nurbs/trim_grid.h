// A face's trim segments in a grid over their box: the inside test looks at one cell.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/nurbs/trim_segment.h"

namespace trimray::nurbs {

// Even-odd test by the half-line from uv towards +u. A cell lists the segments that pass through it; what
// lies wholly to the right of the cell is summed up as the parity of its crossings at the foot of the
// cell's row, and the heights in the row where that parity changes (hardly ever any: where two segments
// meet, both change it and cancel).
class TrimGrid {
 public:
  TrimGrid() = default;
  explicit TrimGrid(TrimSegments&& trims);

  const Box2& box() const { return box_; }
  bool inside(dvec2 uv) const;
  // TrimIndex::inside(): the cells first, so that the memory answers for all points at once.
  std::uint32_t inside(const double* u, const double* v, std::uint32_t which) const;

  // +1: the whole box is inside, -1: outside, 0: not known.
  int coverage(const Box2& query) const;

 private:
  struct Cell {
    std::uint32_t segments;          // first in cell_segments_; the next cell's is the end
    std::uint32_t changes_and_base;  // first in cell_changes_, and the base parity in the top bit
  };
  static constexpr std::uint32_t kBase = 1u << 31;

  // Monotone in its argument, which is all that the inside test relies on.
  int column(double u) const { return clamp((u - box_.lower.x) * scale_.x, columns_); }
  int row(double v) const { return clamp((v - box_.lower.y) * scale_.y, rows_); }
  static int clamp(double x, int count) {
    return static_cast<int>(std::min(std::max(x, 0.0), static_cast<double>(count - 1)));
  }

  const Cell* cell(dvec2 uv) const { return &cells_[row(uv.y) * columns_ + column(uv.x)]; }
  bool in_cell(const Cell* cell, dvec2 uv) const;

  struct RowEntry;
  class RowBuilder;
  void choose_resolution();
  RowEntry row_entry(std::uint32_t index, int r) const;

  Box2 box_;
  dvec2 scale_{0.0};
  int columns_ = 0, rows_ = 0;
  std::vector<Cell> cells_;  // row by row, and one more
  std::vector<std::uint32_t> cell_segments_;
  std::vector<double> cell_changes_;
  std::vector<TrimSegment> segments_;
  std::vector<dvec3> ctrl_h_;
};

inline bool TrimGrid::in_cell(const Cell* cell, dvec2 uv) const {
  bool parity = cell[0].changes_and_base & kBase;
  for (std::uint32_t i = cell[0].changes_and_base & ~kBase; i < (cell[1].changes_and_base & ~kBase); ++i)
    parity ^= cell_changes_[i] <= uv.y;
  for (std::uint32_t i = cell[0].segments; i < cell[1].segments; ++i) {
    const TrimSegment& s = segments_[cell_segments_[i]];
    if (uv.y >= s.lo.y && uv.y < s.hi.y) parity ^= segment_is_right(s, ctrl_h_.data(), uv);
  }
  return parity;
}

inline bool TrimGrid::inside(dvec2 uv) const { return box_.contains(uv) && in_cell(cell(uv), uv); }

inline std::uint32_t TrimGrid::inside(const double* u, const double* v, std::uint32_t which) const {
  std::uint32_t result = 0, busy = 0;
  const Cell* cells[8];
  for (std::uint32_t rest = which; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    const dvec2 uv(u[i], v[i]);
    if (!box_.contains(uv)) continue;
    const Cell* const c = cells[i] = cell(uv);
    // Most cells are empty.
    const bool empty =
        ((c[0].segments ^ c[1].segments) | ((c[0].changes_and_base ^ c[1].changes_and_base) & ~kBase)) == 0;
    result |= (c[0].changes_and_base / kBase) << i;
    busy |= (empty ? 0u : 1u) << i;
  }
  for (; busy != 0; busy &= busy - 1) {
    const int i = std::countr_zero(busy);
    const std::uint32_t bit = 1u << i;
    result = in_cell(cells[i], dvec2(u[i], v[i])) ? result | bit : result & ~bit;
  }
  return result;
}

}  // namespace trimray::nurbs
