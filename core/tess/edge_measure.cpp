#include "core/tess/edge_measure.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/box.h"
#include "core/base/parallel.h"
#include "core/nurbs/spline.h"
#include "core/tess/mesh_measure.h"
#include "core/tess/mesh_sides.h"

namespace trimray::tess {
namespace {

using nurbs::NurbsStore;

constexpr int kSamples = 24;         // a piece, where the search for the closest point starts
constexpr double kOnEdge = 1e-8;     // of the mesh's diagonal: a vertex this near lies on the edge
constexpr double kAtEnd = 2e-7;      // the same for an edge's end: vertices so near to one another are one
constexpr double kSamePlace = 1e-9;  // of the number of pieces

double segment_distance(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 d = b - a;
  const double length = glm::dot(d, d);
  const double x = length > 0.0 ? std::clamp(glm::dot(p - a, d) / length, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + x * d);
}

// The exact curve of one edge, over [0, pieces].
class EdgePath {
 public:
  EdgePath(const NurbsStore& store, std::int32_t edge) : store_(store), pieces_(store.edges[edge].pieces) {
    for (int i = 0; i <= count() * kSamples; ++i) {
      samples_.push_back(point(double(i) / kSamples));
      box_.add(samples_.back());
      if (i > 0) length_ += glm::distance(samples_[i - 1], samples_[i]);
    }
    // The samples' box lacks at most the arcs' rise between them.
    box_.dilate(0.05 * box_.diagonal());
    for (const std::int32_t v : store.edges[edge].vertex)
      if (v >= 0) ends_.push_back(store.vertices[v].point);
    for (const dvec3& p : ends_) box_.add(p);
    closed_ = glm::distance(samples_.front(), samples_.back()) <= 1e-9 * box_.diagonal();
  }

  int count() const { return pieces_.size(); }
  const Box3& box() const { return box_; }
  double length() const { return length_; }
  bool closed() const { return closed_; }

  dvec3 point(double s) const {
    const int k = std::clamp(static_cast<int>(s), 0, count() - 1);
    const nurbs::CurvePiece& piece = store_.edge_pieces[pieces_.begin + k];
    return nurbs::project(
        nurbs::bezier_point(&store_.edge_ctrl_h[piece.ctrl.begin], piece.ctrl.size() - 1, s - k));
  }

  // Where p lies on the path; its distance from there. Vertices stand for the path's ends, to which straight
  // links lead.
  double closest(const dvec3& p, double& s) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < samples_.size(); ++i)
      if (glm::distance(p, samples_[i]) < glm::distance(p, samples_[best])) best = i;
    double lo = std::max(0.0, (double(best) - 1.0) / kSamples);
    double hi = std::min(double(count()), (double(best) + 1.0) / kSamples);
    const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
    double x = hi - ratio * (hi - lo), y = lo + ratio * (hi - lo);
    double fx = glm::distance(p, point(x)), fy = glm::distance(p, point(y));
    for (int i = 0; i < 60; ++i) {  // golden section
      if (fx <= fy)
        hi = y, y = x, fy = fx, x = hi - ratio * (hi - lo), fx = glm::distance(p, point(x));
      else
        lo = x, x = y, fx = fy, y = lo + ratio * (hi - lo), fy = glm::distance(p, point(y));
    }
    s = 0.5 * (lo + hi);
    double distance = glm::distance(p, point(s));
    for (const double end : {0.0, double(count())}) {
      const double d = glm::distance(p, point(end));
      if (d <= distance) s = end, distance = d;
    }
    if (ends_.size() == 2) {
      for (int k = 0; k < 2; ++k) {
        const double d = segment_distance(p, ends_[k], k == 0 ? samples_.front() : samples_.back());
        if (d < distance) s = k == 0 ? 0.0 : double(count()), distance = d;
      }
    }
    return distance;
  }

  // Does p lie on the path, or near one of its ends?
  bool holds(const dvec3& p, double on_path, double near_end, double& s) const {
    if (closest(p, s) <= on_path) return true;
    const double first = glm::distance(p, samples_.front()), last = glm::distance(p, samples_.back());
    if (std::min(first, last) > near_end) return false;
    s = first <= last ? 0.0 : double(count());
    return true;
  }

