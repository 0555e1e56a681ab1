#include "core/tess/face_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_set>

#include "core/tess/cell_map.h"
#include "core/tess/delaunay.h"
#include "core/tess/face_net.h"
#include "core/tess/half_edge.h"
#include "core/tess/inner_points.h"
#include "core/tess/triangle_bound.h"

namespace trimray::tess {

using nurbs::NurbsStore;

namespace {

constexpr int kRounds = 60, kPatience = 4, kCrossings = 8, kInversions = 4;
constexpr double kSideShare = 0.9;  // of the tolerance, for a side alone: with it the triangle can be within
constexpr double kMuch = 0.4;       // of the tolerance: sides that deviate less are not to blame
constexpr double kFlat = 0.3;  // of the tolerance: flatter triangles only get flatter by halving short sides
constexpr std::size_t kMaxPoints = 1'000'000;

class FaceMesher : FaceNet {
 public:
  FaceMesher(const NurbsStore& store, std::int32_t face, const Chart& chart, const CurvatureTree* tree,
             const FacePolygon& polygon, const EdgeLimits& limits)
      : face_(store.faces[face]), chart_(chart), tree_(tree), polygon_(polygon), limits_(limits) {}

  FaceMesh run(const FaceHints& hints) {
    out_.own_vertices = polygon_.own_vertices;
    crossings_ = hints.crossings;
    if (polygon_.loops.empty()) return std::move(out_);  // smaller than its edges' tolerances
    cells_ = tree_ != nullptr ? CellMap(*tree_, polygon_.box) : CellMap(polygon_.box);
    add_boundary();
    if (tree_)
      for (const dvec2 p : inner_points(*tree_, polygon_)) add_inner(p);
    for (const dvec2 p : hints.points) add_inner(p);
    added_.clear();
    for (round_ = 0; round_ < kRounds; ++round_) {
      if (!triangulate()) return std::move(out_);
      if (some_turned()) {
        cells_.make_even();
        if (!triangulate()) return std::move(out_);
      }
      if (!refine() || points_.size() > kMaxPoints) break;
    }
    take();
    return std::move(out_);
  }

 private:
  void add_boundary() {
    for (const auto& loop : polygon_.loops) {
      std::vector<int> index;
      for (const BoundaryPoint& b : loop) index.push_back(boundary_node(b));
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const int a = index[i], b = index[(i + 1) % loop.size()];
        if (a == b) continue;
        boundary_[{std::min(a, b), std::max(a, b)}] = static_cast<int>(sides_.size());
        sides_.push_back({a, b});
        side_edge_.push_back({loop[i].edge, loop[i].segment});
        side_deviation_.push_back(loop[i].side_deviation);
      }
    }
  }

  // Where loops touch at a vertex its feet differ by rounding: they are one.
  int boundary_node(const BoundaryPoint& b) {
    const dvec2 near = 1e-6 * polygon_.box.extent();
    auto& nodes = nodes_of_[b.vertex];
    for (const int n : nodes) {
      const dvec2 gap = glm::abs(points_[n].p - b.p);
      if (gap.x <= near.x && gap.y <= near.y) return n;
    }
    const auto [at, fresh] = known_.try_emplace({b.p.x, b.p.y}, static_cast<int>(points_.size()));
    if (fresh) {
      taken_.insert(place_in_cells(b.p));
      nodes.push_back(at->second);
      add_node(b.p, b.place, b.vertex);
    }
    return at->second;
  }

  void add_node(dvec2 p, const dvec3& place, VertexKey vertex) {
    Node n{p, place, place, 0.0, vertex, dvec3(0.0)};
    if (limits_.angle < kInf) {
      const nurbs::SurfacePoint s = chart_.at(p);
      n.surface = s.p;
      const dvec3 cross = glm::cross(s.du, s.dv);
      const double length = glm::length(cross);
      if (length > 0.0) n.normal = cross / length;
    } else {
      n.surface = chart_.point(p);
    }
    n.gap = glm::distance(place, n.surface);
    points_.push_back(n);
  }

  // Points nearer than this would make degenerate triangles, and prove nothing.
  std::array<int, 2> place_in_cells(dvec2 p) const {
    constexpr double kNear = 1e-3;  // of a cell
    const dvec2 c = glm::clamp(cells_.to_cells(p) / kNear, dvec2(-1e9), dvec2(1e9));
    return {static_cast<int>(std::lround(c.x)), static_cast<int>(std::lround(c.y))};
  }

