#include "core/nurbs/trim_segment.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/nurbs/trim_bezier.h"
#include "core/nurbs/trim_roots.h"

namespace trimray::nurbs {
namespace {

// A segment is halved while its chord leaves more than this part of its own box undecided ...
constexpr double kUndecidedOfBox = 0.02;
// ... and more than this part of the face's box ...
constexpr double kUndecidedOfFace = 1e-5;
// ... at most this often.
constexpr int kMaxHalvings = 6;

dvec2 project(dvec3 p) { return {p.x / p.z, p.y / p.z}; }

class Cutter {
 public:
  explicit Cutter(TrimSegments& out, double face_area) : out_(out), face_area_(face_area) {}

  // A loop's next point in a straight line; nothing where it is the same to the bit.
  void line(dvec2 from, dvec2 to) {
    out_.box.add(from), out_.box.add(to);
    TrimSegment s;
    s.lo = from, s.hi = to;
    if (s.lo.y > s.hi.y) std::swap(s.lo, s.hi);
    if (s.lo.y < s.hi.y) out_.segments.push_back(s);
  }

  void piece(std::span<const dvec3> ctrl_h) {
    std::vector<double> cuts;
    append_extrema(ctrl_h, 0, cuts);
    append_extrema(ctrl_h, 1, cuts);
    std::sort(cuts.begin(), cuts.end());
    std::vector<dvec3> rest(ctrl_h.begin(), ctrl_h.end()), left(rest.size()), right(rest.size());
    dvec2 from = project(rest.front());
    double start = 0.0;
    for (double cut : cuts) {
      const double t = (cut - start) / (1.0 - start);
      if (!(t > 1e-15 && t < 1.0 - 1e-15)) continue;
      split_bezier<dvec3>(rest, t, left.data(), right.data());
      const dvec2 to = project(left.back());
      monotone(left, from, to, 0);
      rest = right, from = to, start = cut;
    }
    monotone(rest, from, project(rest.back()), 0);
  }

 private:
  void monotone(const std::vector<dvec3>& ctrl_h, dvec2 from, dvec2 to, int halvings) {
    out_.box.add(from), out_.box.add(to);
    if (from.y == to.y) return;
    const dvec2 d = to - from;
    double low = 0.0, high = 0.0, size = 0.0;
    for (const dvec3& c : ctrl_h) {
      const dvec2 p = project(c);
      const double cross = d.x * (p.y - from.y) - d.y * (p.x - from.x);
      low = std::min(low, cross), high = std::max(high, cross);
      size = std::max(size, std::abs(d.x * p.y) + std::abs(d.y * p.x));
    }
    const double undecided = high - low;
    if (halvings < kMaxHalvings && undecided > kUndecidedOfBox * std::abs(d.x * d.y) &&
        undecided > kUndecidedOfFace * face_area_) {
      std::vector<dvec3> left(ctrl_h.size()), right(ctrl_h.size());
      split_bezier<dvec3>(ctrl_h, 0.5, left.data(), right.data());
      const dvec2 middle = project(left.back());
      monotone(left, from, middle, halvings + 1);
      monotone(right, middle, to, halvings + 1);
      return;
    }
    push(ctrl_h, from, to, low, high, 1e-15 * static_cast<double>(ctrl_h.size()) * size);
  }

  void push(const std::vector<dvec3>& ctrl_h, dvec2 from, dvec2 to, double low, double high,
            double rounding) {
    TrimSegment s;
    s.lo = from, s.hi = to;
    s.degree = static_cast<std::int32_t>(ctrl_h.size()) - 1;
    s.ctrl = static_cast<std::uint32_t>(out_.ctrl_h.size());
    s.cross_min = low - rounding, s.cross_max = high + rounding;
    if (from.y < to.y) {
      out_.ctrl_h.insert(out_.ctrl_h.end(), ctrl_h.begin(), ctrl_h.end());
    } else {
      // cross(-d, p - to) = -cross(d, p - from): turning the chord round turns the sign.
      std::swap(s.lo, s.hi);
      s.cross_min = -high - rounding, s.cross_max = -low + rounding;
      out_.ctrl_h.insert(out_.ctrl_h.end(), ctrl_h.rbegin(), ctrl_h.rend());
    }
    out_.segments.push_back(s);
  }

