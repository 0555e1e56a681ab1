#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/nurbs/trim_bezier.h"
#include "core/trace/edge_rule_tree.h"

namespace trimray::trace {
namespace {

// A stretch is halved while it bends away from its chord by more than this part of its length (and by
// more than the band) ...
constexpr double kBend = 0.02;
// ... or is longer than this part of the whole, so that slanting boxes stay small ...
constexpr double kLongest = 1.0 / 16.0;
// ... at most this often.
constexpr int kMaxHalvings = 5;

dvec3 project(dvec4 h) { return dvec3(h) / h.w; }

double distance_to_chord(dvec3 p, dvec3 a, dvec3 b) {
  const dvec3 d = b - a;
  const double l = glm::dot(d, d);
  const double s = l > 0.0 ? std::clamp(glm::dot(p - a, d) / l, 0.0, 1.0) : 0.0;
  return glm::length(a + s * d - p);
}

float round_down(double x) { return std::nextafter(static_cast<float>(x), -INFINITY); }
float round_up(double x) { return std::nextafter(static_cast<float>(x), INFINITY); }

double half_area(const Box3& b) {
  const dvec3 e = glm::max(b.extent(), dvec3(0.0));
  return e.x * e.y + e.y * e.z + e.z * e.x;
}

}  // namespace

EdgeTree::EdgeTree(const EdgePaths& paths) : paths_(&paths) {
  // Everything below happens within diagonal / 2 of the origin (frame.org included, or the sphere test ends
  // it): a float coordinate is wrong by 2^-25 of the diagonal, and a few such errors add up in the slab test.
  float_margin_ = 2e-6 * paths.diagonal;
  for (std::size_t e = 0; e < paths.edges.size(); ++e) {
    add_edge(paths, static_cast<std::int32_t>(e));
    sphere_radius_ = std::max(sphere_radius_, paths.edges[e].band);
  }
  sphere_radius_ += 0.5 * paths.diagonal * (1.0 + 1e-9);
  if (stretches_.empty()) return;
  std::vector<std::int32_t> order(stretches_.size());
  std::iota(order.begin(), order.end(), 0);
  build(order, 0, order.size());
  std::vector<Stretch> sorted;
  sorted.reserve(order.size());
  for (std::int32_t i : order) sorted.push_back(stretches_[i]);
  stretches_ = std::move(sorted);
}

void EdgeTree::add_edge(const EdgePaths& paths, std::int32_t edge) {
  const PathEdge& path = paths.edges[edge];
  if (path.joint_count < 2) return;
  const dvec3* joint = &paths.joints[path.joint];
  const auto link = [&](dvec3 a, dvec3 b, double s) {
    Stretch stretch;
    stretch.a = a, stretch.b = b, stretch.radius = path.band, stretch.edge = edge;
    stretch.s0 = stretch.s1 = s;
    stretch.straight = true;
    stretches_.push_back(stretch);
  };
  const std::int32_t last = path.joint_count - 1;
  if (path.piece_count == 0) return link(joint[0], joint[last], 0.0);
  if (joint[0] != joint[1]) link(joint[0], joint[1], 0.0);
  for (std::int32_t p = path.piece; p < path.piece + path.piece_count; ++p) {
    const PathPiece& piece = paths.pieces[p];
    const auto begin = paths.ctrl_h.begin() + piece.ctrl;
    add_stretches(edge, p, std::vector<dvec4>(begin, begin + piece.degree + 1), 0.0, 1.0, 0);
  }
  if (joint[last - 1] != joint[last]) link(joint[last - 1], joint[last], 1.0);
}

void EdgeTree::add_stretches(std::int32_t edge, std::int32_t piece, const std::vector<dvec4>& ctrl_h,
                             double s0, double s1, int depth) {
  Stretch stretch;
  stretch.a = project(ctrl_h.front()), stretch.b = project(ctrl_h.back());
  double bend = 0.0;
  for (const dvec4& c : ctrl_h) bend = std::max(bend, distance_to_chord(project(c), stretch.a, stretch.b));
  const double band = paths_->edges[edge].band, length = glm::length(stretch.b - stretch.a);
  if (depth < kMaxHalvings &&
      (bend > std::max(kBend * length, band) || length > kLongest * paths_->diagonal)) {
    std::vector<dvec4> left(ctrl_h.size()), right(ctrl_h.size());
    nurbs::split_bezier<dvec4>(ctrl_h, 0.5, left.data(), right.data());
    add_stretches(edge, piece, left, s0, 0.5 * (s0 + s1), depth + 1);
    add_stretches(edge, piece, right, 0.5 * (s0 + s1), s1, depth + 1);
    return;
  }
  stretch.radius = bend + band + 1e-15 * paths_->diagonal;
  stretch.s0 = s0, stretch.s1 = s1, stretch.edge = edge, stretch.piece = piece;
  stretch.straight = ctrl_h.size() == 2 && ctrl_h[0].w == ctrl_h[1].w;
  stretches_.push_back(stretch);
}

Box3 EdgeTree::stretch_box(const Stretch& s) const {
  Box3 box;
  box.add(s.a), box.add(s.b);
  box.dilate(s.radius + float_margin_);
  return box;
}

struct EdgeTree::Part {
  std::size_t begin = 0, end = 0;
  Box3 box;
};

EdgeTree::Part EdgeTree::make_part(const std::vector<std::int32_t>& order, std::size_t begin,
                                   std::size_t end) const {
  Part part{begin, end, {}};
  for (std::size_t i = begin; i < end; ++i) part.box.add(stretch_box(stretches_[order[i]]));
  return part;
}

// Cuts a part of the order in two where the surface area heuristic over 16 bins says, in the middle where
// that says nothing. The result depends on nothing but the boxes and their order.
std::size_t EdgeTree::cut(std::vector<std::int32_t>& order, const Part& part) const {
  constexpr int kBins = 16;
  const auto center = [&](std::int32_t i) { return 0.5 * (stretches_[i].a + stretches_[i].b); };
  Box3 centers;
  for (std::size_t i = part.begin; i < part.end; ++i) centers.add(center(order[i]));
  const auto bin_of = [&](std::int32_t i, int axis) {
    const double x = (center(i)[axis] - centers.lower[axis]) / centers.extent()[axis];
    return std::min(kBins - 1, static_cast<int>(kBins * x));
  };
  double best = kInf;
  int best_axis = -1, best_bin = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(centers.extent()[axis] > 0.0)) continue;
    std::array<Box3, kBins> boxes;
    std::array<std::size_t, kBins> counts{};
    for (std::size_t i = part.begin; i < part.end; ++i) {
      const int b = bin_of(order[i], axis);
      boxes[b].add(stretch_box(stretches_[order[i]])), ++counts[b];
    }
    // Cost of everything from bin b on, then of everything before.
    std::array<double, kBins> above{};
    Box3 sum;
    std::size_t count = 0;
    for (int b = kBins - 1; b > 0; --b) {
      if (counts[b]) sum.add(boxes[b]);
      count += counts[b];
      above[b] = count ? half_area(sum) * static_cast<double>(count) : kInf;
    }
    sum = Box3(), count = 0;
    for (int b = 0; b + 1 < kBins; ++b) {
      if (counts[b]) sum.add(boxes[b]);
      count += counts[b];
      const double cost = count ? half_area(sum) * static_cast<double>(count) + above[b + 1] : kInf;
      if (cost < best) best = cost, best_axis = axis, best_bin = b;
    }
  }
  if (best_axis < 0) return (part.begin + part.end) / 2;
  const auto at = std::stable_partition(order.begin() + static_cast<std::ptrdiff_t>(part.begin),
                                        order.begin() + static_cast<std::ptrdiff_t>(part.end),
                                        [&](std::int32_t i) { return bin_of(i, best_axis) <= best_bin; });
  return static_cast<std::size_t>(at - order.begin());
}

