#include "core/distance/search.h"

#include <algorithm>
#include <cmath>

namespace trimray::distance {
namespace {

constexpr int kMaxSteps = 40;
constexpr double kSettled = 1e-9;  // of the net's tangent: the square of such a step is nothing

double square(const dvec3& d) { return glm::dot(d, d); }

}  // namespace

Foot descend(const dvec4* net, int du, int dv, const Domain& in, const dvec3& q, double u, double v) {
  u = std::clamp(u, in.u0, in.u1), v = std::clamp(v, in.v0, in.v1);
  Jet s = jet_at(net, du, dv, u, v);
  Foot best{u, v, s.p, square(s.p - q)};
  for (int step = 0; step < kMaxSteps; ++step) {
    const dvec3 e = s.p - q;
    const double gu = glm::dot(e, s.u), gv = glm::dot(e, s.v);
    // At a side that the gradient presses against, the coordinate stays.
    const bool hold_u = (u <= in.u0 && gu >= 0.0) || (u >= in.u1 && gu <= 0.0);
    const bool hold_v = dv == 0 || (v <= in.v0 && gv >= 0.0) || (v >= in.v1 && gv <= 0.0);
    const double uu = glm::dot(s.u, s.u), uv = glm::dot(s.u, s.v), vv = glm::dot(s.v, s.v);
    double a = uu + glm::dot(e, s.uu), b = uv + glm::dot(e, s.uv), c = vv + glm::dot(e, s.vv);
    // Where the distance curves down in what may move, Gauss-Newton.
    constexpr double kUp = 1e-9;
    const bool both = !hold_u && !hold_v;
    const bool down_u = !(a > kUp * uu), down_v = !(c > kUp * vv);
    if (both && (down_u || down_v || !(a * c - b * b > kUp * a * c))) {
      a = uu, b = uv, c = vv;
    } else {
      if (down_u) a = uu;
      if (down_v) c = vv;
    }
    double mu = 0.0, mv = 0.0;
    if (both && a * c - b * b > 1e-14 * a * c) {
      const double det = a * c - b * b;
      mu = -(c * gu - b * gv) / det, mv = -(a * gv - b * gu) / det;
    } else {
      if (!hold_u && a > 0.0) mu = -gu / a;
      if (!hold_v && c > 0.0) mv = -gv / c;
      if (both) (uu * mu * mu < vv * mv * mv ? mu : mv) = 0.0;
    }
    if (!std::isfinite(mu + mv)) break;
    bool better = false;
    double moved = 0.0;
    for (int halving = 0; halving < 30 && !better; ++halving, mu *= 0.5, mv *= 0.5) {
      const double nu = std::clamp(u + mu, in.u0, in.u1), nv = std::clamp(v + mv, in.v0, in.v1);
      if (nu == u && nv == v) break;
      const Jet next = jet_at(net, du, dv, nu, nv);
      const double d = square(next.p - q);
      const double du_ = nu - u, dv_ = nv - v;
      moved = uu * du_ * du_ + vv * dv_ * dv_;
      if (d < best.square) {
        best = {nu, nv, next.p, d};
        u = nu, v = nv, s = next, better = true;
      } else if (moved <= kSettled * kSettled * (uu + vv)) {
        break;
      }
    }
    if (!better || moved <= kSettled * kSettled * (uu + vv)) break;
  }
  return best;
}

Critical critical_point(const dvec4* net, int du, int dv, const Domain& in, const dvec3& q) {
  double u = 0.5 * (in.u0 + in.u1), v = 0.5 * (in.v0 + in.v1);
  const double width_u = in.u1 - in.u0, width_v = in.v1 - in.v0;
  Critical result;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Jet s = jet_at(net, du, dv, u, v);
    const dvec3 e = s.p - q;
    result.foot = {u, v, s.p, square(e)};
    if (result.settled) break;
    const double a = glm::dot(s.u, s.u) + glm::dot(e, s.uu), b = glm::dot(s.u, s.v) + glm::dot(e, s.uv),
                 c = glm::dot(s.v, s.v) + glm::dot(e, s.vv), det = a * c - b * b;
    const double gu = glm::dot(e, s.u), gv = glm::dot(e, s.v);
    const double mu = -(c * gu - b * gv) / det, mv = -(a * gv - b * gu) / det;
    if (!std::isfinite(mu + mv)) break;
    const double nu = std::clamp(u + mu, in.u0 - 1e-9 * width_u, in.u1 + 1e-9 * width_u),
                 nv = std::clamp(v + mv, in.v0 - 1e-9 * width_v, in.v1 + 1e-9 * width_v);
    if (nu == u && nv == v) break;  // pressed against the rim, or at rest
    result.settled = nu == u + mu && nv == v + mv && std::abs(mu) + std::abs(mv) <= 1e-9;
    u = nu, v = nv;
  }
  return result;
}

}  // namespace trimray::distance
