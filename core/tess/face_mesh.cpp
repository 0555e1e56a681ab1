#include "core/tess/face_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "core/tess/delaunay.h"
#include "core/tess/inner_points.h"
#include "core/tess/triangle_bound.h"

namespace trimray::tess {

using nurbs::NurbsStore;
using nurbs::SurfaceKind;

namespace {

constexpr int kRounds = 24;
constexpr double kSideShare = 0.9;  // of the tolerance, for a side alone: with it the triangle can be within
constexpr std::size_t kMaxPoints = 4'000'000;

class FaceMesher {
 public:
  FaceMesher(const NurbsStore& store, std::int32_t face, const Chart& chart, const FacePolygon& polygon,
             const EdgeLimits& limits)
      : store_(store), face_(store.faces[face]), chart_(chart), polygon_(polygon), limits_(limits) {}

  FaceMesh run(const FaceHints& hints) {
    out_.own_vertices = polygon_.own_vertices;
    if (polygon_.loops.empty()) {
      out_.failure = "no loop encloses anything";
      return std::move(out_);
    }
    const SurfaceKind kind = chart_.surface().kind;
    if (kind != SurfaceKind::kPlane)
      tree_ =
          std::make_unique<CurvatureTree>(store_, chart_, polygon_.box, *limits_.tolerance, limits_.angle);
    add_boundary();
    choose_scale();
    if (tree_)
      for (const dvec2 p : inner_points(*tree_, polygon_)) add_inner(p);
    for (const dvec2 p : hints.points) add_inner(p);
    for (int round = 0; round < kRounds; ++round) {
      if (!triangulate()) return std::move(out_);
      if (!refine() || points_.size() > kMaxPoints) break;
    }
    take();
    return std::move(out_);
  }

 private:
  struct Node {
    dvec2 p;               // chart
    dvec3 place, surface;  // the vertex, and the surface's point at p
    double gap;            // their distance
    VertexKey vertex;
    dvec3 normal;  // unit, where an angle is asked for
  };

  void add_boundary() {
    for (const auto& loop : polygon_.loops) {
      std::vector<int> index;
      for (const BoundaryPoint& b : loop) {
        const auto [at, fresh] = known_.try_emplace({b.p.x, b.p.y}, static_cast<int>(points_.size()));
        if (fresh) add_node(b.p, b.place, b.vertex);
        index.push_back(at->second);
      }
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const int a = index[i], b = index[(i + 1) % loop.size()];
        if (a == b) continue;
        boundary_[{std::min(a, b), std::max(a, b)}] = static_cast<int>(sides_.size());
        sides_.push_back({a, b});
        side_edge_.push_back({loop[i].edge, loop[i].segment});
      }
    }
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

  void add_inner(dvec2 p) {
    if (!known_.try_emplace({p.x, p.y}, static_cast<int>(points_.size())).second) return;
    const dvec3 place = chart_.point(p);
    out_.own_vertices.push_back(place);
    add_node(p, place, -static_cast<VertexKey>(out_.own_vertices.size()));
  }

  // The chart is stretched so that a cell of the grid is about a square; planes are as they are.
  void choose_scale() {
    if (!tree_) return;
    const dvec2 extent = glm::max(polygon_.box.extent(), dvec2(1e-300));
    dvec2 cell(0.0);
    double weight = 0.0;
    for (const GridLeaf& leaf : tree_->leaves()) {
      const dvec2 e = leaf.box.extent();
      cell += (e.x * e.y) * glm::min(e / dvec2(leaf.count_u, leaf.count_v), extent);
      weight += e.x * e.y;
    }
    if (weight > 0.0) cell /= weight;
    for (int d = 0; d < 2; ++d)
      if (!(cell[d] > 0.0 && std::isfinite(cell[d]))) cell[d] = extent[d];
    scale_ = 1.0 / cell;
  }

  bool triangulate() {
    std::vector<dvec2> scaled(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) scaled[i] = points_[i].p * scale_;
    Delaunay result = tess::triangulate(scaled, sides_);
    if (result.outcome == Delaunay::Outcome::kDone) {
      triangles_ = std::move(result.triangles);
      return true;
    }
    for (const auto& [s, t] : result.crossings)
      for (const int side : {s, t})
        if (side_edge_[side][0] >= 0) out_.split.push_back(side_edge_[side]);
    out_.failure = result.outcome == Delaunay::Outcome::kCrossing ? "its loops cross or touch"
                                                                  : "its loops enclose nothing";
    return false;
  }

  double corner_gap(const std::array<int, 3>& t) const {
    return std::max(points_[t[0]].gap, std::max(points_[t[1]].gap, points_[t[2]].gap));
  }

