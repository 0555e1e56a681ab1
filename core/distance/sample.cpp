#include "core/distance/sample.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/distance/edge_leaf.h"
#include "core/distance/random.h"
#include "core/nurbs/knot_vector.h"
#include "core/nurbs/spline.h"
#include "core/nurbs/surface_form.h"
#include "core/nurbs/trim.h"
#include "core/trace/triangle.h"

namespace trimray::distance {

using nurbs::Coverage;
using nurbs::NurbsStore;

namespace {

constexpr int kMaxSpans = 24;    // cells along one direction before the loops are looked at
constexpr int kMaxCells = 1024;  // of one face
constexpr double kMixed = 0.25;  // share of the area that may stay in cells that the loops cross
constexpr int kAttempts = 400;   // a point
constexpr int kLeastAttempts = 20000;
constexpr int kMaxRestarts = 40;
constexpr double kMargin = 1.25;  // by which the area of a cell is taken for larger than its largest sample
constexpr int kGrid = 4;
constexpr int kPathSteps = 64;  // a piece

struct Cell {
  Box2 uv;
  double most = 0.0;  // |S_u x S_v| is at most this, as far as is known
  bool mixed = false;
  double weight() const { return most * uv.extent().x * uv.extent().y; }
};

double stretch(const nurbs::SurfaceView& surface, const dvec2& uv) {
  const nurbs::SurfacePoint s = nurbs::evaluate(surface, uv);
  return glm::length(glm::cross(s.du, s.dv));
}

// The cells of one face's uv box that are not outside of its loops: points are thrown into them and kept with
// the probability that makes them even on the surface.
class FaceCells {
 public:
  FaceCells(const NurbsStore& store, const nurbs::TrimIndex& trims, std::int32_t face)
      : store_(store), trims_(trims), index_(face), face_(store.faces[face]) {
    if (face_.status != nurbs::FaceStatus::kOk || face_.surface < 0 || face_.is_mesh() ||
        face_.uv_box.empty() || !std::isfinite(face_.uv_box.diagonal()))
      return;
    surface_ = nurbs::view(store, store.surfaces[face_.surface]);
    const nurbs::Surface& s = *surface_.surface;
    const auto us = stops(surface_.knots_u, s.degree_u, face_.uv_box.lower.x, face_.uv_box.upper.x),
               vs = stops(surface_.knots_v, s.degree_v, face_.uv_box.lower.y, face_.uv_box.upper.y);
    for (std::size_t i = 0; i + 1 < us.size(); ++i)
      for (std::size_t j = 0; j + 1 < vs.size(); ++j) add({{us[i], vs[j]}, {us[i + 1], vs[j + 1]}});
    refine();
  }

  // Appends points; the attempts' random numbers come from the key.
  void draw(int count, const RandomKey& key, std::vector<dvec2>& out) {
    const std::size_t first = out.size();
    for (int restart = 0; restart < kMaxRestarts; ++restart) {
      out.resize(first);
      if (attempt(count, key.with(restart), out)) return;
    }
  }

 private:
  static std::vector<double> stops(std::span<const double> knots, int degree, double a, double b) {
    std::vector<double> all{a};
    for (const double k : nurbs::distinct_knots(knots, degree))
      if (k > all.back() && k < b) all.push_back(k);
    all.push_back(b);
    const std::size_t spans = all.size() - 1, stride = (spans + kMaxSpans - 1) / kMaxSpans;
    std::vector<double> kept;
    for (std::size_t i = 0; i < spans; i += stride) kept.push_back(all[i]);
    kept.push_back(b);
    return kept;
  }

  void add(const Box2& uv) {
    Cell cell{uv};
    if (!face_.iso_rectangle) {
      const Coverage coverage = trims_.coverage(index_, uv);
      if (coverage == Coverage::kOutside) return;
      cell.mixed = coverage == Coverage::kMixed;
    }
    for (int i = 0; i <= kGrid; ++i)
      for (int j = 0; j <= kGrid; ++j) {
        const double x = stretch(surface_, uv.lower + uv.extent() * dvec2(i, j) / double(kGrid));
        if (x > cell.most) cell.most = x;
      }
    cell.most *= kMargin;
    if (cell.weight() > 0.0 && std::isfinite(cell.weight())) cells_.push_back(cell);
  }

