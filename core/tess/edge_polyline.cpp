#include "core/tess/edge_polyline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/nurbs/spline.h"

namespace trimray::tess {

using nurbs::CoEdge;
using nurbs::CurvePiece;
using nurbs::Edge;
using nurbs::NurbsStore;

namespace {

// Room that the limits leave for what the faces' own bounds add.
constexpr double kShare = 0.9;
// What a side may take of the tolerance in a face whose triangles have bounds of their own, which are wider
// than it.
constexpr double kSideShare = 0.75;
constexpr double kWidestTurn = std::numbers::pi / 2;

int piece_count(const Edge& edge) { return edge.degenerate ? 1 : std::max(1, edge.pieces.size()); }

const CurvePiece& piece_at(const NurbsStore& store, const Edge& edge, double at, double& local) {
  const int k = std::clamp(static_cast<int>(at), 0, edge.pieces.size() - 1);
  local = at - k;
  return store.edge_pieces[edge.pieces.begin + k];
}

dvec3 path_point(const NurbsStore& store, const Edge& edge, double at) {
  if (edge.degenerate) return store.vertices[edge.vertex[0]].point;
  if (at <= 0.0) return store.vertices[edge.vertex[0]].point;
  if (at >= edge.pieces.size()) return store.vertices[edge.vertex[1]].point;
  double t;
  const CurvePiece& piece = piece_at(store, edge, at, t);
  return nurbs::project(
      nurbs::bezier_point(store.edge_ctrl_h.data() + piece.ctrl.begin, piece.ctrl.size() - 1, t));
}

double distance_to_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 d = b - a;
  const double length2 = glm::dot(d, d);
  const double t = length2 > 0.0 ? std::clamp(glm::dot(p - a, d) / length2, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + t * d);
}

// Control points of the part [t0, t1] of a rational Bezier curve.
void part(const dvec4* ctrl, int degree, double t0, double t1, std::vector<dvec4>& out) {
  out.assign(ctrl, ctrl + degree + 1);
  if (t1 < 1.0)
    for (int r = 1; r <= degree; ++r)
      for (int i = degree; i >= r; --i) out[i] = (1.0 - t1) * out[i - 1] + t1 * out[i];
  if (t0 > 0.0) {
    const double s = t0 / t1;
    for (int r = 1; r <= degree; ++r)
      for (int i = 0; i + r <= degree; ++i) out[i] = (1.0 - s) * out[i] + s * out[i + 1];
  }
}

// The largest distance of the path between two places from the chord. The hull of a quarter is closer to its
// curve than the hull of the whole by 16.
double chord_deviation(const NurbsStore& store, const Edge& edge, double from, double to, const dvec3& a,
                       const dvec3& b) {
  if (edge.degenerate) return 0.0;
  constexpr int kParts = 4;
  std::vector<dvec4> ctrl;
  double most = 0.0;
  const int first = std::clamp(static_cast<int>(from), 0, edge.pieces.size() - 1);
  for (int k = first; k < edge.pieces.size() && k < to; ++k) {
    const CurvePiece& piece = store.edge_pieces[edge.pieces.begin + k];
    const double t0 = std::max(0.0, from - k), t1 = std::min(1.0, to - k);
    const int degree = piece.ctrl.size() - 1, parts = degree > 1 ? kParts : 1;
    for (int i = 0; i < parts; ++i) {
      const double s0 = t0 + (t1 - t0) * i / parts, s1 = t0 + (t1 - t0) * (i + 1) / parts;
      part(store.edge_ctrl_h.data() + piece.ctrl.begin, degree, s0, s1, ctrl);
      for (const dvec4& h : ctrl) most = std::max(most, distance_to_segment(nurbs::project(h), a, b));
    }
  }
  return most;
}

// How many segments the edge wants, spread over its path.
class Density {
 public:
  Density(const NurbsStore& store, const Edge& edge, const std::vector<EdgeUse>& uses,
          const EdgeLimits& limits)
      : store_(store), edge_(edge), uses_(uses), limits_(limits) {
    const int pieces = piece_count(edge);
    for (int k = 0; k < pieces; ++k) {
      const int atoms = atoms_of(k, pieces);
      for (int i = 0; i < atoms; ++i) place_.push_back(k + double(i) / atoms);
    }
    place_.push_back(pieces);
    cost_.assign(place_.size(), 0.0);
    corners_.assign(place_.size(), false);
    run();
  }

