#include "core/trace/certificate.h"

#include <algorithm>
#include <cmath>

#include "core/nurbs/knot_vector.h"
#include "core/trace/patch_net.h"
#include "core/trace/patch_offset.h"

namespace trimray::trace {
namespace {

constexpr int kMaxNet = (nurbs::kMaxDegree + 1) * (nurbs::kMaxDegree + 1);

dvec3 xyz(const dvec4& h) { return dvec3(h.x, h.y, h.z); }

// Largest in-plane, normal and weight part over a control net.
struct Extent {
  double t = 0.0, n = 0.0, w = 0.0;
};

// Control net of a sub-patch over the extended leaf, about its own centre.
struct LocalNet {
  int du, dv;
  const dvec4* p;
  dvec3 normal;
  const dvec4& at(int i, int j) const { return p[i * (dv + 1) + j]; }

  // The (a, b)-th derivative's control net, per half width of the unextended leaf.
  Extent derivative(int a, int b) const {
    Extent e;
    const double per_half = 1.0 / (2.0 * kExtend);
    double factor = 1.0;
    for (int k = 0; k < a; ++k) factor *= (du - k) * per_half;
    for (int k = 0; k < b; ++k) factor *= (dv - k) * per_half;
    double t2 = 0.0;
    for (int i = 0; i + a <= du; ++i)
      for (int j = 0; j + b <= dv; ++j) {
        const dvec4 d = difference(i, j, a, b);
        const double n = glm::dot(xyz(d), normal);
        const dvec3 t = xyz(d) - n * normal;
        t2 = std::max(t2, glm::dot(t, t));
        e.n = std::max(e.n, std::fabs(n));
        e.w = std::max(e.w, std::fabs(d.w));
      }
    e.t = factor * std::sqrt(t2), e.n *= factor, e.w *= factor;
    return e;
  }

