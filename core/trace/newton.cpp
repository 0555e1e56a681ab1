#include "core/trace/newton.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/newton.cpp"
#include <hwy/foreach_target.h>

#include "core/base/simd.h"
#include "core/trace/newton-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

using trace::RootLanes;

template <typename Form>
HWY_INLINE void solve_form(const Form& form, const Patch& patch, const LeafBound& leaf, const RayLanes& rays,
                           RootLanes& out) {
  const Vec3 center = broadcast(leaf.center), a = broadcast(leaf.a), b = broadcast(leaf.b),
             k = broadcast(leaf.k);
  const Lanes half_u(leaf.half_u), half_v(leaf.half_v), mid_u(leaf.mid_u), mid_v(leaf.mid_v);
  // Rounding of the products with g: where the ray runs along an axis, all that it is compared with vanishes.
  const auto slack = [&](const double(&x)[3]) HWY_ATTR {
    return Lanes(4e-15 * patch.size * (std::fabs(x[0]) + std::fabs(x[1]) + std::fabs(x[2])));
  };
  const Lanes slack_a = slack(leaf.a), slack_b = slack(leaf.b), slack_k = slack(leaf.k);
  for (int first = 0; first < trace::kLanes; first += kWidth) {
    const std::uint32_t wanted = (rays.active >> first) & ((1u << kWidth) - 1u);
    if (wanted == 0) continue;
    const RayFrame ray = near_patch(patch, rays, first);
    // Separating axes dir x a, dir x b, dir x k: most misses end here.
    const Vec3 g = cross(center - ray.o, ray.d);
    const Proof proof = proof_of(leaf, ray.d);
    const Lanes den = proof.den, size = proof.size, wide_a = proof.wide_a, wide_b = proof.wide_b;
    const Lanes num_u = dot(g, b), num_v = Lanes(0.0) - dot(g, a);
    const Mask miss = (abs(num_u) > size + wide_b + slack_b) | (abs(num_v) > size + wide_a + slack_a) |
                      (abs(dot(g, k)) > wide_a + wide_b + slack_k);
    const Mask active = mask_from_bits(wanted);
    const Mask go = active & and_not(miss, proof.holds);
    std::uint32_t none_bits = bits(active & miss), one_bits = 0;
    if (!none(go)) {
      const Lanes one(1.0);
      const Lanes start[2] = {mul_add(clamp(num_u / den, one), half_u, mid_u),
                              mul_add(clamp(num_v / den, one), half_v, mid_v)};
      const Lanes max_step[2] = {half_u + half_u, half_v + half_v};
      Roots r;
      newton(form, patch.poles, ray, start, max_step, trace::kMaxNewtonSteps, go, out.steps, r, nullptr);
      const Lanes off_u = abs(r.u - mid_u), off_v = abs(r.v - mid_v);
      const Mask on = r.converged & (off_u <= half_u + Lanes(trace::kLeafSlack)) &
                      (off_v <= half_v + Lanes(trace::kLeafSlack));
      const Lanes reach(trace::kExtend * (1.0 - 1e-6));
      const Mask beside = r.converged & (off_u <= half_u * reach) & (off_v <= half_v * reach);
      one_bits = bits(on);
      none_bits |= bits(and_not(on, beside));
      store(r.u, out.param_u + first), store(r.v, out.param_v + first), store(r.t, out.t + first);
      store(r.normal.x, out.normal_x + first), store(r.normal.y, out.normal_y + first);
      store(r.normal.z, out.normal_z + first);
    }
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
  newton(form, patch.poles, near_patch(patch, rays, 0), from, limit, trace::kMaxNewtonSteps,
         mask_from_bits(1), steps, r, nullptr);
  double x[6][8];
  store(r.u, x[0]), store(r.v, x[1]), store(r.t, x[2]);
  store(r.normal.x, x[3]), store(r.normal.y, x[4]), store(r.normal.z, x[5]);
  root = {x[0][0], x[1][0], x[2][0], dvec3(x[3][0], x[4][0], x[5][0])};
  return (bits(r.converged) & 1u) != 0;
}

struct SolveWork {
  const Patch& patch;
  const LeafBound& leaf;
  const RayLanes& rays;
  RootLanes& out;
  template <typename Form>
  HWY_INLINE void operator()(const Form& form) {
    solve_form(form, patch, leaf, rays, out);
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

void solve_entry(const Patch& patch, const double* coef, const LeafBound& leaf, const RayLanes& rays,
                 RootLanes& out) {
  SolveWork work{patch, leaf, rays, out};
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

void solve_leaf(const Patch& patch, const double* coef, const LeafBound& leaf, const RayLanes& rays,
                RootLanes& out) {
  out.one = out.none = out.steps = 0;
  HWY_DYNAMIC_DISPATCH(solve_entry)(patch, coef, leaf, rays, out);
  for (std::uint32_t m = out.one; m != 0; m &= m - 1) {
    const int i = std::countr_zero(m);
    out.u[i] = patch.u.to_face(out.param_u[i]);
    out.v[i] = patch.v.to_face(out.param_v[i]);
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