  // Places of the samples, both ends included.
  std::vector<double> samples() const {
    std::vector<double> at{0.0};
    std::size_t begin = 0;
    for (std::size_t i = 1; i < place_.size(); ++i)
      if (corners_[i] || i + 1 == place_.size()) {
        fill(begin, i, at);
        begin = i;
      }
    return at;
  }

 private:
  int atoms_of(int k, int pieces) const {
    bool curved = edge_.degenerate;
    if (!edge_.degenerate) curved = store_.edge_pieces[edge_.pieces.begin + k].ctrl.size() > 2;
    for (const EdgeUse& use : uses_)
      if (use.chart->surface().kind != nurbs::SurfaceKind::kPlane &&
          use.chart->surface().kind != nurbs::SurfaceKind::kCylinder &&
          use.chart->surface().kind != nurbs::SurfaceKind::kCone)
        curved = true;
    if (!curved) return 1;
    return pieces == 1 ? 8 : pieces <= 4 ? 4 : 2;
  }

  void run() {
    const std::size_t n = place_.size();
    std::vector<dvec3> point(n), middle(n - 1);
    for (std::size_t i = 0; i < n; ++i) point[i] = path_point(store_, edge_, place_[i]);
    for (std::size_t i = 0; i + 1 < n; ++i)
      middle[i] = path_point(store_, edge_, 0.5 * (place_[i] + place_[i + 1]));
    std::vector<double> limit(n - 1), own(n - 1, 0.0);
    for (std::size_t i = 0; i + 1 < n; ++i) {
      Box3 box;
      box.add(point[i]), box.add(point[i + 1]), box.add(middle[i]);
      limit[i] = kShare * limits_.tolerance->at(box);
      own[i] = std::sqrt(distance_to_segment(middle[i], point[i], point[i + 1]) / limit[i]);
      own[i] =
          std::max(own[i], turn(point[i], middle[i], point[i + 1]) / std::min(kWidestTurn, limits_.angle));
    }
    for (const EdgeUse& use : uses_) face_cost(use, limit, own);
    for (std::size_t i = 0; i + 1 < n; ++i) cost_[i + 1] = cost_[i] + (std::isfinite(own[i]) ? own[i] : 0.0);
    find_corners(point, middle);
  }

  // Of the surface along the chart's chords.
  void face_cost(const EdgeUse& use, const std::vector<double>& limit, std::vector<double>& own) const {
    const Chart& chart = *use.chart;
    const nurbs::SurfaceKind kind = chart.surface().kind;
    if (kind == nurbs::SurfaceKind::kPlane) return;
    const CoEdge& coedge = store_.coedges[use.coedge];
    dvec2 before = chart.from_face(pcurve_point(store_, coedge, place_[0]));
    nurbs::SurfacePoint s = chart.at(before);
    for (std::size_t i = 0; i + 1 < place_.size(); ++i) {
      const dvec2 after = chart.from_face(pcurve_point(store_, coedge, place_[i + 1]));
      const nurbs::SurfacePoint next = chart.at(after), at = chart.at(0.5 * (before + after));
      const dvec3 gap = at.p - 0.5 * (s.p + next.p), n = glm::cross(at.du, at.dv);
      const double length = glm::length(n);
      // Along the degenerate side of a pole nothing deviates; the turn of its neighbours' normals says how
      // many.
      const double off = length > 0.0 ? std::abs(glm::dot(gap, n)) / length : 0.0;
      own[i] = std::max(own[i], std::sqrt(off / (use.tree != nullptr ? kSideShare * limit[i] : limit[i])));
      const double most = std::min(kWidestTurn, limits_.angle);
      own[i] = std::max(own[i], turn_of_normals(s, next) / most);
      if (edge_.degenerate && chart.closed_form())
        own[i] = std::max(own[i], std::abs(after.x - before.x) / 1.0);
      before = after, s = next;
    }
  }

  static double turn(const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 d = b - a, e = c - b;
    // Twice the angle between the halves' chords is the turn of the tangent.
    return 2.0 * std::atan2(glm::length(glm::cross(d, e)), glm::dot(d, e));
  }

  static double turn_of_normals(const nurbs::SurfacePoint& a, const nurbs::SurfacePoint& b) {
    const dvec3 m = glm::cross(a.du, a.dv), n = glm::cross(b.du, b.dv);
    return std::atan2(glm::length(glm::cross(m, n)), glm::dot(m, n));
  }

