#include "core/trace/newton.h"

#include <algorithm>
#include <bit>

#include "core/base/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/newton.cpp"
#include <hwy/foreach_target.h>

#include "core/base/simd.h"
#include "core/trace/patch_eval-inl.h"
#include "core/trace/patch_hull-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

using trace::LeafBound;
using trace::Patch;
using trace::RayLanes;
using trace::RootLanes;

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
  Vec3 a = s.pu, b = s.pv;
  if (poles != 0) {
    // Near a collapsed side the tangent across the line is tiny, and rounding of g along the line, times the
    // derivative's large part along the line, would drown it.
    a = neg_mul_add(dot(a, ray.d), ray.d, a);
    b = neg_mul_add(dot(b, ray.d), ray.d, b);
  }
  const Lanes inverse = Lanes(1.0) / dot(cross(a, b), ray.d);
  s.du = dot(g, b) * inverse;
  s.dv = (Lanes(0.0) - dot(g, a)) * inverse;
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

// Newton from (u, v) on the active lanes; a lane that has converged keeps still, whatever the others do.
// Not inlined: the evaluator's code stands once for both callers.
template <typename Form>
HWY_NOINLINE void newton(const Form& form, std::uint32_t poles, const RayFrame& ray, const Lanes (&start)[2],
                         const Lanes (&max_step)[2], Mask active, std::uint32_t& steps, Roots& r) {
  Lanes u = start[0], v = start[1];
  Mask open = active, converged = mask_from_bits(0);
  for (int k = 0; k < trace::kMaxNewtonSteps && !none(open); ++k) {
    const Step s = newton_step<Form::kRational>(ray, form.jet(u, v), poles);
    const Lanes du = clamp(s.du, max_step[0]), dv = clamp(s.dv, max_step[1]);
    u = select(open, u + du, u);
    v = select(open, v + dv, v);
    const Scale scale = scale_at(poles, u, v);
    const Mask done = open & (abs(s.du) <= scale.step_u) & (abs(s.dv) <= scale.step_v);  // false for NaN
    converged = converged | done;
    open = and_not(done, open);
    steps += std::popcount(bits(open));
  }
  const Scale scale = scale_at(poles, u, v);
  const Lanes magic = Lanes(1.5 * 4503599627370496.0 * trace::kRootGrid) * scale.m;
  u = (u + magic) - magic;
  v = (v + magic) - magic;
  const Jet jet = form.jet(u, v);
  const Step s = newton_step<Form::kRational>(ray, jet, poles);
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
}

HWY_INLINE Vec3 broadcast(const double (&v)[3]) { return {Lanes(v[0]), Lanes(v[1]), Lanes(v[2])}; }

template <typename Form>
HWY_INLINE void solve_form(const Form& form, const Patch& patch, const dvec4* net, const LeafBound& leaf,
                           const RayLanes& rays, RootLanes& out) {
  const Vec3 center = broadcast(leaf.center), a = broadcast(leaf.a), b = broadcast(leaf.b),
             k = broadcast(leaf.k);
  const Vec3 ab = broadcast(leaf.ab), ak = broadcast(leaf.ak), bk = broadcast(leaf.bk);
  const Lanes half_u(leaf.half_u), half_v(leaf.half_v), mid_u(leaf.mid_u), mid_v(leaf.mid_v);
  for (int first = 0; first < trace::kLanes; first += kWidth) {
    const std::uint32_t wanted = (rays.active >> first) & ((1u << kWidth) - 1u);
    if (wanted == 0) continue;
    const RayFrame ray = near_patch(patch, rays, first);
    // Separating axes dir x a, dir x b, dir x k: most misses end here.
    const Vec3 g = cross(center - ray.o, ray.d);
    const Lanes den = dot(ab, ray.d), size = abs(den);
    const Lanes wide_a = abs(dot(ak, ray.d)), wide_b = abs(dot(bk, ray.d));
    const Lanes num_u = dot(g, b), num_v = Lanes(0.0) - dot(g, a);
    const Mask miss =
        (abs(num_u) > size + wide_b) | (abs(num_v) > size + wide_a) | (abs(dot(g, k)) > wide_a + wide_b);
    const Mask active = mask_from_bits(wanted);
    const Lanes tilt = mul_add(Lanes(leaf.unique_a), wide_a, Lanes(leaf.unique_b) * wide_b);  // may be NaN
    const Mask go = active & and_not(miss, (size > Lanes(leaf.unique)) | (size > tilt));
    std::uint32_t none_bits = bits(active & miss), one_bits = 0;
    if (!none(go)) {
      const Lanes one(1.0);
      const Lanes start[2] = {mul_add(clamp(num_u / den, one), half_u, mid_u),
                              mul_add(clamp(num_v / den, one), half_v, mid_v)};
      const Lanes max_step[2] = {half_u + half_u, half_v + half_v};
      Roots r;
      newton(form, patch.poles, ray, start, max_step, go, out.steps, r);
      const Lanes off_u = abs(r.u - mid_u), off_v = abs(r.v - mid_v);
      const Mask on = r.converged & (off_u <= half_u + Lanes(trace::kLeafSlack)) &
                      (off_v <= half_v + Lanes(trace::kLeafSlack));
      const Lanes reach(trace::kExtend * (1.0 - 1e-6));
      const Mask beside = r.converged & (off_u <= half_u * reach) & (off_v <= half_v * reach);
      one_bits = bits(on);
      none_bits |= bits(and_not(on, beside));
      store(r.u, out.u + first), store(r.v, out.v + first), store(r.t, out.t + first);
      store(r.normal.x, out.normal_x + first), store(r.normal.y, out.normal_y + first);
      store(r.normal.z, out.normal_z + first);
    }
    const std::uint32_t open = wanted & ~(one_bits | none_bits);
    if (open != 0 && patch.power && patch.offset == 0.0)
      none_bits |= bits(misses_leaf(patch, net, leaf, ray.o, ray.d, mask_from_bits(open)));
    out.one |= one_bits << first;
    out.none |= none_bits << first;
  }
}