  // A torus whose tube touches its axis has one place there for a whole line of the chart: no place for
  // points.
  bool on_axis(const dvec3& place) const {
    const nurbs::Surface& f = chart_.surface();
    return f.kind == nurbs::SurfaceKind::kTorus && glm::distance(place, f.location) <= 1e-9 * f.r1;
  }

  void add_inner(dvec2 p) {
    const dvec3 place = chart_.point(p);
    if (on_axis(place) || !taken_.insert(place_in_cells(p)).second) return;
    added_.push_back(p);
    out_.own_vertices.push_back(place);
    add_node(p, place, -static_cast<VertexKey>(out_.own_vertices.size()));
  }

  bool triangulate() {
    std::vector<dvec2> scaled(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) scaled[i] = cells_.to_cells(points_[i].p);
    Delaunay result = tess::triangulate(scaled, sides_);
    if (result.outcome == Delaunay::Outcome::kDone) {
      triangles_ = std::move(result.triangles);
      if (crossings_ < kInversions && ask_for_rounder_loops()) return false;
      flip_degenerate();
      return true;
    }
    // Sides that cross because they are coarse do so no more when they are halved some times; others for
    // ever.
    out_.crossed = result.outcome == Delaunay::Outcome::kCrossing;
    if (crossings_ < kCrossings)
      for (const auto& [s, t] : result.crossings) {
        const bool straight = side_deviation_[s] <= 0.0 && side_deviation_[t] <= 0.0;
        for (const int side : {s, t})
          if (side_edge_[side][0] >= 0 && !straight) out_.split.push_back(side_edge_[side]);
      }
    // Edges so short that they are one segment each may enclose nothing.
    if (result.outcome == Delaunay::Outcome::kFailed && crossings_ < kCrossings)
      for (const auto& edge : side_edge_)
        if (edge[0] >= 0) out_.split.push_back(edge);
    out_.failure = result.outcome == Delaunay::Outcome::kCrossing ? "its loops cross or touch"
                                                                  : "its loops enclose nothing";
    return false;
  }

  // A rim so coarse that it lies inside the hole that it surrounds: the triangles are between them, but on
  // the wrong sides of both. Then some sides have theirs on the left and others on the right.
  bool ask_for_rounder_loops() {
    bool left = false, right = false;
    for (const auto& t : triangles_)
      for (int k = 0; k < 3; ++k) {
        const auto side = boundary_.find(ordered(t[k], t[(k + 1) % 3]));
        if (side != boundary_.end()) (sides_[side->second][0] == t[k] ? left : right) = true;
      }
    if (!left || !right || boundary_.size() != sides_.size()) return false;
    for (std::size_t i = 0; i < sides_.size(); ++i)
      if (side_edge_[i][0] >= 0 && side_deviation_[i] > 0.0) out_.split.push_back(side_edge_[i]);
    out_.crossed = !out_.split.empty();
    if (out_.crossed) out_.failure = "its loops cross or touch";
    return out_.crossed;
  }

  TriangleBound bound(const std::array<int, 3>& t) const {
    const dvec2 p[3] = {points_[t[0]].p, points_[t[1]].p, points_[t[2]].p};
    const dvec3 s[3] = {points_[t[0]].surface, points_[t[1]].surface, points_[t[2]].surface};
    TriangleBound r = bound_triangle(chart_, tree_, p, s, limit_of(t));
    if (limits_.angle < kInf)
      for (int k = 0; k < 3; ++k) {
        const dvec3 &a = points_[t[k]].normal, &b = points_[t[(k + 1) % 3]].normal;
        if (std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) > 1.000001 * limits_.angle)
          r.side[k] = r.deviation = kInf;
      }
    return r;
  }

