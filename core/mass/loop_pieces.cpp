#include "core/mass/loop_pieces.h"

#include <algorithm>
#include <cmath>

#include "core/mass/gauss.h"
#include "core/nurbs/trim_bezier.h"
#include "core/nurbs/trim_roots.h"

namespace trimray::mass {
namespace {

using nurbs::NurbsStore;

// Of a loop, when it is asked where it lies.
constexpr std::size_t kVoters = 9;

std::span<const dvec3> controls(const NurbsStore& store, std::int32_t piece) {
  const nurbs::Range r = store.trim_pieces[piece].ctrl;
  return {store.trim_ctrl_h.data() + r.begin, static_cast<std::size_t>(r.size())};
}

// Calls curve(control points) for every piece of a loop, in order.
template <typename Curve>
void for_each_piece(const NurbsStore& store, std::int32_t loop, const Curve& curve) {
  const nurbs::Range coedges = store.loops[loop].coedges;
  for (std::int32_t c = coedges.begin; c < coedges.end; ++c)
    for (std::int32_t p = store.coedges[c].pieces.begin; p < store.coedges[c].pieces.end; ++p)
      curve(controls(store, p));
}

// A loop that crosses the seam of a periodic surface has copies one period away, for those who look into the
// uv box alone. They run along no edge, and are no part of the region.
bool is_copy(const NurbsStore& store, std::int32_t loop) {
  const nurbs::Range coedges = store.loops[loop].coedges;
  for (std::int32_t c = coedges.begin; c < coedges.end; ++c)
    if (!store.edges[store.coedges[c].edge].degenerate) return false;
  return true;
}

double coordinate(std::span<const dvec3> ctrl_h, double t, int axis) {
  const dvec3 h = nurbs::evaluate_bezier(ctrl_h, t);
  return h[axis] / h.z;
}

class Cutter {
 public:
  Cutter(const SmoothCells& cells, LoopPieces& out) : cells_(cells), out_(out) {}

  void begin_loop() { begun_ = false; }
  void end_loop() {
    if (begun_ && last_ != first_) line(first_);
    ++out_.loops;
  }
  void curve(std::span<const dvec3> ctrl_h) {
    const dvec2 start = nurbs::project(ctrl_h.front()), end = nurbs::project(ctrl_h.back());
    if (!begun_)
      first_ = last_ = start, begun_ = true;
    else if (last_ != start)
      line(start);
    if (ctrl_h.size() == 2)
      line(end);
    else
      bend(ctrl_h, end);
  }

 private:
  struct Cut {
    double t;
    int axis;  // on whose line it lies, -1: on none
    double at;
  };

  // Straight on to `end`, with a stop at every line of the cells.
  void line(dvec2 end) {
    cuts_.clear();
    const dvec2 from = last_;
    for (int axis = 0; axis < 2; ++axis) {
      const double a = from[axis], b = end[axis];
      for_each_line(axis, a, b, [&](double at) { cuts_.push_back({(at - a) / (b - a), axis, at}); });
    }
    sort_cuts();
    for (const Cut& cut : cuts_) push_line(stop(from + cut.t * (end - from), cut));
    push_line(end);
  }

  void bend(std::span<const dvec3> ctrl_h, dvec2 end) {
    extrema_.clear();
    for (int axis = 0; axis < 2; ++axis) nurbs::append_extrema(ctrl_h, axis, extrema_);
    std::sort(extrema_.begin(), extrema_.end());
    extrema_.push_back(1.0);
    cuts_.clear();
    double begin = 0.0;
    for (const double t : extrema_) {
      if (t < 1.0) cuts_.push_back({t, -1, 0.0});
      for (int axis = 0; axis < 2; ++axis)
        for_each_line(axis, coordinate(ctrl_h, begin, axis), coordinate(ctrl_h, t, axis), [&](double at) {
          cuts_.push_back({crossing(ctrl_h, begin, t, axis, at), axis, at});
        });
      begin = t;
    }
    sort_cuts();
    rest_.assign(ctrl_h.begin(), ctrl_h.end());
    left_.resize(rest_.size()), right_.resize(rest_.size());
    double start = 0.0;
    for (const Cut& cut : cuts_) {
      const double t = (cut.t - start) / (1.0 - start);
      if (!(t > 1e-15 && t < 1.0 - 1e-15)) continue;
      nurbs::split_bezier<dvec3>(rest_, t, left_.data(), right_.data());
      push_bend(left_, stop(nurbs::project(left_.back()), cut));
      std::swap(rest_, right_);
      start = cut.t;
    }
    push_bend(rest_, end);
  }