  // a + b <= 2.
  dvec4 difference(int i, int j, int a, int b) const {
    const dvec4* x = p + i * (dv + 1) + j;
    const int row = dv + 1;
    if (a == 0 && b == 0) return x[0];
    if (a == 1 && b == 0) return x[row] - x[0];
    if (a == 0 && b == 1) return x[1] - x[0];
    if (a == 1 && b == 1) return (x[row + 1] - x[row]) - (x[1] - x[0]);
    if (a == 2) return (x[2 * row] - x[row]) - (x[row] - x[0]);
    return (x[2] - x[1]) - (x[1] - x[0]);
  }
};

// Bounds of the projected surface's derivatives from those of the homogeneous net: S = P / w gives
// S_u = (P_u - S w_u) / w, S_uu = (P_uu - 2 S_u w_u - S w_uu) / w, and so on; part picks t or n.
struct Bends {
  double uu, uv, vv;
};

template <typename Part>
Bends bend(const Extent (&d)[3][3], double min_w, const Part& part) {
  const double s = part(d[0][0]) / min_w;
  const double su = (part(d[1][0]) + s * d[1][0].w) / min_w;
  const double sv = (part(d[0][1]) + s * d[0][1].w) / min_w;
  return {(part(d[2][0]) + 2.0 * su * d[1][0].w + s * d[2][0].w) / min_w,
          (part(d[1][1]) + su * d[0][1].w + sv * d[1][0].w + s * d[1][1].w) / min_w,
          (part(d[0][2]) + 2.0 * sv * d[0][1].w + s * d[0][2].w) / min_w};
}

// Two intervals' worth of a direction's control tangents, in the leaf's frame (along A, across A, normal).
struct TangentBox {
  dvec3 lo{kInf}, hi{-kInf};
  void widen(double t, double n) { lo -= dvec3(t, t, n), hi += dvec3(t, t, n); }
};

// Cones about the normal that hold U(x) x V(y) for all x, y of the extended leaf, where U = P_u - w_u e and V
// = P_v - w_v e are the tangents of the line's distance function and e any point of the leaf. Sets sine and
// tilts.
void normal_cone(const LocalNet& net, double min_w, const Extent (&d)[3][3], const dvec3& axis_a,
                 const dvec3& axis_b, LeafProof& proof) {
  const dvec3 axis[3] = {axis_a, glm::cross(net.normal, axis_a), net.normal};
  TangentBox box[2];
  for (int dir = 0; dir < 2; ++dir) {
    const int a = dir == 0 ? 1 : 0, b = 1 - a;
    const double scale = (dir == 0 ? net.du : net.dv) / (2.0 * kExtend);
    for (int i = 0; i + a <= net.du; ++i)
      for (int j = 0; j + b <= net.dv; ++j) {
        const dvec3 p = scale * xyz(net.difference(i, j, a, b));
        const dvec3 q(glm::dot(p, axis[0]), glm::dot(p, axis[1]), glm::dot(p, axis[2]));
        box[dir].lo = glm::min(box[dir].lo, q), box[dir].hi = glm::max(box[dir].hi, q);
      }
    const double w = d[a][b].w / min_w;
    box[dir].widen(w * d[0][0].t, w * d[0][0].n);
  }
  // U x V is bilinear: its extremes over two boxes are at their corners. In the frame's plane n x a is (0,
  // 1).
  const double bx = glm::dot(axis_b, axis[0]), by = glm::dot(axis_b, axis[1]);
  double worst = 0.0, tilt_a = 0.0, tilt_b = 0.0;
  for (int k = 0; k < 64; ++k) {
    const auto corner = [](const TangentBox& b, int m) {
      return dvec3(m & 1 ? b.hi.x : b.lo.x, m & 2 ? b.hi.y : b.lo.y, m & 4 ? b.hi.z : b.lo.z);
    };
    const dvec3 n = glm::cross(corner(box[0], k & 7), corner(box[1], k >> 3));
    if (!(n.z > 0.0)) return;
    worst = std::max(worst, (n.x * n.x + n.y * n.y) / (n.z * n.z));
    const double along_b = -n.x / by, along_a = n.y - along_b * bx;  // n x b is (-by, bx)
    tilt_a = std::max(tilt_a, std::fabs(along_a) / n.z), tilt_b = std::max(tilt_b, std::fabs(along_b) / n.z);
  }
  proof.sine = std::sqrt(worst / (1.0 + worst)) + 1e-6;  // worst: the tangent squared
  proof.tilt_a = tilt_a + 1e-6, proof.tilt_b = tilt_b + 1e-6;
}

// S, S_u, S_v at the middle of a net over the extended leaf, tangents per half width.
void center_frame(const LocalNet& net, dvec3& c, dvec3& a, dvec3& b) {
  dvec4 p(0.0), pu(0.0), pv(0.0);
  double bu[2][nurbs::kMaxDegree + 1], bv[2][nurbs::kMaxDegree + 1];
  const auto basis = [](int n, double(&out)[2][nurbs::kMaxDegree + 1]) {
    double lower[nurbs::kMaxDegree + 1];  // degree n - 1 at 1/2
    double binomial = std::ldexp(1.0, -(n - 1));
    for (int i = 0; i < n; ++i) lower[i] = binomial, binomial = binomial * (n - 1 - i) / (i + 1);
    for (int i = 0; i <= n; ++i) {
      const double left = i > 0 ? lower[i - 1] : 0.0, right = i < n ? lower[i] : 0.0;
      out[0][i] = 0.5 * (left + right);
      out[1][i] = n * (left - right) / (2.0 * kExtend);
    }
  };
  basis(net.du, bu), basis(net.dv, bv);
  for (int i = 0; i <= net.du; ++i)
    for (int j = 0; j <= net.dv; ++j) {
      p += bu[0][i] * bv[0][j] * net.at(i, j);
      pu += bu[1][i] * bv[0][j] * net.at(i, j);
      pv += bu[0][i] * bv[1][j] * net.at(i, j);
    }
  c = xyz(p) / p.w;
  a = (xyz(pu) - c * pu.w) / p.w;
  b = (xyz(pv) - c * pv.w) / p.w;
}

void set(double (&out)[3], const dvec3& v) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }
dvec3 vec(const double (&v)[3]) { return dvec3(v[0], v[1], v[2]); }

// What the offset adds to the base: the offset times the range of the normal over the domain, from its
// interval enclosure and from the cone about n that prove_leaf found (sine of its half angle; above 1: none).
class OffsetShift {
 public:
  OffsetShift(const Patch& patch, const dvec4* net, const SubDomain& domain, const dvec3& n, double sine)
      : offset_(patch.offset), n_(n), sine_(sine), box_(enclose_offset(patch, net, domain)) {}

