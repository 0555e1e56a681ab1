#include "core/trace/edge_rule_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/nurbs/trim_bezier.h"

namespace trimray::trace {
namespace {

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

float round_down(double x) { return std::nextafter(static_cast<float>(x), -INFINITY); }
float round_up(double x) { return std::nextafter(static_cast<float>(x), INFINITY); }

}  // namespace

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
    const std::span<const dvec4> ctrl_h(&paths_->ctrl_h[piece.ctrl],
                                        static_cast<std::size_t>(piece.degree) + 1);
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
    const PathPiece& piece =
        paths_->pieces[s.piece >= 0 ? s.piece : edge.piece + (at_end ? edge.piece_count - 1 : 0)];
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
