#include "core/mass/strips.h"

#include <algorithm>
#include <tuple>

#include "core/mass/loop_pieces.h"

namespace trimray::mass {
namespace {

// A stretch of v that the loops to the right of a cell pass upwards (weight > 0) or downwards begins or ends.
struct Event {
  double v, weight;
};

int cell_of(const std::vector<double>& lines, double x) {
  return static_cast<int>(std::upper_bound(lines.begin(), lines.end(), x) - lines.begin());
}

// Adds up the events at equal v and drops what cancels.
void merge(std::vector<Event>& events) {
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.v < b.v; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < events.size();) {
    Event sum = events[i];
    for (++i; i < events.size() && events[i].v == sum.v; ++i) sum.weight += events[i].weight;
    if (sum.weight != 0.0) events[kept++] = sum;
  }
  events.resize(kept);
}

struct Placed {
  int row, column;
  std::size_t piece;
};

}  // namespace

Strips cut_strips(const nurbs::NurbsStore& store, std::int32_t face_index) {
  const nurbs::Face& face = store.faces[face_index];
  const Box2 box = loops_box(store, face);
  Strips out;
  out.origin = box.center();
  SmoothCells cells = smooth_cells(store, store.surfaces[face.surface], box);
  for (double& u : cells.u) u -= out.origin.x;
  for (double& v : cells.v) v -= out.origin.y;
  LoopPieces loops = cut_loops(store, face, cells, out.origin);
  const std::vector<double> signs = loop_signs(loops);

  std::vector<Placed> placed;
  placed.reserve(loops.pieces.size());
  Box2 reached;
  for (std::size_t i = 0; i < loops.pieces.size(); ++i) {
    const LoopPiece& p = loops.pieces[i];
    const dvec2 middle = 0.5 * (p.from + p.to);
    placed.push_back({cell_of(cells.v, middle.y), cell_of(cells.u, middle.x), i});
    reached.add(p.from), reached.add(p.to);
  }
  // Row by row; in each from the right to the left.
  std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return std::tie(a.row, b.column, a.piece) < std::tie(b.row, a.column, b.piece);
  });

  const auto line = [](const std::vector<double>& lines, int k, double first, double last) {
    return k < 0 ? first : k < static_cast<int>(lines.size()) ? lines[k] : last;
  };
  const auto border = [&](int column) { return line(cells.u, column - 1, reached.lower.x, reached.upper.x); };
  const auto floor = [&](int row) { return line(cells.v, row - 1, reached.lower.y, reached.upper.y); };
  const auto add = [&](int row, int column, const LoopPiece& p, double weight) {
    const dvec2 inside(0.5 * (border(column) + border(column + 1)), 0.5 * (floor(row) + floor(row + 1)));
    out.strips.push_back({inside, border(column), p.from, p.to, p.ctrl, p.degree, weight});
  };
  // Strips over the whole width of a cell, where the loops further right leave something.
  const auto whole = [&](int row, int column, const std::vector<Event>& events) {
    const double right = border(column + 1);
    double weight = 0.0;
    for (std::size_t i = 0; i + 1 < events.size(); ++i) {
      weight += events[i].weight;
      if (weight != 0.0) add(row, column, {{right, events[i].v}, {right, events[i + 1].v}}, weight);
    }
  };
  std::vector<Event> events;
  for (std::size_t i = 0; i < placed.size();) {
    const int row = placed[i].row;
    events.clear();
    int column = placed[i].column;
    while (i < placed.size() && placed[i].row == row) {
      for (; column > placed[i].column; --column) whole(row, column - 1, events);
      // All pieces of this cell, then the cells to the left know them.
      for (; i < placed.size() && placed[i].row == row && placed[i].column == column; ++i) {
        const LoopPiece& p = loops.pieces[placed[i].piece];
        const double weight = signs[p.loop];
        add(row, column, p, weight);
        events.push_back({p.from.y, weight}), events.push_back({p.to.y, -weight});
      }
      merge(events);
    }
    for (; column > 0; --column) whole(row, column - 1, events);
  }
  out.ctrl_h = std::move(loops.ctrl_h);
  return out;
}

}  // namespace trimray::mass
