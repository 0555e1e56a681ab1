#include "core/trace/extent.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "core/base/parallel.h"
#include "core/nurbs/surface.h"
#include "core/trace/extent_samples.h"

namespace trimray::trace {

dvec3 edge_piece_point(const nurbs::NurbsStore& store, const nurbs::CurvePiece& piece, double t) {
  dvec4 net[32];  // degree <= 25 in OpenCascade
  const int count = std::min<int>(piece.ctrl.size(), 32);
  std::copy_n(&store.edge_ctrl_h[piece.ctrl.begin], count, net);
  for (int level = count - 1; level > 0; --level) {
    for (int i = 0; i < level; ++i) net[i] = (1.0 - t) * net[i] + t * net[i + 1];
  }
  return dvec3(net[0].x, net[0].y, net[0].z) / net[0].w;
}

namespace {

using nurbs::NurbsStore;

constexpr int kDirections = 1024;
constexpr double kAbsurd = 1e9;  // times the size of a model's median edge or face

// Largest d . C(t) near the sample number i of a piece: golden section, exact to rounding in the value.
dvec3 polish_piece(const NurbsStore& store, const Samples& s, std::size_t i, const dvec3& d) {
  const nurbs::CurvePiece& piece = store.edge_pieces[s.piece];
  const double steps = static_cast<double>(s.points.size() - 1);
  double a = std::max(0.0, (static_cast<double>(i) - 1.0) / steps),
         b = std::min(1.0, (static_cast<double>(i) + 1.0) / steps);
  constexpr double kGolden = std::numbers::phi - 1.0;
  const auto value = [&](double t) { return glm::dot(d, edge_piece_point(store, piece, t)); };
  double x = b - kGolden * (b - a), y = a + kGolden * (b - a), fx = value(x), fy = value(y);
  for (int k = 0; k < 48; ++k) {
    if (fx > fy)
      b = y, y = x, fy = fx, x = b - kGolden * (b - a), fx = value(x);
    else
      a = x, x = y, fx = fy, y = a + kGolden * (b - a), fy = value(y);
  }
  const dvec3 p = edge_piece_point(store, piece, 0.5 * (a + b));
  return glm::dot(d, p) > glm::dot(d, s.points[i]) ? p : s.points[i];
}

// Newton for the zero of the gradient of d . S, its Hessian by differences of the exact gradient. The result
// counts only where it lies inside the trim: elsewhere the maximum is on an edge.
dvec3 polish_face(const NurbsStore& store, const nurbs::TrimIndex& trims, const Samples& s, std::size_t i,
                  const dvec3& d) {
  const nurbs::Surface& surface = store.surfaces[store.faces[s.face].surface];
  const auto gradient = [&](const dvec2& at) {
    const nurbs::SurfacePoint p = nurbs::evaluate(store, surface, at);
    return dvec2(glm::dot(d, p.du), glm::dot(d, p.dv));
  };
  dvec2 uv = s.uv[i];
  const dvec2 h = 1e-5 * s.step;
  dvec3 best = s.points[i];
  for (int k = 0; k < 12; ++k) {
    const dvec2 g = gradient(uv);
    const dvec2 gu = (gradient(uv + dvec2(h.x, 0)) - gradient(uv - dvec2(h.x, 0))) / (2.0 * h.x);
    const dvec2 gv = (gradient(uv + dvec2(0, h.y)) - gradient(uv - dvec2(0, h.y))) / (2.0 * h.y);
    const double mixed = 0.5 * (gu.y + gv.x), det = gu.x * gv.y - mixed * mixed;
    dvec2 move(-(gv.y * g.x - mixed * g.y) / det, -(gu.x * g.y - mixed * g.x) / det);
    // Where the surface does not curve down in both directions, Newton would climb to a saddle: go uphill.
    if (!(det > 0.0 && gu.x < 0.0)) move = glm::sign(g) * 0.25 * s.step;
    move = glm::clamp(move, -s.step, s.step);
    if (!std::isfinite(move.x + move.y)) break;
    uv += move;
    if (!face_contains(trims, store, s.face, uv)) break;
    const dvec3 p = nurbs::evaluate(store, surface, uv).p;
    if (glm::dot(d, p) > glm::dot(d, best)) best = p;
    if (glm::all(glm::lessThan(glm::abs(move), 1e-9 * s.step))) break;
  }
  return best;
}

// A prototype as its samples. farthest() answers in the prototype's coordinates; d need not be of unit
// length.
class Outline {
 public:
  Outline(const NurbsStore& store, const nurbs::TrimIndex& trims, std::int32_t prototype, int threads)
      : store_(store), trims_(trims) {
    const nurbs::Prototype& p = store.prototypes[prototype];
    std::vector<std::int32_t> pieces, faces;
    for (std::int32_t e = p.edges.begin; e < p.edges.end; ++e) {
      if (!used(store.edges[e])) continue;
      for (std::int32_t i = store.edges[e].pieces.begin; i < store.edges[e].pieces.end; ++i)
        pieces.push_back(i);
    }
    for (std::int32_t f = p.faces.begin; f < p.faces.end; ++f) {
      if (store.faces[f].status == nurbs::FaceStatus::kOk && bulges(store, store.faces[f]))
        faces.push_back(f);
    }
    const std::size_t before = pieces.size() + faces.size();
    const std::vector<Neighbour> corners = mesh_corners(store, p.faces, threads);
    samples_.resize(before + (corners.size() + kCornersAtOnce - 1) / kCornersAtOnce);
    parallel_ranges(samples_.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        samples_[i] = i < pieces.size() ? sample_piece(store, pieces[i])
                      : i < before      ? sample_face(store, trims, faces[i - pieces.size()])
                                        : sample_corners(store, corners, i - before);
        for (const dvec3& point : samples_[i].points) samples_[i].box.add(point);
      }
    });
    std::erase_if(samples_, [](const Samples& s) { return s.points.empty(); });
    drop_absurd();
  }