template <typename Form>
HWY_INLINE bool polish_form(const Form& form, const Patch& patch, const RayLanes& rays, dvec2 start,
                            double max_step, trace::PatchRoot& root) {
  std::uint32_t steps = 0;
  const Lanes from[2] = {Lanes(start.x), Lanes(start.y)}, limit[2] = {Lanes(max_step), Lanes(max_step)};
  Roots r;
  newton(form, patch.poles, near_patch(patch, rays, 0), from, limit, mask_from_bits(1), steps, r);
  double x[6][8];
  store(r.u, x[0]), store(r.v, x[1]), store(r.t, x[2]);
  store(r.normal.x, x[3]), store(r.normal.y, x[4]), store(r.normal.z, x[5]);
  root = {x[0][0], x[1][0], x[2][0], dvec3(x[3][0], x[4][0], x[5][0])};
  return (bits(r.converged) & 1u) != 0;
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

struct SolveWork {
  const Patch& patch;
  const dvec4* net;
  const LeafBound& leaf;
  const RayLanes& rays;
  RootLanes& out;
  template <typename Form>
  HWY_INLINE void operator()(const Form& form) {
    solve_form(form, patch, net, leaf, rays, out);
  }
};

struct PolishWork {
  const Patch& patch;
  const RayLanes& rays;
  dvec2 start;
  double max_step;
  trace::PatchRoot& root;
  bool converged;
  template <typename Form>
  HWY_INLINE void operator()(const Form& form) {
    converged = polish_form(form, patch, rays, start, max_step, root);
  }
};

void solve_entry(const Patch& patch, const dvec4* net, const double* coef, const LeafBound& leaf,
                 const RayLanes& rays, RootLanes& out) {
  SolveWork work{patch, net, leaf, rays, out};
  with_form(patch, coef, work);
}

bool polish_entry(const Patch& patch, const double* coef, const RayLanes& rays, dvec2 start, double max_step,
                  trace::PatchRoot& root) {
  PolishWork work{patch, rays, start, max_step, root, false};
  with_form(patch, coef, work);
  return work.converged;
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray {

HWY_EXPORT(solve_entry);
HWY_EXPORT(polish_entry);

namespace trace {

void solve_leaf(const Patch& patch, const dvec4* net, const double* coef, const LeafBound& leaf,
                const RayLanes& rays, RootLanes& out) {
  out.one = out.none = out.steps = 0;
  HWY_DYNAMIC_DISPATCH(solve_entry)(patch, net, coef, leaf, rays, out);
  for (std::uint32_t m = out.one; m != 0; m &= m - 1) {
    const int i = std::countr_zero(m);
    out.u[i] = patch.u.to_face(out.u[i]);
    out.v[i] = patch.v.to_face(out.v[i]);
  }
}

bool polish(const Patch& patch, const double* coef, const Ray& ray, dvec2 start, double max_step,
            PatchRoot& root) {
  RayLanes rays = {};
  rays.org_x[0] = ray.org.x, rays.org_y[0] = ray.org.y, rays.org_z[0] = ray.org.z;
  rays.dir_x[0] = ray.dir.x, rays.dir_y[0] = ray.dir.y, rays.dir_z[0] = ray.dir.z;
  return HWY_DYNAMIC_DISPATCH(polish_entry)(patch, coef, rays, start, max_step, root);
}

const char* simd_target_name() {
  const std::int64_t targets = hwy::SupportedTargets();  // the best one is the lowest bit
  return hwy::TargetName(targets & -targets);
}

}  // namespace trace
}  // namespace trimray
#endif
