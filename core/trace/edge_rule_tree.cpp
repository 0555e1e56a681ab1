#include "core/trace/edge_rule_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/nurbs/trim_bezier.h"

namespace trimray::trace {
namespace {

// A stretch is halved while it bends away from its chord by more than this part of its length (and by
// more than the band) ...
constexpr double kBend = 0.02;
// ... or is longer than this part of the whole, so that slanting boxes stay small ...
constexpr double kLongest = 1.0 / 16.0;
// ... at most this often.
constexpr int kMaxHalvings = 5;

// Four floats in the compiler's own vector type.
typedef float Float4 __attribute__((vector_size(16)));
typedef std::int32_t Int4 __attribute__((vector_size(16)));

Float4 all4(float x) { return Float4{x, x, x, x}; }
Float4 load4(const float* p) {
  Float4 v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
Float4 max4(Float4 a, Float4 b) { return a > b ? a : b; }
Float4 min4(Float4 a, Float4 b) { return a < b ? a : b; }
unsigned bits4(Int4 mask) {
  const Int4 bit = mask & Int4{1, 2, 4, 8};
  std::uint64_t pair[2];
  std::memcpy(pair, &bit, sizeof pair);
  const std::uint64_t both = pair[0] | pair[1];
  return static_cast<unsigned>(both | both >> 32);
}

dvec3 project(dvec4 h) { return dvec3(h) / h.w; }

double distance_to_chord(dvec3 p, dvec3 a, dvec3 b) {
  const dvec3 d = b - a;
  const double l = glm::dot(d, d);
  const double s = l > 0.0 ? std::clamp(glm::dot(p - a, d) / l, 0.0, 1.0) : 0.0;
  return glm::length(a + s * d - p);
}

float round_down(double x) { return std::nextafter(static_cast<float>(x), -INFINITY); }
float round_up(double x) { return std::nextafter(static_cast<float>(x), INFINITY); }

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

void EdgeTree::add_stretches(std::int32_t edge, std::int32_t piece, const std::vector<dvec4>& ctrl_h, double s0,
                             double s1, int depth) {
  Stretch stretch;
  stretch.a = project(ctrl_h.front()), stretch.b = project(ctrl_h.back());
  double bend = 0.0;
  for (const dvec4& c : ctrl_h) bend = std::max(bend, distance_to_chord(project(c), stretch.a, stretch.b));
  const double band = paths_->edges[edge].band, length = glm::length(stretch.b - stretch.a);
  if (depth < kMaxHalvings && (bend > std::max(kBend * length, band) || length > kLongest * paths_->diagonal)) {
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

// Splits [begin, end) where the surface area heuristic over 16 bins says, halves it where that says nothing.
// The order of equal elements never depends on anything but their indices.
namespace {

struct Split {
  std::size_t begin, end;
  Box3 box;
};

double half_area(const Box3& b) {
  const dvec3 e = glm::max(b.extent(), dvec3(0.0));
  return e.x * e.y + e.y * e.z + e.z * e.x;
}

}  // namespace

std::int32_t EdgeTree::build(std::vector<std::int32_t>& order, std::size_t begin, std::size_t end) {
  constexpr std::size_t kLeafSize = 2;
  const auto box_of = [&](std::size_t from, std::size_t to) {
    Box3 box;
    for (std::size_t i = from; i < to; ++i) box.add(stretch_box(stretches_[order[i]]));
    return box;
  };
  const auto split = [&](const Split& part) {
    Box3 centers;
    for (std::size_t i = part.begin; i < part.end; ++i) {
      const Stretch& s = stretches_[order[i]];
      centers.add(0.5 * (s.a + s.b));
    }
    constexpr int kBins = 16;
    double best = kInf;
    int best_axis = -1, best_bin = 0;
    const auto bin_of = [&](std::int32_t i, int axis) {
      const Stretch& s = stretches_[i];
      const double x = 0.5 * (s.a[axis] + s.b[axis]) - centers.lower[axis];
      return std::min(kBins - 1, static_cast<int>(kBins * (x / centers.extent()[axis])));
    };
    for (int axis = 0; axis < 3; ++axis) {
      if (!(centers.extent()[axis] > 0.0)) continue;
      std::array<Box3, kBins> boxes;
      std::array<std::size_t, kBins> counts{};
      for (std::size_t i = part.begin; i < part.end; ++i) {
        const int b = bin_of(order[i], axis);
        boxes[b].add(stretch_box(stretches_[order[i]])), ++counts[b];
      }
      std::array<double, kBins> right_cost{};
      Box3 sum;
      std::size_t count = 0;
      for (int b = kBins - 1; b > 0; --b) {
        if (counts[b]) sum.add(boxes[b]);
        count += counts[b];
        right_cost[b] = count ? half_area(sum) * static_cast<double>(count) : kInf;
      }
      sum = Box3(), count = 0;
      for (int b = 0; b + 1 < kBins; ++b) {
        if (counts[b]) sum.add(boxes[b]);
        count += counts[b];
        const double cost = count ? half_area(sum) * static_cast<double>(count) + right_cost[b + 1] : kInf;
        if (cost < best) best = cost, best_axis = axis, best_bin = b;
      }
    }
    std::size_t cut = (part.begin + part.end) / 2;
    if (best_axis >= 0) {
      const auto at = std::stable_partition(order.begin() + part.begin, order.begin() + part.end,
                                            [&](std::int32_t i) { return bin_of(i, best_axis) <= best_bin; });
      cut = static_cast<std::size_t>(at - order.begin());
    }
    return std::array<Split, 2>{Split{part.begin, cut, box_of(part.begin, cut)},
                                Split{cut, part.end, box_of(cut, part.end)}};
  };

  const auto index = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  std::vector<Split> parts{{begin, end, box_of(begin, end)}};
  while (parts.size() < kWidth) {
    // The largest part that is worth splitting.
    int widest = -1;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i].end - parts[i].begin > kLeafSize &&
          (widest < 0 || half_area(parts[i].box) > half_area(parts[widest].box)))
        widest = static_cast<int>(i);
    if (widest < 0) break;
    const auto halves = split(parts[widest]);
    parts[widest] = halves[0];
    parts.push_back(halves[1]);
  }
  Node node;
  for (int c = 0; c < kWidth; ++c) {
    for (int axis = 0; axis < 3; ++axis) node.lower[axis][c] = INFINITY, node.upper[axis][c] = -INFINITY;
    node.child[c] = ~0;
    if (c >= static_cast<int>(parts.size())) continue;
    const Split& part = parts[c];
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

template <typename Visit>
bool EdgeTree::traverse(const Ray& ray, const RayFrame& f, const Visit& visit) const {
  if (nodes_.empty() || glm::dot(f.org, f.org) > sphere_radius_ * sphere_radius_) return false;
  float org[3], inv[3], t_near, t_far;
  bool negative[3];
  for (int axis = 0; axis < 3; ++axis) {
    org[axis] = static_cast<float>(f.org[axis]);
    const float d = static_cast<float>(f.dir[axis]);
    // A direction across the axis: huge, not infinite, so that 0 * inf never comes up.
    inv[axis] = 1.0f / (std::abs(d) < 1e-18f ? std::copysign(1e-18f, d) : d);
    negative[axis] = inv[axis] < 0.0f;
  }
  const double reach = sphere_radius_ + float_margin_;
  t_near = round_down(std::max(ray.tmin - f.t_shift - float_margin_ - sphere_radius_ * 1e-6, -reach));
  t_far = round_up(std::min(ray.tmax - f.t_shift + float_margin_ + sphere_radius_ * 1e-6, reach));
  if (!(t_near <= t_far)) return false;

  const Float4 ox = all4(org[0]), oy = all4(org[1]), oz = all4(org[2]), t_first = all4(t_near);
  const Float4 ix = all4(inv[0]), iy = all4(inv[1]), iz = all4(inv[2]), t_last = all4(t_far);
  constexpr int kStack = 8 * 64;
  std::int32_t stack[kStack];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    const float* near_x = negative[0] ? node.upper[0] : node.lower[0];
    const float* far_x = negative[0] ? node.lower[0] : node.upper[0];
    const float* near_y = negative[1] ? node.upper[1] : node.lower[1];
    const float* far_y = negative[1] ? node.lower[1] : node.upper[1];
    const float* near_z = negative[2] ? node.upper[2] : node.lower[2];
    const float* far_z = negative[2] ? node.lower[2] : node.upper[2];
    unsigned hit = 0;
    for (int half = 0; half < kWidth; half += 4) {
      const Float4 nx = (load4(near_x + half) - ox) * ix, fx = (load4(far_x + half) - ox) * ix;
      const Float4 ny = (load4(near_y + half) - oy) * iy, fy = (load4(far_y + half) - oy) * iy;
      const Float4 nz = (load4(near_z + half) - oz) * iz, fz = (load4(far_z + half) - oz) * iz;
      const Float4 first = max4(max4(nx, ny), max4(nz, t_first)), last = min4(min4(fx, fy), min4(fz, t_last));
      hit |= bits4(first <= last) << half;
    }
    for (; hit != 0; hit &= hit - 1) {
      const int i = std::countr_zero(hit);
      const std::int32_t child = node.child[i];
      if (child >= 0) {
        if (top < kStack) stack[top++] = child;
        continue;
      }
      const std::int32_t code = ~child;
      for (std::int32_t k = 0; k < code % kWidth; ++k)
        if (visit(stretches_[code / kWidth + k])) return true;
    }
  }
  return false;
}

// Whether the ray's line comes within the stretch's radius of its chord.
bool EdgeTree::passes(const Stretch& s, const RayFrame& f) const {
  const dvec3 to_a = s.a - f.org, d = s.b - s.a;
  const dvec3 a = to_a - glm::dot(to_a, f.dir) * f.dir, e = d - glm::dot(d, f.dir) * f.dir;
  const double l = glm::dot(e, e);
  const double k = l > 0.0 ? std::clamp(-glm::dot(a, e) / l, 0.0, 1.0) : 0.0;
  const dvec3 gap = a + k * e;
  return glm::dot(gap, gap) <= s.radius * s.radius;
}

// The path's closest approach on the stretch; false when it stays outside the band or the ray's t range.
bool EdgeTree::closest(const Stretch& s, const Ray& ray, const RayFrame& f, NearEdge& found) const {
  const PathEdge& edge = paths_->edges[s.edge];
  const auto across = [&](dvec3 p) {
    const dvec3 d = p - f.org;
    const dvec3 a = d - glm::dot(d, f.dir) * f.dir;
    return glm::dot(a, a);
  };
  dvec3 point;
  double parameter;  // of the piece
  if (s.straight) {
    const dvec3 to_a = s.a - f.org, d = s.b - s.a;
    const dvec3 a = to_a - glm::dot(to_a, f.dir) * f.dir, e = d - glm::dot(d, f.dir) * f.dir;
    const double l = glm::dot(e, e);
    const double k = l > 0.0 ? std::clamp(-glm::dot(a, e) / l, 0.0, 1.0) : 0.5;
    point = s.a + k * d, parameter = s.s0 + k * (s.s1 - s.s0);
  } else {
    const PathPiece& piece = paths_->pieces[s.piece];
    const std::span<const dvec4> ctrl_h(&paths_->ctrl_h[piece.ctrl], static_cast<std::size_t>(piece.degree) + 1);
    const auto at = [&](double t) { return project(nurbs::evaluate_bezier<dvec4>(ctrl_h, t)); };
    // Golden section: on so flat a stretch the distance has one minimum.
    constexpr double kGolden = 0.6180339887498949;
    constexpr int kSteps = 40;
    double lower = s.s0, upper = s.s1;
    double m0 = upper - kGolden * (upper - lower), m1 = lower + kGolden * (upper - lower);
    double f0 = across(at(m0)), f1 = across(at(m1));
    for (int step = 0; step < kSteps; ++step) {
      if (f0 < f1) {
        upper = m1, m1 = m0, f1 = f0;
        m0 = upper - kGolden * (upper - lower), f0 = across(at(m0));
      } else {
        lower = m0, m0 = m1, f0 = f1;
        m1 = lower + kGolden * (upper - lower), f1 = across(at(m1));
      }
    }
    parameter = 0.5 * (lower + upper);
    double best = across(at(parameter));
    for (double end : {s.s0, s.s1})
      if (const double value = across(at(end)); value < best) best = value, parameter = end;
    point = at(parameter);
  }
  found.distance = std::sqrt(across(point));
  found.t = glm::dot(point - f.org, f.dir) + f.t_shift;
  found.edge = paths_->first_edge + s.edge;
  if (edge.piece_count == 0) {
    found.edge_t = 0.0;
  } else {
    const bool at_end = s.piece < 0 && s.s0 > 0.5;
    const PathPiece& piece = paths_->pieces[s.piece >= 0 ? s.piece : edge.piece + (at_end ? edge.piece_count - 1 : 0)];
    found.edge_t = piece.t0 + parameter * (piece.t1 - piece.t0);
  }
  if (!(found.distance <= edge.band)) return false;
  found.side = s.piece < 0 ? 0 : static_cast<std::int8_t>(paths_->side(s.edge, s.piece, parameter, f));
  return found.t >= ray.tmin - edge.band && found.t <= ray.tmax + edge.band;
}

void EdgeTree::near_edges(const Ray& ray, const RayFrame& frame, std::vector<NearEdge>& out) const {
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  traverse(ray, frame, [&](const Stretch& s) {
    NearEdge found;
    if (passes(s, frame) && closest(s, ray, frame, found)) out.push_back(found);
    return false;
  });
  if (out.size() - first < 2) return;
  std::sort(out.begin() + first, out.end(), [](const NearEdge& a, const NearEdge& b) {
    if (a.edge != b.edge) return a.edge < b.edge;
    if (a.edge_t != b.edge_t) return a.edge_t < b.edge_t;
    return a.distance != b.distance ? a.distance < b.distance : a.t < b.t;
  });
  // Neighbouring stretches find the same place, at their joint or within a band of it: the closer one stays.
  std::ptrdiff_t kept = first;
  for (std::ptrdiff_t i = first + 1; i < static_cast<std::ptrdiff_t>(out.size()); ++i) {
    const double band = paths_->edges[out[i].edge - paths_->first_edge].band;
    if (out[i].edge == out[kept].edge && std::abs(out[i].t - out[kept].t) <= 2.0 * band) {
      if (out[i].distance < out[kept].distance) out[kept] = out[i];
    } else {
      out[++kept] = out[i];
    }
  }
  out.resize(kept + 1);
}

bool EdgeTree::may_be_near(const Ray& ray, const RayFrame& frame) const {
  return traverse(ray, frame, [&](const Stretch& s) { return passes(s, frame); });
}

std::int64_t EdgeTree::bytes() const {
  return static_cast<std::int64_t>(stretches_.size() * sizeof(Stretch) + nodes_.size() * sizeof(Node));
}

}  // namespace trimray::trace
