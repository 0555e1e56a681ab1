#include "core/nurbs/face_loops.h"

#include <cmath>

namespace trimray::nurbs {
namespace {

Pieces2 line(dvec2 from, dvec2 to) {
  Pieces2 p;
  p.ctrl = {dvec3(from, 1.0), dvec3(to, 1.0)};
  p.list = {{{0, 2}, 0.0, 1.0}};
  return p;
}

class LoopCloser {
 public:
  LoopCloser(const SurfaceAt& surface, const Box2& natural, dvec2 periods)
      : surface_(surface), natural_(natural), periods_(periods) {}

  FaceLoops run(std::vector<std::vector<WireUse>> wires) {
    scale_ = dvec2(0.0);
    Box2 all;
    for (const auto& wire : wires)
      for (const WireUse& use : wire) all.add(pieces_box(use.coedge.pieces));
    if (!all.empty()) scale_ = glm::max(all.extent(), dvec2(1e-300));
    for (auto& wire : wires) {
      while (!wire.empty()) {
        std::vector<WireUse> chain = take_chain(wire);
        unroll(std::move(chain));
      }
    }
    close_winding(0);
    close_winding(1);
    if (result_.status != FaceStatus::kOk) return std::move(result_);
    gather_holes();
    bound();
    return std::move(result_);
  }

 private:
  struct Wound {  // a loop that does not return to its start
    LoopWork loop;
    int turns[2] = {0, 0};
  };

  dvec2 unwrapped(dvec2 gap) const {
    for (int d = 0; d < 2; ++d)
      if (periods_[d] > 0.0) gap[d] -= periods_[d] * std::round(gap[d] / periods_[d]);
    return gap;
  }

  double distance(dvec2 gap) const { return glm::length(gap / scale_); }

  // The next loop of a wire, each use beginning at the vertex where the one before ended. Wires are mostly
  // stored in order; where they are not, vertices decide, and the nearer p-curve between uses of one vertex.
  std::vector<WireUse> take_chain(std::vector<WireUse>& wire) const {
    std::vector<WireUse> chain;
    chain.push_back(std::move(wire.front()));
    wire.erase(wire.begin());
    while (!wire.empty()) {
      const WireUse& last = chain.back();
      const dvec2 at = end_uv(last.coedge);
      std::size_t best = wire.size();
      double best_cost = kInf;
      for (std::size_t i = 0; i < wire.size(); ++i) {
        if (last.end_vertex >= 0 && wire[i].start_vertex >= 0 && wire[i].start_vertex != last.end_vertex)
          continue;
        const dvec2 gap = start_uv(wire[i].coedge) - at;
        double cost = std::min(distance(gap), 1e-3 + distance(unwrapped(gap)));
        // Straight back along a seam only when nothing else begins here: the rim comes between its two uses.
        if (wire[i].coedge.edge == last.coedge.edge) cost += 1.0;
        if (cost < best_cost) best = i, best_cost = cost;
        if (i == 0 && cost < 1e-6) break;
      }
      // A wire with a missing edge: the nearest start will do, if the chain does not close better itself.
      if (best == wire.size()) {
        if (last.end_vertex == chain.front().start_vertex) break;
        for (std::size_t i = 0; i < wire.size(); ++i) {
          const double cost = distance(unwrapped(start_uv(wire[i].coedge) - at));
          if (cost < best_cost) best = i, best_cost = cost;
        }
        if (distance(unwrapped(start_uv(chain.front().coedge) - at)) <= best_cost) break;
      }
      chain.push_back(std::move(wire[best]));
      wire.erase(wire.begin() + static_cast<std::ptrdiff_t>(best));
    }
    return chain;
  }

  // Is the line of constant value in the direction other than `around` one point of the surface?
  bool collapsed(int around, double value, double tolerance) const {
    const double width =
        periods_[around] > 0.0 ? periods_[around] : natural_.upper[around] - natural_.lower[around];
    if (!std::isfinite(width)) return false;
    dvec3 first(0.0);
    for (int i = 0; i < 5; ++i) {
      dvec2 uv;
      uv[around] = (std::isfinite(natural_.lower[around]) ? natural_.lower[around] : 0.0) + width * i / 5.0;
      uv[1 - around] = value;
      const dvec3 p = surface_(uv);
      if (i == 0) first = p;
      if (!(glm::distance(first, p) <= tolerance)) return false;
    }
    return true;
  }

