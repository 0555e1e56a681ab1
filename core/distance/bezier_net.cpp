#include "core/distance/bezier_net.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace trimray::distance {
namespace {

constexpr int kRoom = kMaxNetDegree + 1;

dvec3 xyz(const dvec4& h) { return {h.x, h.y, h.z}; }

// Bernstein functions of degree n and their first two derivatives.
void bernstein(int n, double x, double* b, double* d, double* dd) {
  const double y = 1.0 - x;
  b[0] = 1.0;
  for (int i = 0; i <= n; ++i) d[i] = dd[i] = 0.0;
  for (int r = 1; r <= n; ++r) {
    if (r == n - 1)  // b is of degree n - 2
      for (int i = 0; i <= n; ++i)
        dd[i] = n * (n - 1.0) *
                ((i >= 2 ? b[i - 2] : 0.0) - 2.0 * (i >= 1 && i <= n - 1 ? b[i - 1] : 0.0) +
                 (i <= n - 2 ? b[i] : 0.0));
    if (r == n)
      for (int i = 0; i <= n; ++i) d[i] = n * ((i >= 1 ? b[i - 1] : 0.0) - (i < n ? b[i] : 0.0));
    b[r] = b[r - 1] * x;
    for (int i = r - 1; i >= 1; --i) b[i] = b[i] * y + b[i - 1] * x;
    b[0] *= y;
  }
}

struct Pascal {
  double c[2 * kRoom][2 * kRoom] = {};
  Pascal() {
    for (int n = 0; n < 2 * kRoom; ++n) {
      c[n][0] = c[n][n] = 1.0;
      for (int k = 1; k < n; ++k) c[n][k] = c[n - 1][k - 1] + c[n - 1][k];
    }
  }
};
const Pascal kBinomial;

}  // namespace

Jet jet_at(const dvec4* net, int du, int dv, double u, double v) {
  double bu[3][kRoom], bv[3][kRoom];
  bernstein(du, u, bu[0], bu[1], bu[2]);
  bernstein(dv, v, bv[0], bv[1], bv[2]);
  dvec4 h(0.0), hu(0.0), hv(0.0), huu(0.0), huv(0.0), hvv(0.0);
  for (int i = 0; i <= du; ++i, net += dv + 1) {
    dvec4 r(0.0), rv(0.0), rvv(0.0);
    for (int j = 0; j <= dv; ++j) r += bv[0][j] * net[j], rv += bv[1][j] * net[j], rvv += bv[2][j] * net[j];
    h += bu[0][i] * r, hv += bu[0][i] * rv, hvv += bu[0][i] * rvv;
    hu += bu[1][i] * r, huv += bu[1][i] * rv;
    huu += bu[2][i] * r;
  }
  const double w = 1.0 / h.w;
  Jet s;
  s.p = xyz(h) * w;
  s.u = (xyz(hu) - hu.w * s.p) * w, s.v = (xyz(hv) - hv.w * s.p) * w;
  s.uu = (xyz(huu) - 2.0 * hu.w * s.u - huu.w * s.p) * w;
  s.vv = (xyz(hvv) - 2.0 * hv.w * s.v - hvv.w * s.p) * w;
  s.uv = (xyz(huv) - hu.w * s.v - hv.w * s.u - huv.w * s.p) * w;
  return s;
}

dvec3 point_at(const dvec4* net, int du, int dv, double u, double v) {
  double bu[3][kRoom], bv[3][kRoom];
  bernstein(du, u, bu[0], bu[1], bu[2]);
  bernstein(dv, v, bv[0], bv[1], bv[2]);
  dvec4 h(0.0);
  for (int i = 0; i <= du; ++i, net += dv + 1) {
    dvec4 r(0.0);
    for (int j = 0; j <= dv; ++j) r += bv[0][j] * net[j];
    h += bu[0][i] * r;
  }
  return xyz(h) / h.w;
}