  // Calls with every line of the cells strictly between a and b.
  template <typename Each>
  void for_each_line(int axis, double a, double b, const Each& each) const {
    const std::vector<double>& lines = axis == 0 ? cells_.u : cells_.v;
    const double low = std::min(a, b), high = std::max(a, b);
    for (auto l = std::upper_bound(lines.begin(), lines.end(), low); l != lines.end() && *l < high; ++l)
      each(*l);
  }

  // Where the coordinate, monotone in [a, b], passes `at`: bisection.
  static double crossing(std::span<const dvec3> ctrl_h, double a, double b, int axis, double at) {
    const bool rising = coordinate(ctrl_h, a, axis) < at;
    for (int step = 0; step < 60; ++step) {
      const double m = 0.5 * (a + b);
      if ((coordinate(ctrl_h, m, axis) < at) == rising)
        a = m;
      else
        b = m;
    }
    return 0.5 * (a + b);
  }

  void sort_cuts() {
    std::sort(cuts_.begin(), cuts_.end(), [](const Cut& a, const Cut& b) { return a.t < b.t; });
  }
  static dvec2 stop(dvec2 at, const Cut& cut) {
    if (cut.axis >= 0) at[cut.axis] = cut.at;
    return at;
  }

  void push_line(dvec2 to) {
    if (last_.y != to.y) out_.pieces.push_back({last_, to, 0, 1, out_.loops});
    last_ = to;
  }
  void push_bend(const std::vector<dvec3>& ctrl_h, dvec2 to) {
    if (last_.y != to.y) {
      const auto at = static_cast<std::int32_t>(out_.ctrl_h.size());
      out_.ctrl_h.insert(out_.ctrl_h.end(), ctrl_h.begin(), ctrl_h.end());
      out_.pieces.push_back({last_, to, at, static_cast<std::int32_t>(ctrl_h.size()) - 1, out_.loops});
    }
    last_ = to;
  }