  bool empty() const { return samples_.empty(); }

  // The farthest sample, moved uphill on its own face or edge: nearly farthest(), at a fraction of the cost.
  dvec3 nearly_farthest(const dvec3& d) const {
    const auto [s, i] = far_sample(d);
    return polish(*s, i, d);
  }

  dvec3 farthest(const dvec3& d) const {
    const auto [top, top_index] = far_sample(d);
    dvec3 best = top->points[top_index];
    const double length = glm::length(d);
    for (const Samples& s : samples_) {
      const double slack = s.gap * length;
      if (reach(s.box, d) + slack < glm::dot(d, best)) continue;
      // The samples that could climb beyond the best, the highest first; a few are enough.
      std::vector<std::pair<double, std::size_t>> starts;
      for (std::size_t i = 0; i < s.points.size(); ++i) {
        const double x = glm::dot(d, s.points[i]);
        if (x + slack >= glm::dot(d, best)) starts.push_back({-x, i});
      }
      const std::size_t few = std::min<std::size_t>(starts.size(), 6);
      std::partial_sort(starts.begin(), starts.begin() + static_cast<std::ptrdiff_t>(few), starts.end());
      for (std::size_t k = 0; k < few; ++k) {
        const dvec3 p = polish(s, starts[k].second, d);
        if (glm::dot(d, p) > glm::dot(d, best)) best = p;
      }
    }
    return best;
  }

 private:
  dvec3 polish(const Samples& s, std::size_t i, const dvec3& d) const {
    if (s.face != kNoFace) return polish_face(store_, trims_, s, i, d);
    return s.piece >= 0 ? polish_piece(store_, s, i, d) : s.points[i];
  }

  std::pair<const Samples*, std::size_t> far_sample(const dvec3& d) const {
    double most = -kInf;
    std::pair<const Samples*, std::size_t> best{&samples_.front(), 0};
    for (const Samples& s : samples_) {
      if (reach(s.box, d) <= most) continue;
      for (std::size_t i = 0; i < s.points.size(); ++i) {
        if (const double x = glm::dot(d, s.points[i]); x > most) most = x, best = {&s, i};
      }
    }
    return best;
  }

  bool used(const nurbs::Edge& edge) const {
    for (std::int32_t i = edge.coedges.begin; i < edge.coedges.end; ++i) {
      const std::int32_t face = store_.coedges[store_.edge_coedges[i]].face;
      if (store_.faces[face].status == nurbs::FaceStatus::kOk) return true;
    }
    return false;
  }

