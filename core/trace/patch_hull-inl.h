// Does a line miss what it seems to graze? A leaf's control net, projected along the line a lane has, against
// the origin, and the nets of its parts. Included once per Highway target.
#if defined(TRIMRAY_CORE_TRACE_PATCH_HULL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_TRACE_PATCH_HULL_INL_H_
#undef TRIMRAY_CORE_TRACE_PATCH_HULL_INL_H_
#else
#define TRIMRAY_CORE_TRACE_PATCH_HULL_INL_H_
#endif

#include "core/trace/patch_eval-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

// Homogeneous control points in two directions across each lane's line: a root is where both vanish.
struct ProjectedNet {
  static constexpr int kMaxPoints = (trace::kMaxPowerDegree + 1) * (trace::kMaxPowerDegree + 1);
  Lanes x[kMaxPoints], y[kMaxPoints];
};

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
HWY_NOINLINE inline Mask beside_origin(const NetView& net, int count, Lanes noise) {
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
  for (int k = 1; k < count; ++k) {
    const Lanes s = mul_add(mx, net.x[k], my * net.y[k]);
    low = select(s < low, s, low);
  }
  // A NaN point leaves `low` as it is or makes the axis NaN; points are finite where the ray and the patch
  // are.
  return noise * (abs(mx) + abs(my)) < low;
}

// Lanes of `open` whose line meets none of the 2^depth parts of the net.
HWY_NOINLINE inline Mask beside_parts(const NetView& net, int du, int dv, bool in_u, int depth, Lanes noise,
                                      Mask open) {
  Mask out = open & beside_origin(net, (du + 1) * (dv + 1), noise);
  if (depth == 0) return out;
  const Mask rest = and_not(out, open);
  if (none(rest)) return out;
  ProjectedNet storage;
  const NetView upper{storage.x, storage.y};
  halve_net(net, upper, du, dv, in_u);
  const Mask low = beside_parts(net, du, dv, !in_u, depth - 1, noise, rest);
  if (none(low)) return out;
  return out | beside_parts(upper, du, dv, !in_u, depth - 1, noise, low);
}

// Lanes of `open` that certainly miss the leaf. o: the ray's point next to the patch's origin, relative to
// it.
HWY_NOINLINE inline Mask misses_leaf(const trace::Patch& patch, const dvec4* points,
                                     const trace::LeafBound& leaf, const Vec3& o, const Vec3& d, Mask open) {
  constexpr int kDepth = 3;
  const int du = patch.degree_u, dv = patch.degree_v, count = (du + 1) * (dv + 1);
  // Across the line: as near to the leaf's normal as can be, and at right angles.
  const Vec3 n{Lanes(leaf.ab[0]), Lanes(leaf.ab[1]), Lanes(leaf.ab[2])};
  Vec3 a = neg_mul_add(dot(n, d), d, n);
  a = a * (Lanes(1.0) / sqrt(dot(a, a)));
  a = neg_mul_add(dot(a, d), d, a);  // once more: next to the normal the first one leaves little but rounding
  const Vec3 b = cross(d, a);
  ProjectedNet net;
  const Lanes oa = dot(o, a), ob = dot(o, b);
  for (int k = 0; k < count; ++k) {
    const Vec3 p{Lanes(points[k].x), Lanes(points[k].y), Lanes(points[k].z)};
    const Lanes w(points[k].w);
    net.x[k] = neg_mul_add(w, oa, dot(p, a)), net.y[k] = neg_mul_add(w, ob, dot(p, b));
  }
  const double reach_u = leaf.half_u * (1.0 + 1e-7) + trace::kLeafSlack,
               reach_v = leaf.half_v * (1.0 + 1e-7) + trace::kLeafSlack;
  restrict_leaf({net.x, net.y}, du, dv, leaf.mid_u - reach_u, leaf.mid_u + reach_u, leaf.mid_v - reach_v,
                leaf.mid_v + reach_v);
  const Lanes noise = Lanes(2e-14 * patch.max_weight) * (Lanes(patch.size) + sqrt(dot(o, o)));
  const double size_u = leaf.a[0] * leaf.a[0] + leaf.a[1] * leaf.a[1] + leaf.a[2] * leaf.a[2];
  const double size_v = leaf.b[0] * leaf.b[0] + leaf.b[1] * leaf.b[1] + leaf.b[2] * leaf.b[2];
  return beside_parts({net.x, net.y}, du, dv, size_u >= size_v, kDepth, noise, open);
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