  const SmoothCells& cells_;
  LoopPieces& out_;
  bool begun_ = false;
  dvec2 first_{0.0}, last_{0.0};
  std::vector<Cut> cuts_;
  std::vector<double> extrema_;
  std::vector<dvec3> rest_, left_, right_;
};

std::span<const dvec3> controls(const LoopPieces& loops, const LoopPiece& piece) {
  return {&loops.ctrl_h[piece.ctrl], static_cast<std::size_t>(piece.degree) + 1};
}

// The integral of u dv.
double area_beside(const LoopPieces& loops, const LoopPiece& p) {
  if (p.degree == 1) return 0.5 * (p.from.x + p.to.x) * (p.to.y - p.from.y);
  const std::span<const dvec3> ctrl_h = controls(loops, p);
  constexpr int kSteps = 16;
  double area = 0.0;
  dvec2 last = p.from;
  for (int i = 1; i <= kSteps; ++i) {
    const dvec2 next = i < kSteps ? nurbs::project(nurbs::evaluate_bezier(ctrl_h, i / double(kSteps))) : p.to;
    area += 0.5 * (last.x + next.x) * (next.y - last.y);
    last = next;
  }
  return area;
}

// Does the horizontal way from q to the right pass the piece?
bool is_passed(const LoopPieces& loops, const LoopPiece& p, dvec2 q) {
  if ((p.from.y <= q.y) == (p.to.y <= q.y)) return false;
  if (p.degree == 1) return p.from.x + (p.to.x - p.from.x) * (q.y - p.from.y) / (p.to.y - p.from.y) > q.x;
  const std::span<const dvec3> ctrl_h = controls(loops, p);
  const bool rising = p.from.y < p.to.y;
  double a = 0.0, b = 1.0;
  for (int step = 0; step < 60; ++step) {
    const double m = 0.5 * (a + b);
    ((coordinate(ctrl_h, m, 1) < q.y) == rising ? a : b) = m;
  }
  return coordinate(ctrl_h, a, 0) > q.x;
}

}  // namespace

Box2 loops_box(const NurbsStore& store, const nurbs::Face& face) {
  Box2 box;
  for (std::int32_t l = face.loops.begin; l < face.loops.end; ++l) {
    if (is_copy(store, l)) continue;
    for_each_piece(store, l, [&](std::span<const dvec3> ctrl_h) {
      for (const dvec3& h : ctrl_h) box.add(nurbs::project(h));
    });
  }
  return box.empty() ? face.uv_box : box;
}

LoopPieces cut_loops(const NurbsStore& store, const nurbs::Face& face, const SmoothCells& cells,
                     dvec2 origin) {
  LoopPieces out;
  Cutter cutter(cells, out);
  std::vector<dvec3> moved;
  for (std::int32_t l = face.loops.begin; l < face.loops.end; ++l) {
    if (is_copy(store, l)) continue;
    cutter.begin_loop();
    for_each_piece(store, l, [&](std::span<const dvec3> ctrl_h) {
      if (ctrl_h.size() < 2) return;
      moved.clear();
      for (const dvec3& h : ctrl_h) moved.emplace_back(dvec2(h) - h.z * origin, h.z);
      cutter.curve(moved);
    });
    cutter.end_loop();
  }
  if (out.loops > 0) return out;
  const dvec2 low = face.uv_box.lower - origin, high = face.uv_box.upper - origin;
  const dvec3 corner[] = {{low, 1.0}, {high.x, low.y, 1.0}, {high, 1.0}, {low.x, high.y, 1.0}, {low, 1.0}};
  for (int i = 0; i < 4; ++i) cutter.curve(std::span(corner + i, 2));
  cutter.end_loop();
  return out;
}

std::vector<double> loop_signs(const LoopPieces& loops) {
  std::vector<double> area(loops.loops, 0.0), sign(loops.loops, 1.0);
  // From a point near the loop, lest far loops lose their sign.
  std::vector<std::vector<const LoopPiece*>> own(loops.loops);
  for (const LoopPiece& p : loops.pieces) {
    own[p.loop].push_back(&p);
    area[p.loop] += area_beside(loops, p) - own[p.loop].front()->from.x * (p.to.y - p.from.y);
  }
  // The usual case: all others run against the largest one, as holes do.
  int outer = 0, against = 0;
  for (int l = 1; l < loops.loops; ++l)
    if (std::abs(area[l]) > std::abs(area[outer])) outer = l;
  for (const double a : area) against += (a < 0.0) != (area[outer] < 0.0);
  if (against == loops.loops - 1) {
    if (loops.loops > 0 && area[outer] < 0.0) std::fill(sign.begin(), sign.end(), -1.0);
    return sign;
  }
  for (int l = 0; l < loops.loops; ++l) {
    // Loops may touch, so that one point says little: many have a vote.
    int votes = 0;
    const std::size_t step = std::max<std::size_t>(1, own[l].size() / kVoters);
    for (std::size_t k = 0; k < own[l].size(); k += step) {
      const LoopPiece& voter = *own[l][k];
      const dvec2 q = voter.degree == 1 ? 0.5 * (voter.from + voter.to)
                                        : nurbs::project(nurbs::evaluate_bezier(controls(loops, voter), 0.5));
      bool within = false;
      for (const LoopPiece& p : loops.pieces)
        if (p.loop != l) within ^= is_passed(loops, p, q);
      votes += within ? 1 : -1;
    }
    sign[l] = (area[l] < 0.0) == (votes > 0) ? 1.0 : -1.0;
  }
  return sign;
}

}  // namespace trimray::mass