  // Quarters the largest cells that the loops cross until little is left in such.
  void refine() {
    const auto smaller = [](const Cell& a, const Cell& b) {
      return (a.mixed ? a.weight() : 0.0) < (b.mixed ? b.weight() : 0.0);
    };
    std::make_heap(cells_.begin(), cells_.end(), smaller);
    double all = 0.0, mixed = 0.0;
    for (const Cell& c : cells_) all += c.weight(), mixed += c.mixed ? c.weight() : 0.0;
    int quartered = 0;
    while (!cells_.empty() && cells_.front().mixed && mixed > kMixed * all && cells_.size() < kMaxCells &&
           quartered++ < kMaxCells) {
      std::pop_heap(cells_.begin(), cells_.end(), smaller);
      const Cell cell = cells_.back();
      cells_.pop_back();
      all -= cell.weight(), mixed -= cell.weight();
      const dvec2 middle = cell.uv.center();
      for (int k = 0; k < 4; ++k) {
        const std::size_t before = cells_.size();
        add({{k & 1 ? middle.x : cell.uv.lower.x, k & 2 ? middle.y : cell.uv.lower.y},
             {k & 1 ? cell.uv.upper.x : middle.x, k & 2 ? cell.uv.upper.y : middle.y}});
        if (cells_.size() == before) continue;
        all += cells_.back().weight(), mixed += cells_.back().mixed ? cells_.back().weight() : 0.0;
        std::push_heap(cells_.begin(), cells_.end(), smaller);
      }
    }
  }

  // False where a cell turned out to be stretched more than was known: all must be drawn anew.
  bool attempt(int count, const RandomKey& key, std::vector<dvec2>& out) {
    if (cells_.empty()) return true;
    std::vector<double> sums(cells_.size());
    std::transform_inclusive_scan(cells_.begin(), cells_.end(), sums.begin(), std::plus<>(),
                                  [](const Cell& c) { return c.weight(); });
    const std::int64_t attempts = std::max<std::int64_t>(kLeastAttempts, std::int64_t{kAttempts} * count);
    int drawn = 0;
    for (std::int64_t i = 0; i < attempts && drawn < count; ++i) {
      const std::uint64_t k = 4 * static_cast<std::uint64_t>(i);
      const auto at = std::upper_bound(sums.begin(), sums.end(), key.unit(k) * sums.back()) - sums.begin();
      Cell& cell = cells_[std::min<std::size_t>(at, cells_.size() - 1)];
      const dvec2 uv = cell.uv.lower + cell.uv.extent() * dvec2(key.unit(k + 1), key.unit(k + 2));
      if (cell.mixed && !trims_.inside(index_, uv)) continue;
      const double x = stretch(surface_, uv);
      if (x > cell.most && std::isfinite(x)) {
        cell.most = kMargin * x;
        return false;
      }
      if (!(key.unit(k + 3) * cell.most < x)) continue;
      out.push_back(uv), ++drawn;
    }
    return true;
  }

  const NurbsStore& store_;
  const nurbs::TrimIndex& trims_;
  const std::int32_t index_;
  const nurbs::Face& face_;
  nurbs::SurfaceView surface_;
  std::vector<Cell> cells_;
};

// Points of a prototype's face in one instance.
struct Drawn {
  std::vector<dvec3> point, normal;
  std::vector<dvec2> uv;
};

void draw_triangles(const NurbsStore& store, const nurbs::Face& face, int count, const RandomKey& key,
                    Drawn& out) {
  std::vector<double> sums;
  double sum = 0.0;
  const auto corner = [&](std::int32_t t, int c) { return store.mesh_vertices[store.mesh_triangles[t][c]]; };
  for (std::int32_t t = face.triangles.begin; t < face.triangles.end; ++t) {
    const double area = glm::length(glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)));
    if (std::isfinite(area)) sum += area;
    sums.push_back(sum);
  }
  if (!(sum > 0.0) || !std::isfinite(sum)) return;
  for (int i = 0; i < count; ++i) {
    const auto at = std::upper_bound(sums.begin(), sums.end(), key.unit(3 * i) * sum) - sums.begin();
    const std::int32_t t =
        face.triangles.begin + static_cast<std::int32_t>(std::min<std::size_t>(at, sums.size() - 1));
    double b = key.unit(3 * i + 1), c = key.unit(3 * i + 2);
    if (b + c > 1.0) b = 1.0 - b, c = 1.0 - c;
    const dvec3 p[3] = {corner(t, 0), corner(t, 1), corner(t, 2)};
    out.point.push_back(p[0] + b * (p[1] - p[0]) + c * (p[2] - p[0]));
    out.normal.push_back(trace::triangle_normal(p[0], p[1], p[2]));
    out.uv.emplace_back(b, c);
  }
}

void draw_face(const NurbsStore& store, std::int32_t index, FaceCells& cells, int count, const RandomKey& key,
               Drawn& out) {
  const nurbs::Face& face = store.faces[index];
  if (face.status != nurbs::FaceStatus::kOk || face.surface < 0) return;
  if (face.is_mesh()) return draw_triangles(store, face, count, key, out);
  cells.draw(count, key, out.uv);
  for (const dvec2& uv : out.uv) {
    const nurbs::SurfacePoint s = nurbs::evaluate(store, store.surfaces[face.surface], uv);
    const dvec3 normal = glm::normalize(glm::cross(s.du, s.dv));
    out.point.push_back(s.p), out.normal.push_back(face.reversed ? -normal : normal);
  }
}