  // The direction along which a gap runs over a pole, -1 when it does not.
  int pole_direction(dvec2 from, dvec2 to, double tolerance) const {
    for (int d = 0; d < 2; ++d) {
      const double along = std::abs(to[d] - from[d]), across = std::abs(to[1 - d] - from[1 - d]);
      const double least = 1e-6 * (periods_[d] > 0.0 ? periods_[d] : scale_[d]);
      if (along > least && across <= 1e-3 * scale_[1 - d] &&
          collapsed(d, from[1 - d], std::max(1e-6, tolerance)))
        return d;
    }
    return -1;
  }

  CoEdgeWork pole(dvec2 from, dvec2 to) {
    SyntheticEdge e;
    e.end[0] = e.end[1] = surface_(from);
    result_.synthetic.push_back(e);
    CoEdgeWork c;
    c.edge = -static_cast<std::int32_t>(result_.synthetic.size());
    c.pieces = line(from, to);
    return c;
  }

  // Rounded; damaged p-curves may be any number of turns away.
  static int whole_turns(double turns) {
    constexpr double kMany = 1e6;
    return std::abs(turns) < kMany ? static_cast<int>(std::round(turns)) : static_cast<int>(kMany);
  }

  // Shifts the uses of a chain by periods so that each begins where the one before ends, and bridges poles.
  void unroll(std::vector<WireUse> chain) {
    LoopWork loop;
    std::ptrdiff_t bridge = -1;  // the last synthetic pole
    const auto join = [&](dvec2 from, dvec2 to, double tolerance) {
      const dvec2 gap = to - from;
      if (distance(gap) <= 1e-9) return false;
      if (pole_direction(from, to, tolerance) < 0) return false;
      loop.coedges.push_back(pole(from, to));
      bridge = static_cast<std::ptrdiff_t>(loop.coedges.size()) - 1;
      return true;
    };
    for (WireUse& use : chain) {
      if (!loop.coedges.empty()) {
        const dvec2 from = end_uv(loop.coedges.back()), to = start_uv(use.coedge);
        if (!join(from, to, use.tolerance)) shift(use.coedge, unwrapped(to - from) - (to - from));
      }
      loop.coedges.push_back(std::move(use.coedge));
    }
    const dvec2 from = end_uv(loop.coedges.back()), to = start_uv(loop.coedges.front());
    int turns[2] = {0, 0};
    if (!join(from, to, chain.front().tolerance))
      for (int d = 0; d < 2; ++d)
        if (periods_[d] > 0.0) turns[d] = whole_turns((from[d] - to[d]) / periods_[d]);
    // A pole was bridged the wrong way round: the whole turn belongs there.
    for (int d = 0; d < 2; ++d) {
      if (turns[d] == 0 || bridge < 0) continue;
      dvec2 by(0.0);
      by[d] = -turns[d] * periods_[d];
      for (std::size_t i = static_cast<std::size_t>(bridge) + 1; i < loop.coedges.size(); ++i)
        shift(loop.coedges[i], by);
      CoEdgeWork& b = loop.coedges[static_cast<std::size_t>(bridge)];
      b.pieces = line(start_uv(b), end_uv(b) + by);
      turns[d] = 0;
    }
    if (turns[0] == 0 && turns[1] == 0)
      result_.loops.push_back(std::move(loop));
    else
      wound_.push_back({std::move(loop), {turns[0], turns[1]}});
  }

  // Two co-edges on a new seam: up along the way, and back one period further.
  void add_seam(LoopWork& loop, std::size_t after, dvec2 from, dvec2 to, dvec2 period) {
    SyntheticEdge e;
    e.degenerate = false;
    const auto path = [&](double t) { return surface_(from + t * (to - from)); };
    const double size = glm::distance(path(0.0), path(0.5)) + glm::distance(path(0.5), path(1.0));
    e.path = fit_cubics<3>(path, 0.0, 1.0, 1e-10 * size);
    e.end[0] = path(0.0), e.end[1] = path(1.0);
    result_.synthetic.push_back(std::move(e));
    CoEdgeWork there, back;
    there.edge = back.edge = -static_cast<std::int32_t>(result_.synthetic.size());
    there.seam = back.seam = back.reversed = true;
    there.pieces = line(from, to), back.pieces = line(to - period, from - period);
    std::swap(back.pieces.list[0].t0, back.pieces.list[0].t1);
    loop.coedges.insert(loop.coedges.begin() + static_cast<std::ptrdiff_t>(after), std::move(there));
    loop.coedges.push_back(std::move(back));
  }