  // Leaves out what is so large or so far out that nothing else could be seen beside it: damage, not design.
  void drop_absurd() {
    if (samples_.empty()) return;
    const auto median = [&](const auto& value) {
      std::vector<double> values;
      for (const Samples& s : samples_) values.push_back(value(s.box));
      const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
      std::nth_element(values.begin(), middle, values.end());
      return *middle;
    };
    std::erase_if(samples_, [](const Samples& s) { return !std::isfinite(s.box.diagonal()); });
    if (samples_.empty()) return;
    const double limit = kAbsurd * median([](const Box3& b) { return b.diagonal(); });
    const dvec3 middle(median([](const Box3& b) { return b.center().x; }),
                       median([](const Box3& b) { return b.center().y; }),
                       median([](const Box3& b) { return b.center().z; }));
    if (!(limit > 0.0)) return;
    std::erase_if(samples_, [&](const Samples& s) {
      return !(glm::distance(s.box.center(), middle) + s.box.diagonal() <= limit);
    });
  }

  static double reach(const Box3& box, const dvec3& d) {
    return glm::dot(d, box.center()) + 0.5 * glm::dot(glm::abs(d), box.extent());
  }

  const NurbsStore& store_;
  const nurbs::TrimIndex& trims_;
  std::vector<Samples> samples_;
};

// Evenly spread over the sphere (Fibonacci lattice).
std::vector<dvec3> directions() {
  std::vector<dvec3> d;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, r = std::sqrt(1.0 - z * z);
    const double a = 2.0 * std::numbers::pi * (std::numbers::phi - 1.0) * i;
    d.push_back({r * std::cos(a), r * std::sin(a), z});
  }
  return d;
}

void keep_farthest(std::vector<dvec3>& points) {
  if (points.size() <= kDirections) return;
  std::vector<dvec3> kept, all = directions();
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 d(0.0);
    d[axis] = 1.0;
    all.push_back(d), all.push_back(-d);
  }
  // Coordinate by coordinate, which compilers turn into vectors.
  std::vector<double> x, y, z, height(points.size());
  for (const dvec3& p : points) x.push_back(p.x), y.push_back(p.y), z.push_back(p.z);
  for (const dvec3& d : all) {
    for (std::size_t i = 0; i < points.size(); ++i) height[i] = d.x * x[i] + d.y * y[i] + d.z * z[i];
    std::size_t best = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
      if (height[i] > height[best]) best = i;
    kept.push_back(points[best]);
  }
  points = std::move(kept);
}

}  // namespace

Extent model_extent(const NurbsStore& store, int threads) {
  const nurbs::TrimIndex trims(store, threads);
  Extent extent;
  std::vector<Outline> outlines;
  std::vector<std::vector<dvec3>> far(store.prototypes.size());
  const std::vector<dvec3> all = directions();
  for (std::size_t p = 0; p < store.prototypes.size(); ++p) {
    const Outline& outline = outlines.emplace_back(store, trims, static_cast<std::int32_t>(p), threads);
    if (outline.empty()) continue;
    far[p].resize(all.size());
    parallel_ranges(all.size(), 8, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) far[p][i] = outline.nearly_farthest(all[i]);
    });
  }
  // Many instances of an assembly are placed without turning: their six directions are asked for once.
  std::map<std::tuple<std::int32_t, double, double, double>, dvec3> known;
  for (const nurbs::Instance& instance : store.instances) {
    const auto p = static_cast<std::size_t>(instance.prototype);
    if (outlines[p].empty()) continue;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        const dmat3& m = instance.placement.linear;
        const dvec3 d = sign * dvec3(m[0][axis], m[1][axis], m[2][axis]);
        const auto [at, fresh] = known.try_emplace({instance.prototype, d.x, d.y, d.z});
        if (fresh) at->second = outlines[p].farthest(d);
        extent.bounds.add(instance.placement.point(at->second));
        extent.points.push_back(instance.placement.point(at->second));
      }
    }
    for (const dvec3& q : far[p]) extent.points.push_back(instance.placement.point(q));
  }
  keep_farthest(extent.points);
  return extent;
}

}  // namespace trimray::trace