  Interval along(const dvec3& direction) const {
    const double length = glm::length(direction) * (1.0 + 1e-12);
    Interval range{-length, length};
    const auto meet = [&](const Interval& x) {
      range = {std::max(range.lo, x.lo), std::min(range.hi, x.hi)};
    };
    if (box_.regular) meet(dot(box_.frame * direction, box_.normal));
    if (sine_ < 1.0) {
      const double part = glm::dot(direction, n_),
                   across = sine_ * glm::length(direction - part * n_) + 1e-12 * length;
      const Interval cone = part * Interval{std::sqrt(1.0 - sine_ * sine_) - 1e-12, 1.0 + 1e-12};
      meet({cone.lo - across, cone.hi + across});
    }
    return offset_ * range;
  }

  // Cuts the range of direction . (S + offset n - c) down to its linear bound from the middle.
  void cut(const dvec3& direction, const dvec3& c, double& lo, double& hi) const {
    if (!box_.regular) return;
    const double at = glm::dot(direction, box_.middle + box_.center - c);
    const dvec3 local = box_.frame * direction;
    const double reach =
        0.5 * (1.0 + 1e-9) * (dot(local, box_.px).magnitude() + dot(local, box_.py).magnitude()) +
        glm::length(direction) * box_.error;
    if (lo < at - reach) lo = at - reach;
    if (hi > at + reach) hi = at + reach;
  }

 private:
  double offset_;
  dvec3 n_;
  double sine_;
  OffsetBox box_;
};

// The boxes of the control hull: along the axes, and along the tangents a, b and the unit normal n at the
// point c. n = 0: the leaf is singular or a weight is not positive, and the axes take their place.
void enclose(const Patch& patch, const dvec4* source, const SubDomain& domain, const dvec3& c, const dvec3& a,
             const dvec3& b, const dvec3& n, LeafProof& proof) {
  const int count = (patch.degree_u + 1) * (patch.degree_v + 1);
  dvec4 points[kMaxNet];
  std::copy(source, source + count, points);
  const double slack_u = 1e-7 * (domain.u1 - domain.u0), slack_v = 1e-7 * (domain.v1 - domain.v0);
  restrict_net(points, patch.degree_u, patch.degree_v, domain.u0 - slack_u, domain.u1 + slack_u,
               domain.v0 - slack_v, domain.v1 + slack_v);
  const bool regular = n != dvec3(0.0);
  const dvec3 axis_a = regular ? a : dvec3(1, 0, 0), axis_b = regular ? b : dvec3(0, 1, 0);
  const dvec3 axis_n = regular ? n : dvec3(0, 0, 1);
  const glm::dmat3 to_local = glm::inverse(glm::dmat3(axis_a, axis_b, axis_n));
  Box3 local;
  for (int k = 0; k < count; ++k) {
    const dvec3 p = xyz(points[k]) / points[k].w;
    proof.box.add(p);
    local.add(to_local * (p - c));
  }
  const double rounding = 1e-13 * (patch.size + glm::length(patch.origin));
  if (patch.offset != 0.0) {
    const OffsetShift shift(patch, source, widened(patch, domain, slack_u, slack_v), n, proof.sine);
    for (int i = 0; i < 3; ++i) {
      const dvec3 axis(i == 0, i == 1, i == 2), row(to_local[0][i], to_local[1][i], to_local[2][i]);
      const Interval world = shift.along(axis), part = shift.along(row);
      proof.box.lower[i] += world.lo, proof.box.upper[i] += world.hi;
      local.lower[i] += part.lo, local.upper[i] += part.hi;
      shift.cut(axis, dvec3(0.0), proof.box.lower[i], proof.box.upper[i]);
      shift.cut(row, c, local.lower[i], local.upper[i]);
    }
  }
  proof.box.dilate(rounding);
  const dvec3 middle = local.center();
  const dvec3 half =
      0.5 * (1.0 + 1e-9) * local.extent() + rounding / dvec3(glm::length(axis_a), glm::length(axis_b), 1.0);
  LeafBound& bound = proof.bound;
  set(bound.center, c + axis_a * middle.x + axis_b * middle.y + axis_n * middle.z);
  const dvec3 ea = axis_a * half.x, eb = axis_b * half.y, ek = axis_n * half.z;
  set(bound.a, ea), set(bound.b, eb), set(bound.k, ek);
  set(bound.ab, glm::cross(ea, eb)), set(bound.ak, glm::cross(ea, ek)), set(bound.bk, glm::cross(eb, ek));
}

}  // namespace

