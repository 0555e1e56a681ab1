// One Newton step, the grid that iterates are rounded to, and the last step from it to the answer: what all
// ways from a start to a root share, so that they agree to the bit. Included once per Highway target.
#if defined(TRIMRAY_CORE_TRACE_NEWTON_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_TRACE_NEWTON_INL_H_
#undef TRIMRAY_CORE_TRACE_NEWTON_INL_H_
#else
#define TRIMRAY_CORE_TRACE_NEWTON_INL_H_
#endif

#include "core/trace/newton.h"
#include "core/trace/patch_eval-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

using trace::LeafBound;
using trace::Patch;
using trace::RayLanes;

// Of at most 8 bits; without a call where the machine has no instruction for it.
HWY_INLINE std::uint32_t count_bits(std::uint32_t x) {
  constexpr std::uint64_t kOfNibble = 0x4332322132212110u;
  return ((kOfNibble >> (4 * (x & 15))) & 15) + ((kOfNibble >> (4 * (x >> 4))) & 15);
}

struct RayFrame {
  Vec3 o, d;      // origin closest to the patch's origin, relative to it; direction
  Lanes t_shift;  // t of that point on the caller's ray
};

HWY_INLINE RayFrame near_patch(const Patch& patch, const RayLanes& rays, int first) {
  RayFrame f;
  const Vec3 org{load(rays.org_x + first) - Lanes(patch.origin.x),
                 load(rays.org_y + first) - Lanes(patch.origin.y),
                 load(rays.org_z + first) - Lanes(patch.origin.z)};
  f.d = {load(rays.dir_x + first), load(rays.dir_y + first), load(rays.dir_z + first)};
  f.t_shift = Lanes(0.0) - dot(org, f.d);
  f.o = {mul_add(f.t_shift, f.d.x, org.x), mul_add(f.t_shift, f.d.y, org.y),
         mul_add(f.t_shift, f.d.z, org.z)};
  return f;
}

// The homogeneous residual and its derivatives at one parameter, and the Newton step.
struct Step {
  Vec3 p, pu, pv;  // P - w o, Pu - wu o, Pv - wv o
  Vec3 a, b;       // pu, pv, across the line at poles
  Lanes inverse;   // 1 / (a x b) . d
  Lanes du, dv;
};

template <bool kRational>
HWY_INLINE Step newton_step(const RayFrame& ray, const Jet& jet, std::uint32_t poles) {
  Step s;
  if (kRational) {
    s.p = neg_mul_add(jet.w, ray.o, jet.p);
    s.pu = neg_mul_add(jet.wu, ray.o, jet.pu);
    s.pv = neg_mul_add(jet.wv, ray.o, jet.pv);
  } else {
    s.p = jet.p - ray.o;
    s.pu = jet.pu;
    s.pv = jet.pv;
  }
  const Vec3 g = cross(s.p, ray.d);
  Vec3& a = s.a = s.pu;
  Vec3& b = s.b = s.pv;
  if (poles != 0) {
    // Near a collapsed side the tangent across the line is tiny, and rounding of g along the line, times the
    // derivative's large part along the line, would drown it.
    a = neg_mul_add(dot(a, ray.d), ray.d, a);
    b = neg_mul_add(dot(b, ray.d), ray.d, b);
  }
  s.inverse = Lanes(1.0) / dot(cross(a, b), ray.d);
  s.du = dot(g, b) * s.inverse;
  s.dv = (Lanes(0.0) - dot(g, a)) * s.inverse;
  return s;
}

HWY_INLINE Lanes clamp(Lanes x, Lanes limit) {
  const Lanes low = Lanes(0.0) - limit;
  return select(x > limit, limit, select(x < low, low, x));
}

// How fine things are told apart near a collapsed side at distance m: steps across the side count relative
// to m, and along it rounding alone moves the parameter by 1e-16 / m. m = 1 on other patches.
struct Scale {
  Lanes m, step_u, step_v;  // a step below step_u, step_v is the last but one
};

HWY_INLINE Scale scale_at(std::uint32_t poles, Lanes u, Lanes v) {
  const Lanes one(1.0), small(1e-8), noise(2e-14);
  if (poles == 0) return {one, small, small};
  Lanes m = one;
  if (poles & trace::kSideU0) m = select(abs(u) < m, abs(u), m);
  if (poles & trace::kSideU1) m = select(abs(one - u) < m, abs(one - u), m);
  if (poles & trace::kSideV0) m = select(abs(v) < m, abs(v), m);
  if (poles & trace::kSideV1) m = select(abs(one - v) < m, abs(one - v), m);
  const Lanes across = mul_add(small, m, noise), along = small + noise / (m + noise);
  const bool pole_u = (poles & (trace::kSideU0 | trace::kSideU1)) != 0;
  const bool pole_v = (poles & (trace::kSideV0 | trace::kSideV1)) != 0;
  return {m, pole_v ? along : across, pole_u ? along : across};
}

struct Roots {
  Lanes u, v, t;
  Vec3 normal;
  Mask converged;
};