  // Where the path turns sharply between two pieces there is a sample.
  void find_corners(const std::vector<dvec3>& point, const std::vector<dvec3>&) {
    if (edge_.degenerate) return;
    for (std::size_t i = 1; i + 1 < place_.size(); ++i) {
      if (place_[i] != std::floor(place_[i])) continue;
      const int k = static_cast<int>(place_[i]);
      const CurvePiece &before = store_.edge_pieces[edge_.pieces.begin + k - 1],
                       &after = store_.edge_pieces[edge_.pieces.begin + k];
      const auto ctrl = [&](std::int32_t c) { return nurbs::project(store_.edge_ctrl_h[c]); };
      const dvec3 in = point[i] - ctrl(before.ctrl.end - 2), out = ctrl(after.ctrl.begin + 1) - point[i];
      const double turned = std::atan2(glm::length(glm::cross(in, out)), glm::dot(in, out));
      const double reach = std::min(glm::length(in), glm::length(out));
      Box3 box;
      box.add(point[i]);
      if (turned * reach > 0.1 * limits_.tolerance->at(box) && turned > 1e-3) corners_[i] = true;
    }
  }

  // Samples between two corners, the first excluded, the last included.
  void fill(std::size_t begin, std::size_t end, std::vector<double>& at) const {
    const double sum = cost_[end] - cost_[begin], total = std::isfinite(sum) ? sum : 0.0;
    int count = std::max(1, static_cast<int>(std::ceil(std::min(total, double(kMostSegments)) - 1e-6)));
    const bool closed = edge_.vertex[0] == edge_.vertex[1] && begin == 0 && end + 1 == place_.size();
    if (closed && !edge_.degenerate) count = std::max(count, 3);
    std::size_t i = begin;
    for (int k = 1; k < count; ++k) {
      const double wanted = cost_[begin] + total * k / count;
      while (i + 1 < end && cost_[i + 1] < wanted) ++i;
      const double span = cost_[i + 1] - cost_[i];
      const double f = total > 0.0 && span > 0.0 ? (wanted - cost_[i]) / span : 0.0;
      if (total > 0.0)
        at.push_back(place_[i] + f * (place_[i + 1] - place_[i]));
      else
        at.push_back(place_[begin] + (place_[end] - place_[begin]) * k / count);
    }
    at.push_back(place_[end]);
  }

  const NurbsStore& store_;
  const Edge& edge_;
  const std::vector<EdgeUse>& uses_;
  const EdgeLimits& limits_;
  std::vector<double> place_, cost_;
  std::vector<bool> corners_;
};

// The proven distance between the surface along a straight line of the chart and the chord, across the
// surface.
double side_deviation(const EdgeUse& use, dvec2 a, dvec2 b) {
  Box2 box;
  box.add(a), box.add(b);
  const nurbs::SurfacePoint middle = use.chart->at(0.5 * (a + b));
  const dvec3 cross = glm::cross(middle.du, middle.dv);
  const double length = glm::length(cross);
  if (!(length > 0.0)) return 0.0;
  const dvec3 n = cross / length;
  const dvec2 d = box.extent();
  const CurvatureRange r = use.tree->over(box);
  const auto size = [&](const Box3& range) { return along(n, range).magnitude(); };
  const double sum =
      d.x * d.x * size(r.second.uu) + 2.0 * d.x * d.y * size(r.second.uv) + d.y * d.y * size(r.second.vv);
  return 0.125 * sum + (r.kinks > 0 ? r.kinks * size(r.kink) : 0.0);
}

// Where on the path between two places its p-curve crosses a kink of the surface; the middle if it crosses
// none.
double place_of_kink(const NurbsStore& store, const EdgeUse& use, double from, double to, dvec2 p, dvec2 q) {
  const double middle = 0.5 * (from + to);
  for (const int d : {0, 1}) {
    const double kink = use.tree->kink_between(d, p[d], q[d]);
    const double share = (kink - p[d]) / (q[d] - p[d]);
    if (!(share > 0.02 && share < 0.98)) continue;
    double lo = from, hi = to;
    for (int step = 0; step < 50; ++step) {
      const double at = 0.5 * (lo + hi);
      const double x = use.chart->from_face(pcurve_point(store, store.coedges[use.coedge], at))[d];
      ((x < kink) == (p[d] < kink) ? lo : hi) = at;
    }
    return lo > from && hi < to ? 0.5 * (lo + hi) : middle;
  }
  return middle;
}

}  // namespace