  // Joins loops that wind once around direction d: a rim with material above it to the rim that bounds it
  // from above, or to the pole or domain border when there is none.
  void close_winding(int d) {
    std::vector<Wound> mine;
    for (Wound& w : wound_)
      if (w.turns[d] != 0 && w.turns[1 - d] == 0 && std::abs(w.turns[d]) == 1)
        mine.push_back(std::move(w));
      else if (d == 1 && (w.turns[0] == 0 || w.turns[1] != 0))
        result_.status = FaceStatus::kBadTrim;
    if (d == 0) std::erase_if(wound_, [](const Wound& w) { return w.loop.coedges.empty(); });
    if (mine.empty()) return;
    const int other = 1 - d;
    // Along +u material lies at greater v, along +v at smaller u.
    const auto upward = [&](const Wound& w) { return (w.turns[d] > 0) == (d == 0); };
    const auto level = [&](const Wound& w) { return loop_box(w.loop).center()[other]; };
    std::sort(mine.begin(), mine.end(), [&](const Wound& a, const Wound& b) { return level(a) < level(b); });
    std::vector<bool> done(mine.size(), false);
    for (std::size_t i = 0; i < mine.size(); ++i) {
      if (done[i] || !upward(mine[i])) continue;
      std::size_t partner = mine.size();
      for (std::size_t k = 1; k < mine.size() && partner == mine.size(); ++k) {
        const std::size_t j = (i + k) % mine.size();
        if (!done[j] && !upward(mine[j]) && (j > i || periods_[other] > 0.0)) partner = j;
      }
      if (partner == mine.size()) continue;
      dvec2 lift(0.0);
      if (partner < i) lift[other] = periods_[other];
      shift(mine[partner].loop, lift);
      join_rims(mine[i], mine[partner], d);
      done[i] = done[partner] = true;
    }
    // Wires turned the wrong way, or rims bounded by nothing but the surface's end.
    std::vector<std::size_t> rest;
    for (std::size_t i = 0; i < mine.size(); ++i)
      if (!done[i]) rest.push_back(i);
    for (const std::size_t i : rest) close_to_border(mine[i], d, upward(mine[i]));
  }

  void join_rims(Wound& a, Wound& b, int d) {
    LoopWork loop = std::move(a.loop);
    const std::size_t count = loop.coedges.size();
    dvec2 period(0.0);
    period[d] = a.turns[d] * periods_[d];
    const dvec2 from = end_uv(loop.coedges.back());
    dvec2 by(0.0);
    by[d] = wrap_near(start_uv(b.loop.coedges.front())[d], from[d], periods_[d]) -
            start_uv(b.loop.coedges.front())[d];
    shift(b.loop, by);
    const dvec2 to = start_uv(b.loop.coedges.front());
    for (CoEdgeWork& c : b.loop.coedges) loop.coedges.push_back(std::move(c));
    add_seam(loop, count, from, to, period);
    result_.loops.push_back(std::move(loop));
  }

  void close_to_border(Wound& w, int d, bool up) {
    const int other = 1 - d;
    double border = up ? natural_.upper[other] : natural_.lower[other];
    // A cone's only end is its apex, wherever the material is said to be.
    if (!std::isfinite(border)) border = up ? natural_.lower[other] : natural_.upper[other];
    if (!std::isfinite(border)) {
      result_.status = FaceStatus::kBadTrim;
      return;
    }
    LoopWork loop = std::move(w.loop);
    const std::size_t count = loop.coedges.size();
    dvec2 period(0.0);
    period[d] = w.turns[d] * periods_[d];
    const dvec2 from = end_uv(loop.coedges.back());
    dvec2 corner = from;
    corner[other] = border;
    loop.coedges.push_back(pole(corner, corner - period));
    if (!collapsed(d, border, 1e-6)) {
      // An open border: its own edge, used once.
      SyntheticEdge& e = result_.synthetic.back();
      const auto path = [&](double t) { return surface_(corner - t * period); };
      e.degenerate = false;
      e.path = fit_cubics<3>(path, 0.0, 1.0, 1e-9 * glm::distance(path(0.0), path(0.37)));
      e.end[0] = path(0.0), e.end[1] = path(1.0);
    }
    add_seam(loop, count, from, corner, period);
    result_.loops.push_back(std::move(loop));
  }

  // Other loops may be drawn in another period than the largest one.
  void gather_holes() {
    if (periods_ == dvec2(0.0) || result_.loops.size() < 2) return;
    std::vector<Box2> boxes;
    for (const LoopWork& l : result_.loops) boxes.push_back(loop_box(l));
    std::size_t largest = 0;
    const auto size = [&](const Box2& b) { return b.extent().x / scale_.x + b.extent().y / scale_.y; };
    for (std::size_t i = 1; i < boxes.size(); ++i)
      if (size(boxes[i]) > size(boxes[largest])) largest = i;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      dvec2 by(0.0);
      for (int d = 0; d < 2; ++d)
        by[d] =
            wrap_near(boxes[i].center()[d], boxes[largest].center()[d], periods_[d]) - boxes[i].center()[d];
      shift(result_.loops[i], by);
    }
  }

