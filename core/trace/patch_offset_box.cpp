// Evaluation and enclosure of offset surfaces.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/nurbs/knot_vector.h"
#include "core/trace/patch_net.h"
#include "core/trace/patch_offset.h"

namespace trimray::trace {
namespace {

constexpr int kMaxNet = (nurbs::kMaxDegree + 1) * (nurbs::kMaxDegree + 1);

// Point and derivatives of the base surface up to the second, by the Bernstein basis.
struct BaseJet {
  dvec3 s, su, sv, suu, suv, svv;
};

struct BasisRow {
  double d[3][nurbs::kMaxDegree + 1];
};

BasisRow basis(int n, double x) {
  BasisRow r = {};
  double b[3][nurbs::kMaxDegree + 1] = {};  // degrees n - 2, n - 1, n (padded)
  const auto fill = [x](int degree, double* out) {
    out[0] = 1.0;
    for (int k = 1; k <= degree; ++k) {
      out[k] = out[k - 1] * x;
      for (int i = k - 1; i >= 1; --i) out[i] = out[i] * (1.0 - x) + out[i - 1] * x;
      out[0] *= 1.0 - x;
    }
  };
  fill(n, b[2]), fill(n - 1, b[1]);
  if (n >= 2) fill(n - 2, b[0]);
  const auto at = [](const double* v, int i, int degree) { return i >= 0 && i <= degree ? v[i] : 0.0; };
  for (int i = 0; i <= n; ++i) {
    r.d[0][i] = b[2][i];
    r.d[1][i] = n * (at(b[1], i - 1, n - 1) - at(b[1], i, n - 1));
    if (n >= 2)
      r.d[2][i] = n * (n - 1) * (at(b[0], i - 2, n - 2) - 2.0 * at(b[0], i - 1, n - 2) + at(b[0], i, n - 2));
  }
  return r;
}

BaseJet base_jet(const Patch& patch, const dvec4* net, double u, double v) {
  const BasisRow bu = basis(patch.degree_u, u), bv = basis(patch.degree_v, v);
  dvec4 h[3][3] = {};
  for (auto& row : h)
    for (dvec4& x : row) x = dvec4(0.0);
  for (int i = 0; i <= patch.degree_u; ++i)
    for (int j = 0; j <= patch.degree_v; ++j)
      for (int a = 0; a <= 2; ++a)
        for (int b = 0; a + b <= 2; ++b)
          h[a][b] += bu.d[a][i] * bv.d[b][j] * net[i * (patch.degree_v + 1) + j];
  const auto p = [&](int a, int b) { return dvec3(h[a][b].x, h[a][b].y, h[a][b].z); };
  const double w = h[0][0].w;
  BaseJet j;
  j.s = p(0, 0) / w;
  j.su = (p(1, 0) - j.s * h[1][0].w) / w;
  j.sv = (p(0, 1) - j.s * h[0][1].w) / w;
  j.suu = (p(2, 0) - 2.0 * j.su * h[1][0].w - j.s * h[2][0].w) / w;
  j.suv = (p(1, 1) - j.su * h[0][1].w - j.sv * h[1][0].w - j.s * h[1][1].w) / w;
  j.svv = (p(0, 2) - 2.0 * j.sv * h[0][1].w - j.s * h[0][2].w) / w;
  return j;
}

dvec3 xyz(const dvec4& h) { return dvec3(h.x, h.y, h.z); }

// Ranges of the components of a Bezier net and its derivatives up to the second over a box, per width of the
// box. Differences are taken before the net is cut down to the box, so that their rounding shrinks with it.
struct NetRange {
  const dvec4* p;
  int n, m;
  SubDomain box;
  double scale, noise;  // of the position; rounding of the net
  dvec3 center;

  std::pair<Interval3, Interval> derivative(int a, int b) const {
    if (n < a || m < b) return {};
    dvec4 d[kMaxNet];
    std::copy(p, p + (n + 1) * (m + 1), d);
    const double wx = box.u1 - box.u0, wy = box.v1 - box.v0;
    double factor = 1.0;
    for (int k = 0; k < a; ++k) {
      for (int i = 0; i + k < n; ++i)
        for (int j = 0; j <= m; ++j) d[i * (m + 1) + j] = d[(i + 1) * (m + 1) + j] - d[i * (m + 1) + j];
      factor *= (n - k) * wx;
    }
    int row = m + 1;
    for (int k = 0; k < b; ++k, --row) {
      for (int i = 0; i + a <= n; ++i)
        for (int j = 0; j + 1 < row; ++j) d[i * (row - 1) + j] = d[i * row + j + 1] - d[i * row + j];
      factor *= (m - k) * wy;
    }
    restrict_net(d, n - a, row - 1, box.u0, box.u1, box.v0, box.v1);
    dvec4 lo(kInf), hi(-kInf);
    for (int k = 0; k < (n - a + 1) * row; ++k) {
      const dvec4 x = d[k] - dvec4(center * d[k].w, 0.0);
      lo = glm::min(lo, x), hi = glm::max(hi, x);
    }
    lo = factor * (lo - noise), hi = factor * (hi + noise);
    const Interval s{scale, scale};
    return {s * Interval3{{lo.x, hi.x}, {lo.y, hi.y}, {lo.z, hi.z}}, Interval::outward(lo.w, hi.w)};
  }
};

// The patch's net and the domain, turned so that a collapsed side of the patch that the domain touches is y =
// 0.
struct TurnedNet {
  dvec4 p[kMaxNet];
  int n, m;
  SubDomain box;
  double sign = 1.0;  // of the turned S_x x S_y against S_u x S_v
  bool pole = false, swap;

