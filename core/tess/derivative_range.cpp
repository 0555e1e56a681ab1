#include "core/tess/derivative_range.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace trimray::tess {

using nurbs::SurfaceKind;

namespace {

Interval cos_range(double a, double b) {
  constexpr double kPi = std::numbers::pi;
  const double p = std::cos(a), q = std::cos(b);
  Interval r{std::min(p, q), std::max(p, q)};
  if (std::floor(b / (2 * kPi)) >= std::ceil(a / (2 * kPi))) r.hi = 1.0;
  if (std::floor((b - kPi) / (2 * kPi)) >= std::ceil((a - kPi) / (2 * kPi))) r.lo = -1.0;
  return r;
}

Interval sin_range(double a, double b) {
  return cos_range(a - 0.5 * std::numbers::pi, b - 0.5 * std::numbers::pi);
}

// Homogeneous vectors over a patch.
struct Range4 {
  dvec4 lower{kInf}, upper{-kInf};
  void add(const dvec4& h) { lower = glm::min(lower, h), upper = glm::max(upper, h); }
  Box3 xyz() const { return {{lower.x, lower.y, lower.z}, {upper.x, upper.y, upper.z}}; }
  Interval w() const { return {lower.w, upper.w}; }
};

// The control points of the derivative of order (a, b), with respect to [0, 1]^2.
Range4 derivative_hull(const dvec4* net, int p, int q, int a, int b) {
  Range4 r;
  if (p < a || q < b) {
    r.add(dvec4(0.0));
    return r;
  }
  const double scale = (a == 0   ? 1.0
                        : a == 1 ? p
                                 : p * (p - 1.0)) *
                       (b == 0   ? 1.0
                        : b == 1 ? q
                                 : q * (q - 1.0));
  const int row = q + 1;
  for (int i = 0; i + a <= p; ++i)
    for (int j = 0; j + b <= q; ++j) {
      const dvec4* c = net + i * row + j;
      dvec4 d;
      if (a == 0 && b == 0)
        d = c[0];
      else if (a == 1 && b == 0)
        d = c[row] - c[0];
      else if (a == 0 && b == 1)
        d = c[1] - c[0];
      else if (a == 2)
        d = (c[2 * row] - c[row]) - (c[row] - c[0]);
      else if (b == 2)
        d = (c[2] - c[1]) - (c[1] - c[0]);
      else
        d = (c[row + 1] - c[1]) - (c[row] - c[0]);
      r.add(scale * d);
    }
  return r;
}

// The quotient rule on N / w. Interval arithmetic forgets that N and w vary together, and what it adds grows
// with |N / w|; so a reference that the derivative does not see is taken off first. With separable weights
// this may be any function of v alone for derivatives along u, and so on; otherwise it is one point.
class RationalRanges {
 public:
  RationalRanges(const dvec4* net, int p, int q) : net_(net), p_(p), q_(q) {
    Range4 w;
    for (int k = 0; k < (p + 1) * (q + 1); ++k) w.add(net[k]);
    inverse_ = {1.0 / w.upper.w, 1.0 / w.lower.w};
    for (int i = 0; i <= p; ++i)
      for (int j = 0; j <= q; ++j) {
        const double product = at(i, 0).w * at(0, j).w;
        if (std::abs(at(i, j).w * at(0, 0).w - product) > 1e-13 * product) separable_ = false;
      }
  }

  void along_u(Box3& uu, double& su) const {
    const dvec4* n = local([&](int, int j) { return point(p_ / 2, separable_ ? j : q_ / 2); });
    const Range4 hu = hull(n, 1, 0), huu = hull(n, 2, 0);
    const Box3 place = inverse_ * hull(n, 0, 0).xyz(), du = inverse_ * (hu.xyz() - hu.w() * place);
    uu = inverse_ * (huu.xyz() - (2.0 * hu.w()) * du - huu.w() * place);
    su = largest(du);
  }

  void along_v(Box3& vv, double& sv) const {
    const dvec4* n = local([&](int i, int) { return point(separable_ ? i : p_ / 2, q_ / 2); });
    const Range4 hv = hull(n, 0, 1), hvv = hull(n, 0, 2);
    const Box3 place = inverse_ * hull(n, 0, 0).xyz(), dv = inverse_ * (hv.xyz() - hv.w() * place);
    vv = inverse_ * (hvv.xyz() - (2.0 * hv.w()) * dv - hvv.w() * place);
    sv = largest(dv);
  }

  void mixed(Box3& uv) const {
    const dvec4* n = local([&](int i, int j) {
      const dvec3 middle = point(p_ / 2, q_ / 2);
      return separable_ ? point(i, q_ / 2) + (point(p_ / 2, j) - middle) : middle;
    });
    const Range4 hu = hull(n, 1, 0), hv = hull(n, 0, 1), huv = hull(n, 1, 1);
    const Box3 place = inverse_ * hull(n, 0, 0).xyz();
    const Box3 du = inverse_ * (hu.xyz() - hu.w() * place), dv = inverse_ * (hv.xyz() - hv.w() * place);
    uv = inverse_ * (huv.xyz() - hu.w() * dv - hv.w() * du - huv.w() * place);
  }