  // New points in triangles that are too far off; false when there are none to add.
  bool refine() {
    bounds_.clear();
    out_.split.clear(), out_.failure.clear();
    for (const auto& t : triangles_) bounds_.push_back(known_bound(t));
    std::vector<std::array<int, 3>> failing = find_failing();
    if (!failing.empty() && flips_help_ && flip_sides()) failing = find_failing();
    std::vector<std::array<int, 2>> halve;
    for (const auto& t : failing) refine_triangle(t, limit_of(t), halve);
    std::sort(halve.begin(), halve.end());
    halve.erase(std::unique(halve.begin(), halve.end()), halve.end());
    const std::size_t before = points_.size();
    for (const auto& s : halve) add_inner(parting(points_[s[0]].p, points_[s[1]].p));
    // Where the right places are taken: any other.
    if (points_.size() == before && out_.split.empty())
      for (const auto& t : failing)
        add_inner(cells_.to_chart((cells_.to_cells(points_[t[0]].p) + cells_.to_cells(points_[t[1]].p) +
                                   cells_.to_cells(points_[t[2]].p)) /
                                  3.0));
    if (points_.size() == before && out_.split.empty())
      for (const auto& t : failing)
        for (int k = 0; k < 3; ++k) {
          const auto side = boundary_.find(ordered(t[k], t[(k + 1) % 3]));
          if (side != boundary_.end() && side_edge_[side->second][0] >= 0)
            out_.split.push_back(side_edge_[side->second]);
        }
    // Edges that must be finer change the boundary: then all begins again, with the inner points found so
    // far.
    if (out_.split.empty()) {
      if (points_.size() > before) return true;
      // A turned diagonal may be what stands in the way: once more without.
      const bool again = flips_help_ && !failing.empty();
      flips_help_ = false;
      return again;
    }
    out_.failure = "an edge must be finer";
    out_.found = std::move(added_);
    return false;
  }

  std::vector<std::array<int, 3>> find_failing() const {
    std::vector<std::array<int, 3>> failing;
    for (std::size_t i = 0; i < triangles_.size(); ++i)
      if (too_far(i)) failing.push_back(triangles_[i]);
    return failing;
  }

