#include "core/nurbs/trim_grid.h"

#include <cmath>

namespace trimray::nurbs {

// A segment in one row: the columns it may touch, and how it counts for the cells to the left of them.
struct TrimGrid::RowEntry {
  std::uint32_t index = 0;
  int first_column = 0, last_column = 0;
  bool from_below = false;     // it crosses the row's foot
  double changes[2] = {0, 0};  // heights in this row where it starts or ends
  int change_count = 0;
};

TrimGrid::TrimGrid(TrimSegments&& trims)
    : box_(trims.box), segments_(std::move(trims.segments)), ctrl_h_(std::move(trims.ctrl_h)) {
  choose_resolution();
  std::vector<std::vector<std::uint32_t>> in_row(rows_);
  for (std::uint32_t i = 0; i < segments_.size(); ++i)
    for (int r = row(segments_[i].lo.y); r <= row(segments_[i].hi.y); ++r) in_row[r].push_back(i);

  std::vector<RowEntry> entries;
  std::vector<std::vector<std::uint32_t>> lists(columns_);
  std::vector<std::vector<double>> changes(columns_);
  std::vector<char> base(columns_);
  cells_.reserve(static_cast<std::size_t>(rows_) * columns_ + 1);
  for (int r = 0; r < rows_; ++r) {
    entries.clear();
    for (std::uint32_t i : in_row[r]) entries.push_back(row_entry(i, r));
    for (auto& list : lists) list.clear();
    for (const RowEntry& e : entries)
      for (int c = e.first_column; c <= e.last_column; ++c) lists[c].push_back(e.index);

    // From right to left, each column inherits what the one to its right has gathered.
    std::sort(entries.begin(), entries.end(), [](const RowEntry& a, const RowEntry& b) {
      return a.first_column != b.first_column ? a.first_column > b.first_column : a.index < b.index;
    });
    std::size_t next = 0;
    bool parity = false;
    std::vector<double> gathered;  // ascending, no value twice
    for (int c = columns_ - 1; c >= 0; --c) {
      for (; next < entries.size() && entries[next].first_column > c; ++next) {
        parity ^= entries[next].from_below;
        for (int k = 0; k < entries[next].change_count; ++k) {
          const double v = entries[next].changes[k];
          const auto at = std::lower_bound(gathered.begin(), gathered.end(), v);
          if (at != gathered.end() && *at == v)
            gathered.erase(at);
          else
            gathered.insert(at, v);
        }
      }
      changes[c] = gathered, base[c] = parity;
    }
    for (int c = 0; c < columns_; ++c) {
      cells_.push_back({static_cast<std::uint32_t>(cell_segments_.size()),
                        static_cast<std::uint32_t>(cell_changes_.size()) | (base[c] ? kBase : 0)});
      cell_segments_.insert(cell_segments_.end(), lists[c].begin(), lists[c].end());
      cell_changes_.insert(cell_changes_.end(), changes[c].begin(), changes[c].end());
    }
  }
  cells_.push_back(
      {static_cast<std::uint32_t>(cell_segments_.size()), static_cast<std::uint32_t>(cell_changes_.size())});
}

// A side of 2 sqrt(n) cells: a single loop of n segments then leaves most cells empty and puts one or two
// segments into the others.
void TrimGrid::choose_resolution() {
  const dvec2 extent = box_.empty() ? dvec2(0.0) : box_.extent();
  const int side =
      std::clamp(static_cast<int>(2.0 * std::sqrt(static_cast<double>(segments_.size()))) + 2, 4, 256);
  columns_ = extent.x > 0.0 ? side : 1;
  rows_ = extent.y > 0.0 ? side : 1;
  scale_ = {extent.x > 0.0 ? columns_ / extent.x : 0.0, extent.y > 0.0 ? rows_ / extent.y : 0.0};
  // Boxes so thin that the scale overflows are one cell.
  if (!std::isfinite(scale_.x)) scale_.x = 0.0, columns_ = 1;
  if (!std::isfinite(scale_.y)) scale_.y = 0.0, rows_ = 1;
}

TrimGrid::RowEntry TrimGrid::row_entry(std::uint32_t index, int r) const {
  const TrimSegment& s = segments_[index];
  RowEntry e;
  e.index = index;
  const int first = row(s.lo.y), last = row(s.hi.y);
  e.from_below = first < r;
  if (first == r) e.changes[e.change_count++] = s.lo.y;
  if (last == r) e.changes[e.change_count++] = s.hi.y;

  // The chord between the row's lines, as wide as the curve's band, within the segment's own box. The row is
  // taken a little taller than it is, for rounding.
  double left = std::min(s.lo.x, s.hi.x), right = std::max(s.lo.x, s.hi.x);
  if (rows_ > 1 && last > first) {
    const dvec2 d = s.hi - s.lo;
    const double foot = std::max(s.lo.y, box_.lower.y + (r - 0.01) / scale_.y);
    const double head = std::min(s.hi.y, box_.lower.y + (r + 1.01) / scale_.y);
    const double u0 = s.lo.x + d.x * ((foot - s.lo.y) / d.y), u1 = s.lo.x + d.x * ((head - s.lo.y) / d.y);
    // A curve point with cross product c lies c / d.y to the left of the chord at its height.
    const double margin = 1e-3 / (scale_.x > 0.0 ? scale_.x : 1.0);
    left = std::max(left, std::min(u0, u1) - s.cross_max / d.y - margin);
    right = std::min(right, std::max(u0, u1) - s.cross_min / d.y + margin);
  }
  e.first_column = column(left), e.last_column = std::max(column(left), column(right));
  return e;
}

int TrimGrid::coverage(const Box2& query) const {
  constexpr int kOutside = -1, kMixed = 0, kInside = 1;
  if (query.empty() || box_.empty() || query.upper.x < box_.lower.x || query.lower.x > box_.upper.x ||
      query.upper.y < box_.lower.y || query.lower.y > box_.upper.y)
    return kOutside;
  const bool reaches_out = !(box_.contains(query.lower) && box_.contains(query.upper));
  const int c0 = column(query.lower.x), c1 = column(query.upper.x);
  const int r0 = row(query.lower.y), r1 = row(query.upper.y);
  bool seen[2] = {reaches_out, false};
  for (int r = r0; r <= r1; ++r) {
    for (int c = c0; c <= c1; ++c) {
      const Cell* cell = &cells_[r * columns_ + c];
      if (cell[0].segments != cell[1].segments) return kMixed;
      if ((cell[0].changes_and_base & ~kBase) != (cell[1].changes_and_base & ~kBase)) return kMixed;
      seen[(cell[0].changes_and_base & kBase) != 0] = true;
      if (seen[0] && seen[1]) return kMixed;
    }
  }
  return seen[1] ? kInside : kOutside;
}

}  // namespace trimray::nurbs