namespace {

// The net of w (S - T); of degree 1 more where the weights differ.
void set_rest(const dvec4* net, int du, int dv, NetBound& b) {
  const dvec3 o = b.middle.p, tu = b.middle.u, tv = b.middle.v;
  const bool rational = b.w_upper > b.w_lower;
  b.rest_u = du + (rational ? 1 : 0), b.rest_v = dv + (rational && dv > 0 ? 1 : 0);
  const int row = b.rest_v + 1;
  b.rest.assign(static_cast<std::size_t>(b.rest_u + 1) * row, dvec4(0.0));
  // A net times u is i / n of its control points, times 1 - u the rest of them.
  for (int i = 0; i <= b.rest_u; ++i)
    for (int j = 0; j <= b.rest_v; ++j) {
      dvec4& sum = b.rest[i * row + j];
      for (int a = rational ? i - 1 : i; a <= i; ++a)
        for (int c = b.rest_v > dv ? j - 1 : j; c <= j; ++c) {
          if (a < 0 || a > du || c < 0 || c > dv) continue;
          double part_u = 1.0, part_v = 1.0, u = double(i) / std::max(1, b.rest_u) - 0.5,
                 v = double(j) / std::max(1, b.rest_v) - 0.5;
          if (rational) {
            part_u = a < i ? double(i) / b.rest_u : 1.0 - double(i) / b.rest_u;
            u = a < i ? 0.5 : -0.5;
          }
          if (b.rest_v > dv) {
            part_v = c < j ? double(j) / b.rest_v : 1.0 - double(j) / b.rest_v;
            v = c < j ? 0.5 : -0.5;
          }
          if (dv == 0) v = 0.0;
          const dvec4& h = net[a * (dv + 1) + c];
          sum += part_u * part_v * dvec4(xyz(h) - h.w * (o + u * tu + v * tv), h.w);
        }
    }
}

// Visits the second differences of the rest, times the degrees' factors: which (uu, uv, vv) and the net's.
template <typename Visit>
void second_differences(const NetBound& b, const Visit& visit) {
  const int du = b.rest_u, dv = b.rest_v, row = dv + 1;
  for (int i = 0; i <= du; ++i)
    for (int j = 0; j <= dv; ++j) {
      const dvec4* p = b.rest.data() + i * row + j;
      if (i + 2 <= du) visit(0, du * (du - 1.0) * (p[2 * row] - 2.0 * p[row] + p[0]));
      if (i < du && j < dv) visit(1, double(du) * dv * (p[row + 1] - p[row] - p[1] + p[0]));
      if (j + 2 <= dv) visit(2, dv * (dv - 1.0) * (p[2] - 2.0 * p[1] + p[0]));
    }
}

}  // namespace

bool bound_net(const dvec4* net, int du, int dv, NetBound& out) {
  const int count = (du + 1) * (dv + 1);
  out.middle = jet_at(net, du, dv, 0.5, 0.5);
  out.radius = out.rest_radius = 0.0, out.w_lower = kInf, out.w_upper = 0.0;
  for (int k = 0; k < count; ++k) {
    if (!(net[k].w > 0.0)) return false;
    out.w_lower = std::min(out.w_lower, net[k].w), out.w_upper = std::max(out.w_upper, net[k].w);
    out.radius = std::max(out.radius, glm::length(xyz(net[k]) / net[k].w - out.middle.p));
  }
  set_rest(net, du, dv, out);
  const int ru = out.rest_u, rv = out.rest_v, row = rv + 1;
  double nu = 0.0, nv = 0.0, n[3] = {0.0, 0.0, 0.0}, w[3] = {0.0, 0.0, 0.0};
  out.wu = out.wv = 0.0;
  for (int i = 0; i <= ru; ++i)
    for (int j = 0; j <= rv; ++j) {
      const dvec4* p = out.rest.data() + i * row + j;
      out.rest_radius = std::max(out.rest_radius, glm::length(xyz(p[0])) / p[0].w);
      if (i < ru)
        nu = std::max(nu, ru * glm::length(xyz(p[row] - p[0]))),
        out.wu = std::max(out.wu, ru * std::abs(p[row].w - p[0].w));
      if (j < rv)
        nv = std::max(nv, rv * glm::length(xyz(p[1] - p[0]))),
        out.wv = std::max(out.wv, rv * std::abs(p[1].w - p[0].w));
    }
  second_differences(out, [&](int which, const dvec4& d) {
    n[which] = std::max(n[which], glm::length(xyz(d))), w[which] = std::max(w[which], std::abs(d.w));
  });
  out.wuu = w[0], out.wuv = w[1], out.wvv = w[2];
  // Of N / w by the quotient rule; T adds nothing to second derivatives, and its first ones are the middle's.
  const double least = out.w_lower, r = out.rest_radius;
  const double su = (nu + out.wu * r) / least, sv = (nv + out.wv * r) / least;
  out.uu = (n[0] + 2.0 * out.wu * su + out.wuu * r) / least;
  out.vv = (n[2] + 2.0 * out.wv * sv + out.wvv * r) / least;
  out.uv = (n[1] + out.wu * sv + out.wv * su + out.wuv * r) / least;
  out.turn_u = std::min(su, 0.5 * (out.uu + out.uv)), out.turn_v = std::min(sv, 0.5 * (out.vv + out.uv));
  return std::isfinite(out.radius + out.uu + out.uv + out.vv + out.turn_u + out.turn_v);
}