LeafProof prove_leaf(const Patch& patch, const dvec4* source, const SubDomain& domain) {
  const int du = patch.degree_u, dv = patch.degree_v, count = (du + 1) * (dv + 1);
  dvec4 points[kMaxNet];
  std::copy(source, source + count, points);
  LeafProof proof;
  LeafBound& bound = proof.bound;
  bound = {};
  bound.mid_u = 0.5 * (domain.u0 + domain.u1), bound.half_u = 0.5 * (domain.u1 - domain.u0);
  bound.mid_v = 0.5 * (domain.v0 + domain.v1), bound.half_v = 0.5 * (domain.v1 - domain.v0);
  bound.unique = bound.unique_a = bound.unique_b = kInf;
  restrict_net(points, du, dv, bound.mid_u - kExtend * bound.half_u, bound.mid_u + kExtend * bound.half_u,
               bound.mid_v - kExtend * bound.half_v, bound.mid_v + kExtend * bound.half_v);
  LocalNet net{du, dv, points, dvec3(0.0)};
  dvec3 c, a, b;
  center_frame(net, c, a, b);
  const dvec3 n = glm::cross(a, b);
  const double area = glm::length(n);
  const bool regular = area > 0.0 && std::isfinite(area);
  double min_w = kInf;
  for (int k = 0; k < count; ++k) {
    min_w = std::min(min_w, points[k].w);
    points[k] -= dvec4(c * points[k].w, 0.0);
  }
  if (!(min_w > 0.0) || !regular) {
    enclose(patch, source, domain, c, a, b, dvec3(0.0), proof);
    return proof;
  }
  // Newton in lanes knows base surfaces only: offset leaves claim no uniqueness.
  const bool newton = patch.offset == 0.0;
  net.normal = n / area;
  Extent d[3][3];
  for (int i = 0; i <= 2; ++i)
    for (int j = 0; i + j <= 2; ++j) d[i][j] = net.derivative(i, j);
  normal_cone(net, min_w, d, glm::normalize(a), glm::normalize(b), proof);
  enclose(patch, source, domain, c, a, b, net.normal, proof);  // offsets use the cone
  const double ab = glm::length(vec(bound.ab));
  if (newton && proof.sine < 1.0) bound.unique = ab * proof.sine;
  if (newton) bound.unique_a = proof.tilt_a * ab / glm::length(vec(bound.ak));
  if (newton) bound.unique_b = proof.tilt_b * ab / glm::length(vec(bound.bk));

  const Bends t = bend(d, min_w, [](const Extent& e) { return e.t; });
  const Bends m = bend(d, min_w, [](const Extent& e) { return e.n; });
  const double length_a = glm::length(a), length_b = glm::length(b);
  proof.bend_u = length_b * (m.uu + t.uu) + length_a * (m.uv + t.uv);
  proof.bend_v = length_a * (m.vv + t.vv) + length_b * (m.uv + t.uv);
  return proof;
}

}  // namespace trimray::trace