 private:
  const NurbsStore& store_;
  nurbs::Range pieces_;
  std::vector<dvec3> samples_;
  std::vector<dvec3> ends_;
  Box3 box_;
  double length_ = 0.0;
  bool closed_ = false;
};

// Sides where a face ends. Triangles around a pole share a place that has many uv, so a side is inside a
// face when the uv agree at one of its ends.
std::vector<BorderSide> border_sides(const TriMesh& mesh) {
  const std::vector<Side> sides = sorted_sides(mesh.vertices.size(), mesh.triangles);
  std::vector<BorderSide> result;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    const std::span<const Side> group(sides.data() + begin, end - begin);
    if (edge_use(group) == EdgeUse::kPaired && mesh.face[group[0].triangle] == mesh.face[group[1].triangle]) {
      const auto& a = mesh.corner_uv[group[0].triangle];
      const auto& b = mesh.corner_uv[group[1].triangle];
      const int i = group[0].corner, j = group[1].corner;
      if (a[i] == b[(j + 1) % 3] || a[(i + 1) % 3] == b[j]) return;
    }
    for (const Side& s : group) {
      BorderSide side;
      side.triangle = s.triangle, side.corner = s.corner, side.open = group.size() == 1;
      result.push_back(side);
    }
  });
  return result;
}

class Measurer {
 public:
  Measurer(const NurbsStore& store, const TriMesh& mesh, int points)
      : store_(store), mesh_(mesh), points_(points), drawn_(store.faces.size(), false) {
    Box3 box;
    for (const dvec3& p : mesh.vertices) box.add(p);
    near_ = kOnEdge * box.diagonal();
    result_.sides = border_sides(mesh);
    for (std::size_t i = 0; i < result_.sides.size(); ++i)
      by_face_[mesh.face[result_.sides[i].triangle]].push_back(i);
    for (const std::int32_t f : mesh.face) drawn_[f] = true;
    result_.length.assign(store.edges.size(), 0.0);
    result_.missing.assign(store.edges.size(), 0.0);
  }