double convex_radius(const NetBound& b) {
  const double length = glm::length(b.middle.u);
  if (!(length > 0.0)) return 0.0;
  const double s = 1.0 - b.turn_u / length;
  return s > 0.0 ? s * s * length * length / b.uu : 0.0;
}

HessianBound bound_hessian(const NetBound& b, const dvec3 (&axis)[3]) {
  const double lu = glm::length(b.middle.u), lv = glm::length(b.middle.v);
  const double least_u = std::max(0.0, lu - b.turn_u), least_v = std::max(0.0, lv - b.turn_v);
  HessianBound h;
  h.uu = least_u * least_u, h.vv = least_v * least_v;
  h.uv = std::abs(glm::dot(b.middle.u, b.middle.v)) + lu * b.turn_v + lv * b.turn_u + b.turn_u * b.turn_v;
  Span spans[3][3];  // [uu, uv, vv][axis]
  bool first[3] = {true, true, true};
  second_differences(b, [&](int which, const dvec4& d) {
    for (int k = 0; k < 3; ++k) {
      const double along = glm::dot(axis[k], xyz(d));
      Span& s = spans[which][k];
      s.lower = first[which] ? along : std::min(s.lower, along);
      s.upper = first[which] ? along : std::max(s.upper, along);
    }
    first[which] = false;
  });
  const double slack[3] = {2.0 * b.wu * b.turn_u + b.wuu * b.rest_radius,
                           b.wu * b.turn_v + b.wv * b.turn_u + b.wuv * b.rest_radius,
                           2.0 * b.wv * b.turn_v + b.wvv * b.rest_radius};
  for (int k = 0; k < 3; ++k) {
    Span s[3];
    for (int c = 0; c < 3; ++c) {
      const Span& n = spans[c][k];
      s[c].lower = std::min(n.lower / b.w_lower, n.lower / b.w_upper) - slack[c] / b.w_lower;
      s[c].upper = std::max(n.upper / b.w_lower, n.upper / b.w_upper) + slack[c] / b.w_lower;
    }
    if (k == 2) {
      h.normal_uu = s[0], h.normal_uv = s[1], h.normal_vv = s[2];
    } else {
      h.side_uu[k] = std::max(-s[0].lower, s[0].upper), h.side_uv[k] = std::max(-s[1].lower, s[1].upper),
      h.side_vv[k] = std::max(-s[2].lower, s[2].upper);
    }
  }
  return h;
}

bool convex_for(const HessianBound& h, const Span (&e)[3]) {
  const double e0 = std::max(-e[0].lower, e[0].upper), e1 = std::max(-e[1].lower, e[1].upper);
  const auto least = [](const Span& a, const Span& b) {
    return std::min(std::min(a.lower * b.lower, a.lower * b.upper),
                    std::min(a.upper * b.lower, a.upper * b.upper));
  };
  const double uu = h.uu + least(e[2], h.normal_uu) - e0 * h.side_uu[0] - e1 * h.side_uu[1];
  const double vv = h.vv + least(e[2], h.normal_vv) - e0 * h.side_vv[0] - e1 * h.side_vv[1];
  const double uv = h.uv +
                    std::max(-e[2].lower, e[2].upper) * std::max(-h.normal_uv.lower, h.normal_uv.upper) +
                    e0 * h.side_uv[0] + e1 * h.side_uv[1];
  return uu > 0.0 && vv > 0.0 && uu * vv > (1.0 + 1e-9) * uv * uv;
}