  // uv_box; where the loops reach beyond one period, copies of them one period on make the strip of one
  // period right, which is all that is ever asked.
  void bound() {
    Box2 box;
    for (const LoopWork& l : result_.loops) box.add(loop_box(l));
    for (int d = 0; d < 2; ++d) {
      if (!(periods_[d] > 0.0) || !(box.upper[d] - box.lower[d] > periods_[d] * (1.0 + 1e-9))) continue;
      const double middle = strip_middle(d, box);
      const double lo = middle - 0.5 * periods_[d], hi = middle + 0.5 * periods_[d];
      LoopWork copies;
      const std::size_t count = result_.loops.size();
      for (std::size_t i = 0; i < count; ++i) {
        const Box2 b = loop_box(result_.loops[i]);
        const double eps = 1e-9 * periods_[d];
        if (b.upper[d] > hi + eps) add_copy(i, d, -periods_[d]);
        if (b.lower[d] < lo - eps) add_copy(i, d, periods_[d]);
      }
      box.lower[d] = lo, box.upper[d] = hi;
    }
    result_.uv_box = box;
    result_.iso_rectangle = is_rectangle();
  }

  // The strip of a loop that is itself one period wide, else the middle of all.
  double strip_middle(int d, const Box2& box) const {
    for (const LoopWork& l : result_.loops) {
      const Box2 b = loop_box(l);
      if (std::abs(b.upper[d] - b.lower[d] - periods_[d]) < 1e-6 * periods_[d]) return b.center()[d];
    }
    return box.center()[d];
  }

  void add_copy(std::size_t loop, int d, double by) {
    dvec2 move(0.0);
    move[d] = by;
    SyntheticEdge e;
    e.end[0] = e.end[1] = surface_(start_uv(result_.loops[loop].coedges.front()));
    result_.synthetic.push_back(e);
    CoEdgeWork copy;
    copy.edge = -static_cast<std::int32_t>(result_.synthetic.size());
    for (const CoEdgeWork& c : result_.loops[loop].coedges) {
      const std::int32_t offset = static_cast<std::int32_t>(copy.pieces.ctrl.size());
      copy.pieces.ctrl.insert(copy.pieces.ctrl.end(), c.pieces.ctrl.begin(), c.pieces.ctrl.end());
      for (CurvePiece p : c.pieces.list) {
        p.ctrl.begin += offset, p.ctrl.end += offset;
        copy.pieces.list.push_back(p);
      }
    }
    shift(copy, move);
    LoopWork l;
    l.coedges.push_back(std::move(copy));
    result_.loops.push_back(std::move(l));
  }

  bool is_rectangle() const {
    if (result_.loops.size() != 1) return false;
    const Box2& box = result_.uv_box;
    const dvec2 eps = 1e-12 * glm::max(box.extent(), 1e-3 * glm::abs(box.lower));
    for (const CoEdgeWork& c : result_.loops[0].coedges)
      for (const CurvePiece& p : c.pieces.list) {
        bool side[4] = {true, true, true, true};
        for (std::int32_t i = p.ctrl.begin; i < p.ctrl.end; ++i) {
          const dvec2 uv = project(c.pieces.ctrl[i]);
          side[0] = side[0] && std::abs(uv.x - box.lower.x) <= eps.x;
          side[1] = side[1] && std::abs(uv.x - box.upper.x) <= eps.x;
          side[2] = side[2] && std::abs(uv.y - box.lower.y) <= eps.y;
          side[3] = side[3] && std::abs(uv.y - box.upper.y) <= eps.y;
        }
        if (!side[0] && !side[1] && !side[2] && !side[3]) return false;
      }
    const double area = box.extent().x * box.extent().y;
    return std::abs(std::abs(signed_area(result_.loops[0])) - area) <= 1e-9 * area;
  }

  const SurfaceAt& surface_;
  Box2 natural_;
  dvec2 periods_, scale_{1.0};
  std::vector<Wound> wound_;
  FaceLoops result_;
};

}  // namespace

FaceLoops close_loops(std::vector<std::vector<WireUse>> wires, const SurfaceAt& surface, const Box2& natural,
                      dvec2 periods) {
  return LoopCloser(surface, natural, periods).run(std::move(wires));
}

}  // namespace trimray::nurbs