  EdgeMeasure run(int threads) {
    // Faces in parallel: a side belongs to one face, an edge's sums are made afterwards.
    std::vector<std::int32_t> faces;
    for (const auto& [face, list] : by_face_) faces.push_back(face);
    parallel_ranges(faces.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) measure_face(faces[i]);
    });
    sum_up();
    return std::move(result_);
  }

 private:
  struct Use {
    std::int32_t edge = -1;
    bool forward = false, backward = false;  // ways in which sides may run along it
  };

  void measure_face(std::int32_t index) {
    const nurbs::Face& face = store_.faces[index];
    std::map<std::int32_t, Use> uses;
    for (std::int32_t l = face.loops.begin; l < face.loops.end; ++l) {
      const nurbs::Range range = store_.loops[l].coedges;
      for (std::int32_t c = range.begin; c < range.end; ++c) {
        const nurbs::CoEdge& coedge = store_.coedges[c];
        if (store_.edges[coedge.edge].pieces.size() == 0) continue;
        Use& use = uses[coedge.edge];
        use.edge = coedge.edge;
        (coedge.reversed != face.reversed ? use.backward : use.forward) = true;
      }
    }
    for (const auto& [edge, use] : uses) {
      const EdgePath path(store_, edge);
      // Vertices of edges that meet within their tolerances are one and stand where one of them says: at its
      // ends, an edge holds what is as near as that.
      double near = kAtEnd / kOnEdge * near_;
      for (const std::int32_t v : store_.edges[edge].vertex)
        if (v >= 0)
          near = std::max(near, 2.0 * std::max(store_.vertices[v].tolerance, store_.edges[edge].band));
      Box3 box = path.box();
      box.dilate(near);
      for (const std::size_t i : by_face_[index]) {
        BorderSide& side = result_.sides[i];
        const dvec3 a = start(side), b = stop(side);
        if (!box.contains(a) || !box.contains(b)) continue;
        BorderSide found = side;
        if (!path.holds(a, near_, near, found.from) || !path.holds(b, near_, near, found.to)) continue;
        if (!path.closed() && found.from == found.to) continue;
        choose_ends(path, use, found);
        compare(path, found);
        // Edges may run side by side: the nearer one it is.
        if (side.edge < 0 || found.side_to_edge < side.side_to_edge) found.edge = edge, side = found;
      }
    }
  }

  // On a closed edge the place where it begins is also where it ends.
  void choose_ends(const EdgePath& path, const Use& use, BorderSide& side) const {
    if (!path.closed()) return;
    const double n = path.count(), same = kSamePlace * n;
    const auto at_end = [&](double s) { return s <= same || s >= n - same; };
    std::vector<double> from{side.from}, to{side.to};
    if (at_end(side.from)) from = {0.0, n};
    if (at_end(side.to)) to = {0.0, n};
    double best = kInf;
    const dvec3 middle = 0.5 * (start(side) + stop(side));
    const double size = glm::distance(start(side), stop(side)) + path.box().diagonal();
    for (const double f : from) {
      for (const double t : to) {
        if (std::abs(f - t) <= same) continue;
        double cost = glm::distance(path.point(0.5 * (f + t)), middle);
        if (!(t > f ? use.forward : use.backward)) cost += 1e-6 * size;  // where both arcs are as near
        if (cost < best) best = cost, side.from = f, side.to = t;
      }
    }
  }

  void compare(const EdgePath& path, BorderSide& side) const {
    const dvec3 a = start(side), b = stop(side);
    std::vector<dvec3> arc;
    for (int k = 0; k <= 4 * points_; ++k)
      arc.push_back(path.point(side.from + (side.to - side.from) * k / (4.0 * points_)));
    side.edge_to_side = side.side_to_edge = 0.0;
    for (const dvec3& p : arc) side.edge_to_side = std::max(side.edge_to_side, segment_distance(p, a, b));
    for (int k = 0; k <= points_; ++k) {
      const dvec3 p = a + (b - a) * (double(k) / points_);
      double nearest = kInf;
      for (std::size_t i = 0; i + 1 < arc.size(); ++i)
        nearest = std::min(nearest, segment_distance(p, arc[i], arc[i + 1]));
      side.side_to_edge = std::max(side.side_to_edge, nearest);
    }
  }

  void sum_up() {
    std::vector<double> covered(store_.edges.size(), 0.0), uses(store_.edges.size(), 0.0);
    for (const BorderSide& s : result_.sides)
      if (s.edge >= 0) covered[s.edge] += std::abs(s.to - s.from);
    for (const nurbs::CoEdge& c : store_.coedges)
      if (c.edge >= 0 && c.face >= 0 && drawn_[c.face]) uses[c.edge] += 1.0;
    for (std::size_t e = 0; e < store_.edges.size(); ++e) {
      const int pieces = store_.edges[e].pieces.size();
      if (pieces == 0 || uses[e] == 0.0) continue;
      const double length = EdgePath(store_, static_cast<std::int32_t>(e)).length();
      result_.length[e] = uses[e] * length;
      result_.missing[e] = std::abs(uses[e] - covered[e] / pieces) * length;
    }
  }

  dvec3 start(const BorderSide& s) const { return mesh_.vertices[mesh_.triangles[s.triangle][s.corner]]; }
  dvec3 stop(const BorderSide& s) const {
    return mesh_.vertices[mesh_.triangles[s.triangle][(s.corner + 1) % 3]];
  }

  const NurbsStore& store_;
  const TriMesh& mesh_;
  int points_;
  double near_ = 0.0;
  std::vector<bool> drawn_;
  std::map<std::int32_t, std::vector<std::size_t>> by_face_;
  EdgeMeasure result_;
};

}  // namespace

EdgeMeasure measure_edges(const NurbsStore& store, const TriMesh& mesh, int points, int threads) {
  check_mesh_fits(store, mesh);
  return Measurer(store, mesh, std::max(points, 1)).run(threads);
}

}  // namespace trimray::tess