Shape shape_of(const NetBound& b, bool curve) {
  Shape shape;
  const dvec3 e = b.middle.p;  // from the origin to the surface
  const double size = glm::length(e);
  Span d[3];  // of the second derivatives along e
  bool first[3] = {true, true, true};
  second_differences(b, [&](int which, const dvec4& h) {
    const double x = glm::dot(e, xyz(h));
    d[which].lower = first[which] ? x : std::min(d[which].lower, x);
    d[which].upper = first[which] ? x : std::max(d[which].upper, x);
    first[which] = false;
  });
  // (S - origin) is e and no more than the radius beside it.
  const auto second = [&](int which, double weights, double most) {
    const double l = d[which].lower, u = d[which].upper, slack = size * weights / b.w_lower + b.radius * most;
    return Span{std::min(l / b.w_lower, l / b.w_upper) - slack,
                std::max(u / b.w_lower, u / b.w_upper) + slack};
  };
  const double lu = glm::length(b.middle.u), lv = glm::length(b.middle.v);
  const auto square = [](double length, double turn) {
    const double low = std::max(0.0, length - turn);
    return Span{low * low, (length + turn) * (length + turn)};
  };
  const Span gu = square(lu, b.turn_u), a = second(0, 2.0 * b.wu * b.turn_u + b.wuu * b.rest_radius, b.uu);
  const Span h11{gu.lower + a.lower, gu.upper + a.upper};
  const auto slope = [&](const dvec3& tangent, double length, double turn) {
    const double middle = glm::dot(e, tangent), reach = size * turn + b.radius * (length + turn);
    return middle > (1.0 + 1e-9) * reach ? 1 : middle < -(1.0 + 1e-9) * reach ? -1 : 0;
  };
  shape.slope_u = slope(b.middle.u, lu, b.turn_u);
  shape.convex_u = h11.lower > 0.0;
  if (curve) {
    shape.convex = shape.convex_u, shape.regular = shape.convex || h11.upper < 0.0;
    return shape;
  }
  shape.slope_v = slope(b.middle.v, lv, b.turn_v);
  const Span c = second(2, 2.0 * b.wv * b.turn_v + b.wvv * b.rest_radius, b.vv);
  const Span m = second(1, b.wu * b.turn_v + b.wv * b.turn_u + b.wuv * b.rest_radius, b.uv);
  const Span gv = square(lv, b.turn_v);
  const double mixed = glm::dot(b.middle.u, b.middle.v),
               mixed_turn = lu * b.turn_v + lv * b.turn_u + b.turn_u * b.turn_v;
  const Span h22{gv.lower + c.lower, gv.upper + c.upper};
  const Span h12{mixed - mixed_turn + m.lower, mixed + mixed_turn + m.upper};
  const double off = std::max(std::abs(h12.lower), std::abs(h12.upper));
  constexpr double kRounding = 1.0 + 1e-9;
  shape.convex_v = h22.lower > 0.0;
  shape.convex = shape.convex_u && shape.convex_v && h11.lower * h22.lower > kRounding * off * off;
  const double products[4] = {h11.lower * h22.lower, h11.lower * h22.upper, h11.upper * h22.lower,
                              h11.upper * h22.upper};
  const double least =
      h12.lower <= 0.0 && h12.upper >= 0.0 ? 0.0 : std::min(h12.lower * h12.lower, h12.upper * h12.upper);
  shape.regular = *std::min_element(products, products + 4) > kRounding * off * off ||
                  kRounding * *std::max_element(products, products + 4) < least;
  return shape;
}

SquareForm square_form(const dvec4* net, int du, int dv, double distance, std::vector<double>& coefficients) {
  const double d2 = distance * distance;
  const int rows = 2 * du + 1, row = 2 * dv + 1;
  coefficients.resize(static_cast<std::size_t>(rows) * row);
  SquareForm form{true};
  // Coefficient (k, l) of a product is a mean of the products with i + i' = k, j + j' = l, the weights being
  // C(du, i) C(du, i') / C(2 du, k), and so for v.
  for (int k = 0; k < rows; ++k)
    for (int l = 0; l < row; ++l) {
      double sum = 0.0, scale = 0.0;
      for (int i = std::max(0, k - du); i <= std::min(k, du); ++i)
        for (int j = std::max(0, l - dv); j <= std::min(l, dv); ++j) {
          const dvec4 &a = net[i * (dv + 1) + j], &b = net[(k - i) * (dv + 1) + l - j];
          const double c =
              kBinomial.c[du][i] * kBinomial.c[du][k - i] * kBinomial.c[dv][j] * kBinomial.c[dv][l - j];
          const double dot = a.x * b.x + a.y * b.y + a.z * b.z, ww = d2 * a.w * b.w;
          sum += c * (dot - ww), scale += c * (std::abs(dot) + ww);
        }
      form.keeps_away = form.keeps_away && sum > 4e-16 * scale;
      coefficients[k * row + l] = sum / (kBinomial.c[2 * du][k] * kBinomial.c[2 * dv][l]);
    }
  const double* c = coefficients.data();
  for (int k = 0; k < rows; ++k)
    for (int l = 0; l < row; ++l, ++c) {
      if (k + 2 < rows) form.bend_u = std::max(form.bend_u, std::abs(c[2 * row] - 2.0 * c[row] + c[0]));
      if (l + 2 < row) form.bend_v = std::max(form.bend_v, std::abs(c[2] - 2.0 * c[1] + c[0]));
    }
  return form;
}

double plane_bound(const dvec4* net, int count, const dvec3& towards) {
  double least = kInf;
  for (int k = 0; k < count; ++k) least = std::min(least, glm::dot(towards, xyz(net[k])) / net[k].w);
  return least;
}

}  // namespace trimray::distance