 private:
  const dvec4& at(int i, int j) const { return net_[i * (q_ + 1) + j]; }
  dvec3 point(int i, int j) const {
    const dvec4& h = at(i, j);
    return dvec3(h.x, h.y, h.z) / h.w;
  }
  Range4 hull(const dvec4* n, int a, int b) const { return derivative_hull(n, p_, q_, a, b); }

  // The net relative to a reference that is given by its own control points.
  template <typename Reference>
  const dvec4* local(const Reference& reference) const {
    thread_local std::vector<dvec4> n;
    n.resize(static_cast<std::size_t>(p_ + 1) * (q_ + 1));
    for (int i = 0; i <= p_; ++i)
      for (int j = 0; j <= q_; ++j) {
        const dvec4& h = at(i, j);
        n[static_cast<std::size_t>(i) * (q_ + 1) + j] = h - dvec4(h.w * reference(i, j), 0.0);
      }
    return n.data();
  }

  const dvec4* net_;
  int p_, q_;
  bool separable_ = true;
  Interval inverse_;
};

bool positive_weights(const dvec4* net, int count) {
  return std::all_of(net, net + count, [](const dvec4& h) { return h.w > 0.0; });
}

}  // namespace

DerivativeRange closed_form_range(const nurbs::Surface& s, const Box2& box) {
  DerivativeRange r;
  const Box3 zero{dvec3(0.0), dvec3(0.0)};
  r.uu = r.uv = r.vv = zero;
  r.su = r.sv = 1.0;
  if (s.kind == SurfaceKind::kPlane) return r;
  const Interval cu = cos_range(box.lower.x, box.upper.x), su = sin_range(box.lower.x, box.upper.x);
  const Box3 radial = cu * s.x_axis + su * s.y_axis, around = cu * s.y_axis + (-su) * s.x_axis;
  switch (s.kind) {
    case SurfaceKind::kCylinder:
      r.uu = -s.r1 * radial, r.su = std::abs(s.r1);
      break;
    case SurfaceKind::kCone: {
      const double a = s.r1 + box.lower.y * std::sin(s.semi_angle),
                   b = s.r1 + box.upper.y * std::sin(s.semi_angle);
      const Interval radius{std::min(a, b), std::max(a, b)};
      r.uu = (-radius) * radial, r.uv = std::sin(s.semi_angle) * around;
      r.su = radius.magnitude();
      break;
    }
    default: {  // sphere and torus: a tube of radius r about a circle of radius R
      const bool sphere = s.kind == SurfaceKind::kSphere;
      const double tube = sphere ? s.r1 : s.r2, ring = sphere ? 0.0 : s.r1;
      const Interval cv = cos_range(box.lower.y, box.upper.y), sv = sin_range(box.lower.y, box.upper.y);
      const Interval radius = Interval{ring, ring} + tube * cv;
      r.uu = (-radius) * radial;
      r.uv = (-tube * sv) * around;
      r.vv = (-tube * cv) * radial + (-tube * sv) * s.z_axis;
      r.su = radius.magnitude(), r.sv = std::abs(tube);
    }
  }
  return r;
}

DerivativeRange patch_range(const dvec4* net, int p, int q, dvec2 extent, bool rational) {
  DerivativeRange r;
  if (!rational) {
    r.uu = derivative_hull(net, p, q, 2, 0).xyz();
    r.uv = derivative_hull(net, p, q, 1, 1).xyz();
    r.vv = derivative_hull(net, p, q, 0, 2).xyz();
    r.su = largest(derivative_hull(net, p, q, 1, 0).xyz());
    r.sv = largest(derivative_hull(net, p, q, 0, 1).xyz());
  } else if (!positive_weights(net, (p + 1) * (q + 1))) {
    // The surface's domain has a margin, where extrapolated weights may fail: nothing is known there.
    const Box3 all{dvec3(-kInf), dvec3(kInf)};
    r.uu = r.uv = r.vv = all;
    r.su = r.sv = kInf;
    return r;
  } else {
    const RationalRanges ranges(net, p, q);
    ranges.along_u(r.uu, r.su), ranges.along_v(r.vv, r.sv), ranges.mixed(r.uv);
  }
  const dvec2 k = 1.0 / extent;
  r.uu = (k.x * k.x) * r.uu, r.uv = (k.x * k.y) * r.uv, r.vv = (k.y * k.y) * r.vv;
  r.su *= k.x, r.sv *= k.y;
  return r;
}

}  // namespace trimray::tess