// x on the grid of the answers: multiples of kRootGrid, or of a power of two near kRootGrid m.
HWY_INLINE Lanes to_grid(Lanes x, Lanes m) {
  const Lanes magic = Lanes(1.5 * 4503599627370496.0 * trace::kRootGrid) * m;
  return (x + magic) - magic;
}

// How far rounding and curvature may have moved the iterate before the last step, per mm of residual.
struct Stretch {
  Lanes u, v;
};

// Newton on the active lanes; a lane that has converged keeps still, whatever the others do. All iterates are
// grid points, so that the last evaluation before a lane converges is mostly that of the answer. Not inlined:
// the evaluator's code stands once for all callers.
template <typename Form>
HWY_NOINLINE void newton(const Form& form, std::uint32_t poles, const RayFrame& ray, const Lanes (&start)[2],
                         const Lanes (&max_step)[2], int max_count, Mask active, std::uint32_t& steps,
                         Roots& r, Stretch* stretch) {
  Scale scale = scale_at(poles, start[0], start[1]);
  Lanes u = to_grid(start[0], scale.m), v = to_grid(start[1], scale.m);
  Mask open = active, converged = mask_from_bits(0);
  Jet jet;
  Step s;
  bool last = false;
  for (int k = 1;; ++k) {
    jet = form.jet(u, v);
    s = newton_step<Form::kRational>(ray, jet, poles);
    if (last) break;
    Lanes next_u = u + clamp(s.du, max_step[0]), next_v = v + clamp(s.dv, max_step[1]);
    scale = scale_at(poles, next_u, next_v);
    const Mask done = open & (abs(s.du) <= scale.step_u) & (abs(s.dv) <= scale.step_v);  // false for NaN
    next_u = to_grid(next_u, scale.m), next_v = to_grid(next_v, scale.m);
    const Mask moved = open & ((next_u < u) | (next_u > u) | (next_v < v) | (next_v > v));
    u = select(open, next_u, u);
    v = select(open, next_v, v);
    converged = converged | done;
    open = and_not(done, open);
    if (none(open) || k == max_count) {
      if (none(moved & converged)) break;
      last = true;
    }
    steps += count_bits(bits(open));
  }
  scale = scale_at(poles, u, v);
  const Lanes limit(4.0 * trace::kRootGrid);
  r.converged = converged & (abs(s.du) <= limit + scale.step_u) & (abs(s.dv) <= limit + scale.step_v);
  r.u = u + s.du;
  r.v = v + s.dv;
  const Lanes along = mul_add(dot(s.pu, ray.d), s.du, mul_add(dot(s.pv, ray.d), s.dv, dot(s.p, ray.d)));
  Vec3 n;
  if (Form::kRational) {
    r.t = ray.t_shift + along / mul_add(jet.wu, s.du, mul_add(jet.wv, s.dv, jet.w));
    const Lanes inverse = Lanes(1.0) / jet.w;
    const Vec3 at = jet.p * inverse;
    n = cross(neg_mul_add(jet.wu, at, jet.pu), neg_mul_add(jet.wv, at, jet.pv));
  } else {
    r.t = ray.t_shift + along;
    n = cross(s.pu, s.pv);
  }
  r.normal = n * (Lanes(1.0) / sqrt(dot(n, n)));
  if (stretch) {
    const Lanes inverse = abs(s.inverse);
    stretch->u = (abs(s.b.x) + abs(s.b.y) + abs(s.b.z)) * inverse;
    stretch->v = (abs(s.a.x) + abs(s.a.y) + abs(s.a.z)) * inverse;
  }
}

HWY_INLINE Vec3 broadcast(const double (&v)[3]) { return {Lanes(v[0]), Lanes(v[1]), Lanes(v[2])}; }

// The proof of uniqueness, and the sizes it is made of, for one leaf.
struct Proof {
  Lanes den, size, wide_a, wide_b;
  Mask holds;
};

HWY_INLINE Proof proof_of(const LeafBound& leaf, const Vec3& d) {
  Proof p;
  p.den = dot(broadcast(leaf.ab), d), p.size = abs(p.den);
  p.wide_a = abs(dot(broadcast(leaf.ak), d)), p.wide_b = abs(dot(broadcast(leaf.bk), d));
  const Lanes tilt = mul_add(Lanes(leaf.unique_a), p.wide_a, Lanes(leaf.unique_b) * p.wide_b);  // may be NaN
  p.holds = (p.size > Lanes(leaf.unique)) | (p.size > tilt);
  return p;
}

// Calls work(form) with the evaluator that fits the patch: unrolled for the common degrees.
template <typename Work>
HWY_INLINE void with_form(const Patch& p, const double* coef, Work& work) {
  if (!p.power) return work(BernsteinForm{coef, p.degree_u, p.degree_v});
#if HWY_NATIVE_FMA
  if (p.degree_u == 3 && p.degree_v == 3) {
    if (p.rational) return work(PowerForm<3, 3, true>{coef});
    return work(PowerForm<3, 3, false>{coef});
  }
#endif
  if (p.rational) return work(PowerForm<0, 0, true>{coef, p.degree_u, p.degree_v});
  return work(PowerForm<0, 0, false>{coef, p.degree_u, p.degree_v});
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
