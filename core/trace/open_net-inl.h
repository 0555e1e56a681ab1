// Control nets of a leaf's parts, projected along the line each lane has: halves, and what they prove about
// roots. Included once per Highway target.
#if defined(TRIMRAY_CORE_TRACE_OPEN_NET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_TRACE_OPEN_NET_INL_H_
#undef TRIMRAY_CORE_TRACE_OPEN_NET_INL_H_
#else
#define TRIMRAY_CORE_TRACE_OPEN_NET_INL_H_
#endif

#include "core/trace/patch_hull-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

HWY_INLINE Lanes smaller_of(Lanes a, Lanes b) { return select(a < b, a, b); }
HWY_INLINE Lanes larger_of(Lanes a, Lanes b) { return select(a > b, a, b); }
HWY_INLINE Lanes cross_2(Lanes ax, Lanes ay, Lanes bx, Lanes by) { return neg_mul_add(ay, bx, ax * by); }

// Lanes whose points all have one sign in one coordinate: the common way to miss.
HWY_NOINLINE inline Mask beside_axes(const NetView& net, int count, Lanes noise) {
  Lanes x0 = net.x[0], x1 = x0, y0 = net.y[0], y1 = y0;
  for (int k = 1; k < count; ++k) {
    x0 = smaller_of(x0, net.x[k]), x1 = larger_of(x1, net.x[k]);
    y0 = smaller_of(y0, net.y[k]), y1 = larger_of(y1, net.y[k]);
  }
  const Lanes low = Lanes(0.0) - noise;
  return (x0 > noise) | (x1 < low) | (y0 > noise) | (y1 < low);
}

// What a net says about roots that are neither excluded nor found.
struct Prospect {
  Mask one;    // at most one root
  Lanes u, v;  // where the linear part of the net has it, in [0, 1] of the net
};

// At most one root: det(U, V) keeps its sign over all U, V in the hulls of the first differences in u and v.
// With U = A + dU, V = B + dV it is cross(U, B) + cross(A, V) - cross(A, B) + cross(dU, dV).
HWY_NOINLINE inline Prospect prospect(const NetView& net, int du, int dv, Lanes noise) {
  const int row = dv + 1, count = (du + 1) * row;
  const Lanes *x = net.x, *y = net.y;
  const int c01 = dv, c10 = du * row, c11 = count - 1;
  const Lanes scale_u(0.5 / du), scale_v(0.5 / dv);
  const Lanes ax = ((x[c10] - x[0]) + (x[c11] - x[c01])) * scale_u;
  const Lanes ay = ((y[c10] - y[0]) + (y[c11] - y[c01])) * scale_u;
  const Lanes bx = ((x[c01] - x[0]) + (x[c11] - x[c10])) * scale_v;
  const Lanes by = ((y[c01] - y[0]) + (y[c11] - y[c10])) * scale_v;
  const Lanes det = cross_2(ax, ay, bx, by);
  Lanes low_u = det, high_u = det, low_v = det, high_v = det;
  Lanes ux(0.0), uy(0.0), vx(0.0), vy(0.0);
  for (int k = 0; k + row < count; ++k) {
    const Lanes px = x[k + row] - x[k], py = y[k + row] - y[k];
    const Lanes c = cross_2(px, py, bx, by);
    low_u = smaller_of(low_u, c), high_u = larger_of(high_u, c);
    ux = larger_of(ux, abs(px - ax)), uy = larger_of(uy, abs(py - ay));
  }
  Lanes sum_x(0.0), sum_y(0.0);
  for (int i = 0, k = 0; i <= du; ++i, ++k) {
    for (int j = 0; j < dv; ++j, ++k) {
      const Lanes px = x[k + 1] - x[k], py = y[k + 1] - y[k];
      const Lanes c = cross_2(ax, ay, px, py);
      low_v = smaller_of(low_v, c), high_v = larger_of(high_v, c);
      vx = larger_of(vx, abs(px - bx)), vy = larger_of(vy, abs(py - by));
      sum_x = sum_x + x[k], sum_y = sum_y + y[k];
    }
    sum_x = sum_x + x[k], sum_y = sum_y + y[k];
  }
  // The differences may be off by a few times the noise.
  const Lanes far = (abs(ax) + ux) + (abs(ay) + uy) + (abs(bx) + vx) + (abs(by) + vy);
  const Lanes margin = mul_add(ux, vy, uy * vx) + Lanes(8.0) * noise * (far + noise);
  Prospect p;
  p.one = ((low_u + low_v) - det > margin) | ((high_u + high_v) - det < Lanes(0.0) - margin);
  const Lanes inverse = Lanes(1.0) / (det * Lanes(static_cast<double>(count)));
  p.u = Lanes(0.5) - cross_2(sum_x, sum_y, bx, by) * inverse * Lanes(1.0 / du);
  p.v = Lanes(0.5) - cross_2(ax, ay, sum_x, sum_y) * inverse * Lanes(1.0 / dv);
  return p;
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