std::int32_t EdgeTree::build(std::vector<std::int32_t>& order, std::size_t begin, std::size_t end) {
  constexpr std::size_t kLeafSize = 2;
  const auto index = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  std::vector<Part> parts{make_part(order, begin, end)};
  while (parts.size() < kWidth) {
    // The largest part that is worth cutting.
    int widest = -1;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i].end - parts[i].begin > kLeafSize &&
          (widest < 0 || half_area(parts[i].box) > half_area(parts[widest].box)))
        widest = static_cast<int>(i);
    if (widest < 0) break;
    const Part whole = parts[widest];
    const std::size_t at = cut(order, whole);
    parts[widest] = make_part(order, whole.begin, at);
    parts.push_back(make_part(order, at, whole.end));
  }
  Node node;
  for (int c = 0; c < kWidth; ++c) {
    for (int axis = 0; axis < 3; ++axis) node.lower[axis][c] = INFINITY, node.upper[axis][c] = -INFINITY;
    node.child[c] = ~0;
    if (c >= static_cast<int>(parts.size())) continue;
    const Part& part = parts[c];
    for (int axis = 0; axis < 3; ++axis) {
      node.lower[axis][c] = round_down(part.box.lower[axis]);
      node.upper[axis][c] = round_up(part.box.upper[axis]);
    }
    const std::size_t count = part.end - part.begin;
    node.child[c] = count <= kLeafSize ? ~static_cast<std::int32_t>(part.begin * kWidth + count)
                                       : build(order, part.begin, part.end);
  }
  nodes_[index] = node;
  return index;
}

}  // namespace trimray::trace