  // Two corners at one vertex: a triangle at a pole, which has no area.
  bool collapsed(const std::array<int, 3>& t) const {
    const VertexKey a = points_[t[0]].vertex, b = points_[t[1]].vertex, c = points_[t[2]].vertex;
    return a == b || b == c || c == a;
  }

  TriangleBound bound(const std::array<int, 3>& t) const {
    const dvec2 p[3] = {points_[t[0]].p, points_[t[1]].p, points_[t[2]].p};
    const dvec3 s[3] = {points_[t[0]].surface, points_[t[1]].surface, points_[t[2]].surface};
    TriangleBound r = bound_triangle(chart_, tree_.get(), p, s);
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
    std::vector<std::array<int, 2>> halve;
    for (const auto& t : triangles_) {
      const double bound = known_bound(t);
      bounds_.push_back(bound);
      if (collapsed(t)) continue;
      Box3 box;
      for (const int k : t) box.add(points_[k].place);
      const double limit = limits_.tolerance->at(box), gap = corner_gap(t);
      // What the file's own gaps take up cannot be refined away.
      if (bound + gap > limit && bound > std::max(limit - gap, 0.3 * limit)) improve(t, limit, halve);
    }
    // Edges that must be finer change the boundary: then all begins again, with the inner points found so
    // far.
    if (!out_.split.empty()) {
      out_.failure = "an edge must be finer";
      return false;
    }
    std::sort(halve.begin(), halve.end());
    halve.erase(std::unique(halve.begin(), halve.end()), halve.end());
    for (const auto& s : halve) add_inner(0.5 * (points_[s[0]].p + points_[s[1]].p));
    return !halve.empty();
  }

  double known_bound(const std::array<int, 3>& t) {
    if (collapsed(t)) return 0.0;
    const auto [at, fresh] = known_bounds_.try_emplace(t, 0.0);
    if (fresh) at->second = bound(t).deviation;
    return at->second;
  }

  // Halves the side that deviates most. Sides on edges are the neighbours' too: only when they must be.
  void improve(const std::array<int, 3>& t, double limit, std::vector<std::array<int, 2>>& halve) {
    const TriangleBound b = bound(t);
    int worst = -1;
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], c = t[(k + 1) % 3];
      const auto side = boundary_.find({std::min(a, c), std::max(a, c)});
      if (side != boundary_.end()) {
        if (b.side[k] <= kSideShare * limit) continue;
        const auto& edge = side_edge_[side->second];
        if (edge[0] >= 0) {
          out_.split.push_back(edge);
          return;
        }
        continue;
      }
      if (worst < 0 || b.side[k] > b.side[worst]) worst = k;
    }
    if (worst < 0) return;
    const int a = t[worst], c = t[(worst + 1) % 3];
    halve.push_back({std::min(a, c), std::max(a, c)});
  }

  void take() {
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const auto& t = triangles_[i];
      if (collapsed(t)) continue;
      std::array<int, 3> k = t;
      if (face_.reversed) std::swap(k[1], k[2]);
      out_.triangles.push_back({points_[k[0]].vertex, points_[k[1]].vertex, points_[k[2]].vertex});
      out_.corner_uv.push_back({chart_.to_face(points_[k[0]].p), chart_.to_face(points_[k[1]].p),
                                chart_.to_face(points_[k[2]].p)});
      out_.deviation.push_back(bounds_[i] + corner_gap(t));
    }
    if (out_.triangles.empty()) out_.failure = "its loops enclose nothing";
  }

  const NurbsStore& store_;
  const nurbs::Face& face_;
  const Chart& chart_;
  const FacePolygon& polygon_;
  const EdgeLimits& limits_;
  std::unique_ptr<CurvatureTree> tree_;
  dvec2 scale_{1.0};
  std::map<std::array<double, 2>, int> known_;  // places in the chart
  std::vector<Node> points_;
  std::vector<std::array<int, 2>> sides_;
  std::vector<std::array<std::int32_t, 2>> side_edge_;
  std::vector<std::array<int, 3>> triangles_;
  std::map<std::array<int, 2>, int> boundary_;  // side by its ends, the lower first
  std::map<std::array<int, 3>, double> known_bounds_;
  std::vector<double> bounds_;
  FaceMesh out_;
};

}  // namespace

FaceMesh mesh_face(const NurbsStore& store, std::int32_t face, const Chart& chart, const FacePolygon& polygon,
                   const EdgeLimits& limits, const FaceHints& hints) {
  return FaceMesher(store, face, chart, polygon, limits).run(hints);
}

}  // namespace trimray::tess