dvec2 pcurve_point(const NurbsStore& store, const CoEdge& coedge, double at) {
  const Edge& edge = store.edges[coedge.edge];
  const nurbs::Range& pieces = coedge.pieces;
  const auto value = [&](const CurvePiece& piece, double t) {
    return nurbs::project(
        nurbs::bezier_point(store.trim_ctrl_h.data() + piece.ctrl.begin, piece.ctrl.size() - 1, t));
  };
  if (edge.degenerate) {
    const double along = (coedge.reversed ? 1.0 - at : at) * pieces.size();
    const int k = std::clamp(static_cast<int>(along), 0, pieces.size() - 1);
    return value(store.trim_pieces[pieces.begin + k], along - k);
  }
  double local;
  const CurvePiece& own = piece_at(store, edge, at, local);
  const double t = own.t0 + (own.t1 - own.t0) * local;
  // In loop order t0 -> t1 runs forward, or backward when the edge is used against its path.
  std::int32_t lo = pieces.begin, hi = pieces.end - 1;
  while (lo < hi) {
    const std::int32_t middle = (lo + hi) / 2;
    const CurvePiece& piece = store.trim_pieces[middle];
    const bool past = piece.t1 >= piece.t0 ? t > piece.t1 : t < piece.t1;
    if (past)
      lo = middle + 1;
    else
      hi = middle;
  }
  const CurvePiece& piece = store.trim_pieces[lo];
  const double width = piece.t1 - piece.t0;
  return value(piece, width != 0.0 ? std::clamp((t - piece.t0) / width, 0.0, 1.0) : 0.0);
}

dvec2 sample_in_chart(const NurbsStore& store, const Chart& chart, const CoEdge& coedge, double at,
                      const dvec3& point) {
  const dvec2 guess = chart.from_face(pcurve_point(store, coedge, at));
  return store.edges[coedge.edge].degenerate ? guess : chart.project(point, guess);
}

EdgePolyline make_polyline(const NurbsStore& store, const Edge& edge, const dvec3 (&ends)[2],
                           const std::vector<EdgeUse>& uses, const EdgeLimits& limits) {
  EdgePolyline line;
  line.at = Density(store, edge, uses, limits).samples();
  for (const double at : line.at) line.points.push_back(path_point(store, edge, at));
  line.points.front() = ends[0], line.points.back() = ends[1];
  constexpr int kRounds = 20, kSideRounds = 6;
  for (int round = 0;; ++round) {
    line.deviation.resize(line.segments());
    std::vector<Cut> failing;
    for (int k = 0; k < line.segments(); ++k) {
      const dvec3 &a = line.points[k], &b = line.points[k + 1];
      line.deviation[k] = chord_deviation(store, edge, line.at[k], line.at[k + 1], a, b);
      Box3 box;
      box.add(a), box.add(b);
      const double limit = limits.tolerance->at(box), middle = 0.5 * (line.at[k] + line.at[k + 1]);
      if (line.deviation[k] > std::max(limit, edge.band)) {
        failing.push_back({k, middle});
        continue;
      }
      for (const EdgeUse& use : uses) {
        if (use.tree == nullptr || round >= kSideRounds) continue;
        const CoEdge& coedge = store.coedges[use.coedge];
        const dvec2 p = use.chart->from_face(pcurve_point(store, coedge, line.at[k])),
                    q = use.chart->from_face(pcurve_point(store, coedge, line.at[k + 1]));
        if (!(side_deviation(use, p, q) > kSideShare * limit)) continue;
        failing.push_back({k, place_of_kink(store, use, line.at[k], line.at[k + 1], p, q)});
        break;
      }
    }
    if (failing.empty() || round == kRounds || line.segments() > kMostSegments) return line;
    split_segments(store, edge, failing, line);
  }
}

void split_segments(const NurbsStore& store, const Edge& edge, const std::vector<Cut>& cuts,
                    EdgePolyline& line) {
  EdgePolyline out;
  std::size_t next = 0;
  for (int k = 0; k < line.segments(); ++k) {
    out.at.push_back(line.at[k]), out.points.push_back(line.points[k]);
    if (next < cuts.size() && cuts[next].first == k) {
      const double at = cuts[next++].second;
      const dvec3 p = path_point(store, edge, at);
      out.deviation.push_back(chord_deviation(store, edge, line.at[k], at, line.points[k], p));
      out.deviation.push_back(chord_deviation(store, edge, at, line.at[k + 1], p, line.points[k + 1]));
      out.at.push_back(at), out.points.push_back(p);
    } else {
      out.deviation.push_back(k < static_cast<int>(line.deviation.size()) ? line.deviation[k] : 0.0);
    }
  }
  out.at.push_back(line.at.back()), out.points.push_back(line.points.back());
  line = std::move(out);
}

}  // namespace trimray::tess