void check(const SampleOptions& options) {
  if (options.count < 0) throw ArgumentError("the number of points must not be negative");
}

}  // namespace

FaceSamples sample_faces(const NurbsStore& store, const SampleOptions& options) {
  check(options);
  const nurbs::TrimIndex trims(store, options.threads);
  // By face of each prototype, the instances in turn: they share the cells.
  std::vector<std::vector<std::int32_t>> instances(store.prototypes.size());
  for (std::size_t i = 0; i < store.instances.size(); ++i)
    instances[store.instances[i].prototype].push_back(static_cast<std::int32_t>(i));
  std::vector<std::vector<Drawn>> drawn(store.faces.size());
  const RandomKey key(options.seed);
  parallel_ranges(store.faces.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const auto& placed = instances[store.faces[f].prototype];
      if (placed.empty()) continue;
      const FaceCells cells(store, trims, static_cast<std::int32_t>(f));
      for (const std::int32_t i : placed) {
        FaceCells own = cells;
        draw_face(store, static_cast<std::int32_t>(f), own, options.count, key.with(f).with(i),
                  drawn[f].emplace_back());
      }
    }
  });
  FaceSamples out;
  std::vector<std::size_t> turn(store.faces.size(), 0);
  for (std::size_t i = 0; i < store.instances.size(); ++i) {
    const nurbs::Instance& instance = store.instances[i];
    const dmat3 across = glm::transpose(glm::inverse(instance.placement.linear));
    const nurbs::Range& faces = store.prototypes[instance.prototype].faces;
    for (std::int32_t f = faces.begin; f < faces.end; ++f) {
      if (turn[f] >= drawn[f].size()) continue;
      const Drawn& d = drawn[f][turn[f]++];
      for (std::size_t k = 0; k < d.point.size(); ++k) {
        out.point.push_back(instance.placement.point(d.point[k]));
        out.normal.push_back(glm::normalize(across * d.normal[k]));
        out.uv_face.push_back(d.uv[k]);
        out.face.push_back(f), out.instance.push_back(static_cast<std::int32_t>(i));
      }
    }
  }
  return out;
}

namespace {

// One edge's path as a polyline with the length up to each point.
class PathLength {
 public:
  PathLength(const NurbsStore& store, const nurbs::Edge& edge) : store_(store), edge_(edge) {
    lengths_.push_back(0.0);
    dvec3 last(0.0);
    for (int i = 0; i <= kPathSteps * edge.pieces.size(); ++i) {
      const dvec3 p = at(static_cast<double>(i) / kPathSteps);
      if (i > 0) lengths_.push_back(lengths_.back() + glm::distance(p, last));
      last = p;
    }
  }
  double length() const { return lengths_.back(); }
  dvec3 at_length(double length) const {
    const auto above = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, length);
    const double before = *(above - 1), step = *above - before;
    const double part = step > 0.0 ? std::clamp((length - before) / step, 0.0, 1.0) : 0.0;
    return at((static_cast<double>(above - 1 - lengths_.begin()) + part) / kPathSteps);
  }

 private:
  dvec3 at(double s) const {
    const int k = std::clamp(static_cast<int>(s), 0, edge_.pieces.size() - 1);
    const nurbs::Range& ctrl = store_.edge_pieces[edge_.pieces.begin + k].ctrl;
    return nurbs::project(nurbs::bezier_point(&store_.edge_ctrl_h[ctrl.begin], ctrl.size() - 1, s - k));
  }
  const NurbsStore& store_;
  const nurbs::Edge& edge_;
  std::vector<double> lengths_;
};

}  // namespace

EdgeSamples sample_edges(const NurbsStore& store, const SampleOptions& options) {
  check(options);
  EdgeSamples out;
  const RandomKey key(options.seed);
  for (std::size_t i = 0; i < store.instances.size(); ++i) {
    const nurbs::Instance& instance = store.instances[i];
    const nurbs::Range& edges = store.prototypes[instance.prototype].edges;
    for (std::int32_t e = edges.begin; e < edges.end; ++e) {
      const nurbs::Edge& edge = store.edges[e];
      if (!is_used(store, edge)) continue;
      const auto add = [&](const dvec3& p) {
        if (!std::isfinite(p.x + p.y + p.z)) return;
        out.point.push_back(instance.placement.point(p));
        out.edge.push_back(e), out.instance.push_back(static_cast<std::int32_t>(i));
      };
      if (edge.pieces.size() == 0) {
        if (options.count > 0 && edge.vertex[0] >= 0) add(store.vertices[edge.vertex[0]].point);
        continue;
      }
      const PathLength path(store, edge);
      if (!std::isfinite(path.length())) continue;
      const RandomKey own = key.with(e).with(i);
      const int count = path.length() > 0.0 ? options.count : std::min(options.count, 1);
      for (int k = 0; k < count; ++k) add(path.at_length(path.length() * (k + own.unit(k)) / count));
    }
  }
  return out;
}

}  // namespace trimray::distance