  TurnedNet(const Patch& patch, const dvec4* net, const SubDomain& d)
      : n(patch.degree_u), m(patch.degree_v), box(d) {
    const bool u0 = (patch.poles & kSideU0) && d.u0 == 0.0, u1 = (patch.poles & kSideU1) && d.u1 == 1.0;
    const bool v0 = (patch.poles & kSideV0) && d.v0 == 0.0, v1 = (patch.poles & kSideV1) && d.v1 == 1.0;
    pole = u0 || u1 || v0 || v1;
    swap = !v0 && !v1 && (u0 || u1);
    const bool flip_u = swap && !u0, flip_v = !swap && !v0 && v1;
    const int du = n, dv = m;
    if (swap) std::swap(n, m);
    for (int i = 0; i <= du; ++i)
      for (int j = 0; j <= dv; ++j) {
        const int a = flip_u ? du - i : i, b = flip_v ? dv - j : j;
        p[swap ? b * (m + 1) + a : a * (m + 1) + b] = net[i * (dv + 1) + j];
      }
    if (flip_u) box = {1.0 - d.u1, 1.0 - d.u0, d.v0, d.v1};
    if (flip_v) box = {d.u0, d.u1, 1.0 - d.v1, 1.0 - d.v0};
    if (swap) box = {box.v0, box.v1, box.u0, box.u1};
    if (swap != (flip_u || flip_v)) sign = -1.0;
  }
};

}  // namespace

// The offset's tangents: n_u = (N_u - n (n . N_u)) / |N| with N = S_u x S_v.
OffsetJet offset_jet(const Patch& patch, const dvec4* net, double u, double v) {
  const BaseJet j = base_jet(patch, net, u, v);
  const dvec3 n = glm::cross(j.su, j.sv);
  const double length = glm::length(n);
  const dvec3 unit = n / length;
  const dvec3 nu = glm::cross(j.suu, j.sv) + glm::cross(j.su, j.suv);
  const dvec3 nv = glm::cross(j.suv, j.sv) + glm::cross(j.su, j.svv);
  const auto turn = [&](const dvec3& d) { return (d - unit * glm::dot(unit, d)) / length; };
  const double size_u = glm::length(j.su), size_v = glm::length(j.sv);
  const double turned = 1e-14 * patch.size * (size_u + size_v) / length;
  const double error = 1e-14 * patch.size + std::fabs(patch.offset) * (turned + 1e-15);
  return {j.s + patch.offset * unit, j.su + patch.offset * turn(nu), j.sv + patch.offset * turn(nv), unit,
          error};
}

SubDomain widened(const Patch& patch, const SubDomain& d, double by_u, double by_v) {
  return {(patch.poles & kSideU0) && d.u0 <= 0.0 ? 0.0 : d.u0 - by_u,
          (patch.poles & kSideU1) && d.u1 >= 1.0 ? 1.0 : d.u1 + by_u,
          (patch.poles & kSideV0) && d.v0 <= 0.0 ? 0.0 : d.v0 - by_v,
          (patch.poles & kSideV1) && d.v1 >= 1.0 ? 1.0 : d.v1 + by_v};
}

OffsetBox enclose_offset(const Patch& patch, const dvec4* net, const SubDomain& domain) {
  TurnedNet t(patch, net, domain);
  OffsetBox box;
  const OffsetJet middle =
      offset_jet(patch, net, 0.5 * (domain.u0 + domain.u1), 0.5 * (domain.v0 + domain.v1));
  const dvec3 tangent =
      glm::cross(middle.normal, std::fabs(middle.normal.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0));
  if (glm::length(tangent) > 0.5) {  // false for NaN
    const dvec3 t1 = glm::normalize(tangent), t2 = glm::cross(middle.normal, t1);
    box.frame = glm::transpose(dmat3(t1, t2, middle.normal));
  }
  box.center = t.pole ? xyz(t.p[0]) / t.p[0].w : middle.p - patch.offset * middle.normal;
  if (!(glm::length(box.center) < 2.0 * patch.size)) box.center = dvec3(0.0);
  double max_w = 0.0;
  for (int k = 0; k < (t.n + 1) * (t.m + 1); ++k) {
    max_w = std::max(max_w, t.p[k].w);
    t.p[k] = dvec4(box.frame * xyz(t.p[k]), t.p[k].w);
  }
  const dvec3 center = box.frame * box.center;
  box.swapped = t.swap;
  const double noise = 4e-15 * (t.n + t.m) * max_w * std::max(patch.size, 1.0);
  const NetRange all{t.p, t.n, t.m, t.box, 1.0, noise, center};
  const auto range = [](const NetRange& r, int a, int b) { return r.derivative(a, b); };
  const Interval w = range(all, 0, 0).second;
  if (!(w.lo > 0.0)) {
    box.base = {{-kInf, kInf}, {-kInf, kInf}, {-kInf, kInf}};
    return box;
  }
  const Interval iw = inverse(w);
  box.base = iw * range(all, 0, 0).first;

  // R = S, or at a pole S = y R with R's numerator of one degree less: y B_j^(m-1) = (j + 1) / m B_(j+1)^m.
  NetRange part = all;
  dvec4 q[kMaxNet];
  if (t.pole) {
    for (int i = 0; i <= t.n; ++i)
      for (int j = 0; j < t.m; ++j) {
        const dvec4& h = t.p[i * (t.m + 1) + j + 1];
        q[i * t.m + j] = (double(t.m) / (j + 1)) * (h - dvec4(center * h.w, 0.0));
      }
    part = {q, t.n, t.m - 1, t.box, t.box.v1, noise * t.m, dvec3(0.0)};
  }
  const Interval wx = range(all, 1, 0).second, wy = range(all, 0, 1).second, wxx = range(all, 2, 0).second,
                 wxy = range(all, 1, 1).second, wyy = range(all, 0, 2).second;
  const Interval3 r = iw * range(part, 0, 0).first;
  const Interval3 rx = iw * (range(part, 1, 0).first - wx * r), ry = iw * (range(part, 0, 1).first - wy * r);
  const Interval3 rxx = iw * (range(part, 2, 0).first - (2.0 * wx) * rx - wxx * r);
  const Interval3 rxy = iw * (range(part, 1, 1).first - wx * ry - wy * rx - wxy * r);
  const Interval3 ryy = iw * (range(part, 0, 2).first - (2.0 * wy) * ry - wyy * r);
  const Interval y{0.0, 1.0};
  const Interval3 sx = t.pole ? y * rx : rx, sy = t.pole ? r + y * ry : ry;
  const Interval3 syy = t.pole ? 2.0 * ry + y * ryy : ryy, sxy = t.pole ? rx + y * rxy : rxy;
  // M = rx x sy points along the normal; m_x and m_y its derivatives.
  const Interval3 m = cross(rx, sy), mx = cross(rxx, sy) + cross(rx, sxy),
                  my = cross(rxy, sy) + cross(rx, syy);
  const Interval length2 = square(m.x) + square(m.y) + square(m.z);
  const double shortest = std::sqrt(length2.lo), longest = std::sqrt(length2.hi);
  if (!(shortest > 1e-9 * longest)) return box;
  const Interval il = inverse(Interval::outward(shortest, longest));
  const auto clipped = [](const Interval& a) { return Interval{std::max(a.lo, -1.0), std::min(a.hi, 1.0)}; };
  const Interval3 unit = il * m;
  const Interval3 n{clipped(unit.x), clipped(unit.y), clipped(unit.z)};
  const auto turn = [&](const Interval3& d) { return il * (d - dot(n, d) * n); };
  const double distance = t.sign * patch.offset;
  const Interval3 nx = turn(mx), ny = turn(my);
  box.regular = true;
  box.px = sx + distance * nx;
  box.py = sy + distance * ny;
  // The normal once more, by its linear bound from the middle.
  box.middle = middle.p - box.center, box.error = middle.error;
  const Interval half{-0.5, 0.5};
  const double error = middle.error / std::fabs(patch.offset) + 1e-14;
  const auto around = [&](double at, const Interval& dx, const Interval& dy, const Interval& known) {
    const Interval linear = Interval{at - error, at + error} + half * dx + half * dy;
    return Interval{linear.lo > known.lo ? linear.lo : known.lo, linear.hi < known.hi ? linear.hi : known.hi};
  };
  const Interval3 direct = t.sign * n;
  const dvec3 at = box.frame * middle.normal;
  box.normal = {around(at.x, nx.x, ny.x, direct.x), around(at.y, nx.y, ny.y, direct.y),
                around(at.z, nx.z, ny.z, direct.z)};
  return box;
}

}  // namespace trimray::trace