  TrimSegments& out_;
  double face_area_;
};

std::span<const dvec3> controls(const NurbsStore& store, std::int32_t piece) {
  const Range r = store.trim_pieces[piece].ctrl;
  return {store.trim_ctrl_h.data() + r.begin, static_cast<std::size_t>(r.size())};
}

double control_box_area(const NurbsStore& store, const Face& face) {
  Box2 box;
  for (std::int32_t l = face.loops.begin; l < face.loops.end; ++l)
    for (std::int32_t c = store.loops[l].coedges.begin; c < store.loops[l].coedges.end; ++c)
      for (std::int32_t p = store.coedges[c].pieces.begin; p < store.coedges[c].pieces.end; ++p)
        for (const dvec3& point : controls(store, p)) box.add(project(point));
  return box.empty() ? 0.0 : box.extent().x * box.extent().y;
}

}  // namespace

TrimSegments cut_trim_loops(const NurbsStore& store, std::int32_t face_index) {
  TrimSegments out;
  const Face& face = store.faces[face_index];
  Cutter cutter(out, control_box_area(store, face));
  for (std::int32_t l = face.loops.begin; l < face.loops.end; ++l) {
    bool begun = false;
    dvec2 first{0.0}, last{0.0};
    for (std::int32_t c = store.loops[l].coedges.begin; c < store.loops[l].coedges.end; ++c) {
      for (std::int32_t p = store.coedges[c].pieces.begin; p < store.coedges[c].pieces.end; ++p) {
        const std::span<const dvec3> ctrl_h = controls(store, p);
        if (ctrl_h.size() < 2) continue;
        if (ctrl_h.size() > kMaxPieceDegree + 1)
          throw ArgumentError("face " + std::to_string(face_index) + ": trim curve of degree " +
                              std::to_string(ctrl_h.size() - 1));
        const dvec2 start = project(ctrl_h.front()), end = project(ctrl_h.back());
        if (!begun)
          first = start, begun = true;
        else if (last != start)
          cutter.line(last, start);
        if (ctrl_h.size() == 2)
          cutter.line(start, end);
        else
          cutter.piece(ctrl_h);
        last = end;
      }
    }
    if (begun && last != first) cutter.line(last, first);
  }
  return out;
}

bool curve_is_right(const TrimSegment& segment, const dvec3* ctrl_h, dvec2 uv) {
  // Multiplied by the weight (> 0), the difference to uv is a polynomial; only its signs matter.
  double x[kMaxPieceDegree + 1], y[kMaxPieceDegree + 1];
  const int n = segment.degree;
  for (int i = 0; i <= n; ++i) {
    const dvec3& c = ctrl_h[segment.ctrl + i];
    x[i] = c.x - uv.x * c.z, y[i] = c.y - uv.y * c.z;
  }
  constexpr int kMaxBisections = 64;
  for (int step = 0; step < kMaxBisections; ++step) {
    if (x[0] > 0.0 && x[n] > 0.0) return true;
    if (x[0] <= 0.0 && x[n] <= 0.0) return false;
    double left_x[kMaxPieceDegree + 1], left_y[kMaxPieceDegree + 1];
    for (int level = 0; level < n; ++level) {
      left_x[level] = x[0], left_y[level] = y[0];
      for (int i = 0; i < n - level; ++i) {
        x[i] = 0.5 * (x[i] + x[i + 1]);
        y[i] = 0.5 * (y[i] + y[i + 1]);
      }
    }
    // x, y now hold the upper half; the crossing is in the lower one when the middle is above v.
    if (y[0] > 0.0) {
      left_x[n] = x[0], left_y[n] = y[0];
      for (int i = 0; i <= n; ++i) x[i] = left_x[i], y[i] = left_y[i];
    }
  }
  return x[0] + x[n] > 0.0;
}

}  // namespace trimray::nurbs