  // Better diagonals before new points. False when nothing changed.
  bool flip_sides() {
    if (boundary_.size() != sides_.size()) return false;  // a slit, which is no side to flip
    TriMesh mesh;
    std::vector<std::size_t> kept;
    for (const Node& n : points_) mesh.vertices.push_back(n.surface);
    double most = 0.0;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const auto& t = triangles_[i];
      if (collapsed(t)) continue;
      kept.push_back(i);
      mesh.triangles.push_back({t[0], t[1], t[2]});
      mesh.corner_uv.push_back({points_[t[0]].p, points_[t[1]].p, points_[t[2]].p});
      mesh.face.push_back(0);
      mesh.deviation.push_back(bounds_[i]);
      most = std::max(most, limit_of(t));
    }
    const auto proof = [&](std::int32_t, const std::array<dvec2, 3>& p, const std::array<dvec3, 3>& s) {
      return bound_triangle(chart_, tree_, p.data(), s.data(), most).deviation;
    };
    if (limits_.angle < kInf || improve(mesh, proof, most) == 0) return false;
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const auto& t = mesh.triangles[k];
      triangles_[kept[k]] = {t[0], t[1], t[2]};
      bounds_[kept[k]] = mesh.deviation[k];
    }
    return true;
  }

  // Where to halve a side: at a kink that it crosses, else in the middle of its cells.
  dvec2 parting(dvec2 a, dvec2 b) const {
    for (const int d : {0, 1}) {
      const double t = kink_share(d, a, b);
      if (!(t > 0.0)) continue;
      dvec2 p = a + t * (b - a);
      p[d] = tree_->kink_between(d, a[d], b[d]);
      return p;
    }
    return cells_.to_chart(0.5 * (cells_.to_cells(a) + cells_.to_cells(b)));
  }

  bool crosses_kink(int a, int b) const {
    return kink_share(0, points_[a].p, points_[b].p) > 0.0 || kink_share(1, points_[a].p, points_[b].p) > 0.0;
  }

  // How far along from a to b a kink in direction d lies; 0 when there is none well inside.
  double kink_share(int d, dvec2 a, dvec2 b) const {
    const double x = tree_ != nullptr ? tree_->kink_between(d, a[d], b[d]) : kNaN;
    const double t = (x - a[d]) / (b[d] - a[d]);
    return t > 0.02 && t < 0.98 ? t : 0.0;
  }

  double limit_of(const std::array<int, 3>& t) const {
    Box3 box;
    for (const int k : t) box.add(points_[k].place);
    return limits_.tolerance->at(box);
  }

  bool too_far(std::size_t i) const {
    const auto& t = triangles_[i];
    if (collapsed(t)) return false;
    const double limit = limit_of(t), gap = corner_gap(t);
    // What the file's own gaps take up cannot be refined away.
    return bounds_[i] + gap > limit && bounds_[i] > std::max(limit - gap, 0.3 * limit);
  }

  double known_bound(const std::array<int, 3>& t) {
    if (collapsed(t)) return 0.0;
    const auto [at, fresh] = known_bounds_.try_emplace(t, 0.0);
    if (fresh) at->second = bound(t).deviation;
    return at->second;
  }

  // Halves the side that deviates most, or where none does much the longest one: then the shape is to blame.
  // Sides on edges are the neighbours' too, and are halved only when they must be.
  void refine_triangle(const std::array<int, 3>& t, double limit, std::vector<std::array<int, 2>>& halve) {
    const TriangleBound b = bound(t);
    const std::array<int, 2> longest = longest_side(t).ends;
    const bool shape = worst_of(b) <= kMuch * limit || longest_side(t).height <= kFlat * limit;
    if (shape || b.kinks > kFlat * limit)
      for (int k = 0; k < 3; ++k)
        if (crosses_kink(t[k], t[(k + 1) % 3]) && !boundary_.count(ordered(t[k], t[(k + 1) % 3]))) {
          halve.push_back(ordered(t[k], t[(k + 1) % 3]));
          return;
        }
    int worst = -1;
    for (int k = 0; k < 3; ++k) {
      const std::array<int, 2> ends = ordered(t[k], t[(k + 1) % 3]);
      const auto side = boundary_.find(ends);
      if (side != boundary_.end()) {
        const auto& edge = side_edge_[side->second];
        // After some rounds halving the others has not helped.
        const bool stubborn = round_ >= kPatience && b.side[k] >= worst_of(b);
        if (edge[0] < 0 || !(shape ? ends == longest : stubborn || b.side[k] > kSideShare * limit)) continue;
        out_.split.push_back(edge);
        return;
      }
      if (shape && ends == longest) {
        worst = k;
        break;
      }
      if (worst < 0 || b.side[k] > b.side[worst]) worst = k;
    }
    if (worst >= 0) halve.push_back(ordered(t[worst], t[(worst + 1) % 3]));
  }

  static double worst_of(const TriangleBound& b) {
    return std::max(b.side[0], std::max(b.side[1], b.side[2]));
  }

  void take() {
    const bool proven = chart_.surface().kind != nurbs::SurfaceKind::kOffset;
    if (!proven) out_.failure = "an offset surface: its deviation is estimated, not proven";
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const auto& t = triangles_[i];
      if (collapsed(t)) continue;
      std::array<int, 3> k = t;
      if (face_.reversed) std::swap(k[1], k[2]);
      out_.triangles.push_back({points_[k[0]].vertex, points_[k[1]].vertex, points_[k[2]].vertex});
      out_.corner_uv.push_back({chart_.to_face(points_[k[0]].p), chart_.to_face(points_[k[1]].p),
                                chart_.to_face(points_[k[2]].p)});
      double deviation = proven ? bounds_[i] + corner_gap(t) : kInf;
      for (int j = 0; j < 3; ++j) {
        const auto side = boundary_.find(ordered(t[j], t[(j + 1) % 3]));
        if (side != boundary_.end() && side_edge_[side->second][0] >= 0)
          deviation = std::max(deviation, side_deviation_[side->second]);
      }
      out_.deviation.push_back(deviation);
    }
    for (std::size_t i = 0; i < triangles_.size() && out_.failure.empty(); ++i)
      if (too_far(i)) out_.failure = "the deviation could not be reached everywhere";
    if (out_.triangles.empty()) out_.failure = "its loops enclose nothing";
  }

  const nurbs::Face& face_;
  const Chart& chart_;
  const CurvatureTree* tree_;
  const FacePolygon& polygon_;
  const EdgeLimits& limits_;
  CellMap cells_;
  std::map<std::array<double, 2>, int> known_;  // places in the chart
  std::unordered_set<std::array<int, 2>, IndexHash> taken_;
  std::map<VertexKey, std::vector<int>> nodes_of_;  // of the boundary
  int round_ = 0, crossings_ = 0;
  bool flips_help_ = true;
  std::vector<dvec2> added_;  // by refinement
  IndexMap<3, double> known_bounds_;
  std::vector<double> bounds_;
  FaceMesh out_;
};

}  // namespace

FaceMesh mesh_face(const NurbsStore& store, std::int32_t face, const Chart& chart, const CurvatureTree* tree,
                   const FacePolygon& polygon, const EdgeLimits& limits, const FaceHints& hints) {
  return FaceMesher(store, face, chart, tree, polygon, limits).run(hints);
}

}  // namespace trimray::tess
