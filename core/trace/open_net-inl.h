// Control nets of a leaf's parts, projected along the line each lane has: halves, and what they prove about
// roots. Included once per Highway target.
#if defined(TRIMRAY_CORE_TRACE_OPEN_NET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_TRACE_OPEN_NET_INL_H_
#undef TRIMRAY_CORE_TRACE_OPEN_NET_INL_H_
#else
#define TRIMRAY_CORE_TRACE_OPEN_NET_INL_H_
#endif

#include "core/trace/newton-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

// Homogeneous control points, [i][j], in two directions across each lane's line: a root is where both vanish.
struct NetView {
  Lanes *x, *y;
};

HWY_INLINE Lanes mix(Lanes a, Lanes b, Lanes t) { return mul_add(t, b - a, a); }

// restrict_line of patch_net.h in lanes; a < b, both within [-1/2, 3/2].
HWY_INLINE void restrict_lanes(Lanes* c, int n, int stride, double a, double b) {
  const auto keep_left = [&](double t) HWY_ATTR {
    for (int r = 1; r <= n; ++r)
      for (int i = n; i >= r; --i) c[i * stride] = mix(c[(i - 1) * stride], c[i * stride], Lanes(t));
  };
  const auto keep_right = [&](double t) HWY_ATTR {
    for (int r = 1; r <= n; ++r)
      for (int i = 0; i + r <= n; ++i) c[i * stride] = mix(c[i * stride], c[(i + 1) * stride], Lanes(t));
  };
  if (b >= 1.0 - a)
    keep_left(b), keep_right(a / b);
  else
    keep_right(a), keep_left((b - a) / (1.0 - a));
}

// The net over [u0, u1] x [v0, v1].
HWY_INLINE void restrict_leaf(const NetView& net, int du, int dv, double u0, double u1, double v0,
                              double v1) {
  for (int i = 0; i <= du; ++i) {
    restrict_lanes(net.x + i * (dv + 1), dv, 1, v0, v1);
    restrict_lanes(net.y + i * (dv + 1), dv, 1, v0, v1);
  }
  for (int j = 0; j <= dv; ++j) {
    restrict_lanes(net.x + j, du, dv + 1, u0, u1);
    restrict_lanes(net.y + j, du, dv + 1, u0, u1);
  }
}

// Halves of one row or column: in stays the lower half, upper gets the other.
HWY_INLINE void halve_line(Lanes* c, Lanes* upper, int n, int stride) {
  const Lanes half(0.5);
  upper[n * stride] = c[n * stride];
  for (int r = 1; r <= n; ++r) {
    for (int i = n; i >= r; --i) c[i * stride] = (c[(i - 1) * stride] + c[i * stride]) * half;
    upper[(n - r) * stride] = c[n * stride];
  }
}

HWY_INLINE void halve_net(const NetView& net, const NetView& upper, int du, int dv, bool in_u) {
  const int lines = in_u ? dv : du, n = in_u ? du : dv, stride = in_u ? dv + 1 : 1, step = in_u ? 1 : dv + 1;
  for (int k = 0; k <= lines; ++k) {
    halve_line(net.x + k * step, upper.x + k * step, n, stride);
    halve_line(net.y + k * step, upper.y + k * step, n, stride);
  }
}

// Lanes whose net lies strictly on one side of a line through the origin. The points' outermost directions as
// seen from the origin give that side; it is then checked on every point, so that rounding cannot lie.
HWY_INLINE Mask beside_origin(const NetView& net, int count, Lanes noise) {
  Lanes lx = net.x[0], ly = net.y[0], rx = lx, ry = ly;
  for (int k = 1; k < count; ++k) {
    const Lanes x = net.x[k], y = net.y[k];
    const Mask left = Lanes(0.0) < neg_mul_add(ly, x, lx * y),
               right = neg_mul_add(ry, x, rx * y) < Lanes(0.0);
    lx = select(left, x, lx), ly = select(left, y, ly);
    rx = select(and_not(left, right), x, rx), ry = select(and_not(left, right), y, ry);
  }
  const Lanes one(1.0);
  const Lanes il = one / sqrt(mul_add(lx, lx, ly * ly)), ir = one / sqrt(mul_add(rx, rx, ry * ry));
  const Lanes mx = mul_add(lx, il, rx * ir), my = mul_add(ly, il, ry * ir);
  Lanes low = mul_add(mx, net.x[0], my * net.y[0]);
  for (int k = 1; k < count; ++k) low = min_of(mul_add(mx, net.x[k], my * net.y[k]), low);
  // Points are finite where the ray and the patch are; the axis need not be.
  return noise * (abs(mx) + abs(my)) < low;
}

HWY_INLINE Lanes cross_2(Lanes ax, Lanes ay, Lanes bx, Lanes by) { return neg_mul_add(ay, bx, ax * by); }

// Lanes whose points all have one sign in one coordinate: the common way to miss.
HWY_INLINE Mask beside_axes(const NetView& net, int count, Lanes noise) {
  Lanes x0 = net.x[0], x1 = x0, y0 = net.y[0], y1 = y0;
  for (int k = 1; k < count; ++k) {
    x0 = min_of(x0, net.x[k]), x1 = max_of(x1, net.x[k]);
    y0 = min_of(y0, net.y[k]), y1 = max_of(y1, net.y[k]);
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
HWY_INLINE Prospect prospect(const NetView& net, int du, int dv, Lanes noise) {
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
    low_u = min_of(low_u, c), high_u = max_of(high_u, c);
    ux = max_of(ux, abs(px - ax)), uy = max_of(uy, abs(py - ay));
  }
  Lanes sum_x(0.0), sum_y(0.0);
  for (int i = 0, k = 0; i <= du; ++i, ++k) {
    for (int j = 0; j < dv; ++j, ++k) {
      const Lanes px = x[k + 1] - x[k], py = y[k + 1] - y[k];
      const Lanes c = cross_2(ax, ay, px, py);
      low_v = min_of(low_v, c), high_v = max_of(high_v, c);
      vx = max_of(vx, abs(px - bx)), vy = max_of(vy, abs(py - by));
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
