#include "core/trace/newton_seeded.h"

#include <algorithm>
#include <bit>

#include "core/base/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/newton_seeded.cpp"
#include <hwy/foreach_target.h>

#include "core/base/simd.h"
#include "core/trace/newton-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

using trace::ParamCurve;
using trace::PatchPool;
using trace::SeededRoots;
using trace::SeedLanes;

HWY_INLINE Lanes larger(Lanes a, Lanes b) { return select(a > b, a, b); }

// From uv_face to the patch's parameter, roughly where there is a map: within 2 % of a patch of a half turn.
HWY_INLINE Lanes seed_parameter(const ParamCurve& curve, Lanes u) {
  if (curve.map != nurbs::ParamMap::kIdentity) {
    // The tangent's, or the hyperbolic tangent's, series; the ends stay where they are.
    const double sign = curve.map == nurbs::ParamMap::kCircular ? 1.0 : -1.0, half = 0.5 * curve.d;
    const double cubic = sign / 3.0, quintic = 2.0 / 15.0, end = 0.5 * half, end2 = end * end;
    const double scale = half / (end * (1.0 + end2 * (cubic + end2 * quintic)));
    const Lanes middle(curve.a + half), x = (u - middle) * Lanes(0.5), x2 = x * x;
    const Lanes factor = mul_add(x2, mul_add(x2, Lanes(quintic), Lanes(cubic)), Lanes(1.0));
    u = mul_add(x * factor, Lanes(scale), middle);
  }
  return (u - Lanes(curve.s0)) * Lanes(1.0 / curve.ds);
}

// Into the patch; NaN becomes 0.
HWY_INLINE Lanes into_patch(Lanes x) {
  return select(x > Lanes(0.0), select(x < Lanes(1.0), x, Lanes(1.0)), Lanes(0.0));
}

// Would all iterates within `error` of x be rounded to one grid point?
HWY_INLINE Mask one_grid_point(Lanes x, Lanes error, std::uint32_t poles, Lanes m) {
  const Lanes low = x - error, high = x + error;
  if (poles == 0) return to_grid(high, m) <= to_grid(low, m);
  // m moves with the iterate, and with it the grid, at powers of two.
  const Lanes less = m * Lanes(1.0 - 1e-6), more = m * Lanes(1.0 + 1e-6);
  const Lanes a = to_grid(low, less), b = to_grid(high, less), c = to_grid(low, more),
              d = to_grid(high, more);
  return (b <= a) & (c <= b) & (b <= c) & (d <= c) & (c <= d);
}

// The lanes whose bits every other start that converges to this root would give, under solve_leaf's rule.
HWY_INLINE Mask certain(const Patch& patch, const Roots& r, const Stretch& stretch) {
  const Scale scale = scale_at(patch.poles, r.u, r.v);
  // What a step leaves: by Kantorovich's theorem a root lies within twice a step where stretch * bend * step
  // is below 1/4, and no further from its end than stretch * bend * step^2. Twice, for another start may have
  // come from elsewhere; and rounding of both residuals.
  const Lanes step = larger(scale.step_u, scale.step_v) + Lanes(4.0 * trace::kRootGrid);
  const Lanes residual =
      mul_add(Lanes(2.5 * patch.bend) * step, step, Lanes(6e-15 * patch.size * patch.max_weight));
  const Lanes margin = Lanes(trace::kRootGrid / 4096) * scale.m;
  return r.converged & one_grid_point(r.u, mul_add(stretch.u, residual, margin), patch.poles, scale.m) &
         one_grid_point(r.v, mul_add(stretch.v, residual, margin), patch.poles, scale.m);
}

// The leaf whose part of the patch holds (u, v).
HWY_INLINE std::int32_t leaf_at(const PatchPool& pool, const Patch& patch, double u, double v) {
  const auto cell = [](double x, int log) {
    return static_cast<std::int32_t>(std::min(std::max(x, 0.0), 1.0) * (1 << log)) - (x >= 1.0 ? 1 : 0);
  };
  std::int32_t place =
      pool.leaf_cells[patch.cells + (cell(u, patch.log_u) << patch.log_v) + cell(v, patch.log_v)];
  while (place >= 0) {
    const trace::LeafSplit& split = pool.splits[place];
    place = split.child[(split.in_u ? u : v) >= static_cast<double>(split.at)];
  }
  return ~place;
}

struct SeededWork {
  const Patch& patch;
  const PatchPool& pool;
  const RayLanes& rays;
  const SeedLanes& seeds;
  SeededRoots& out;

  template <typename Form>
  HWY_INLINE void operator()(const Form& form) {
    for (int first = 0; first < trace::kLanes; first += kWidth) {
      const std::uint32_t wanted = (rays.active >> first) & ((1u << kWidth) - 1u);
      if (wanted == 0) continue;
      const RayFrame ray = near_patch(patch, rays, first);
      const Lanes start[2] = {into_patch(seed_parameter(patch.u, load(seeds.u + first))),
                              into_patch(seed_parameter(patch.v, load(seeds.v + first)))};
      const Lanes longest[2] = {Lanes(0.25), Lanes(0.25)};
      Roots r;
      Stretch stretch;
      newton(form, patch.poles, ray, start, longest, trace::kMaxSeededSteps, mask_from_bits(wanted),
             out.steps, r, &stretch);
      store(r.u, out.param_u + first), store(r.v, out.param_v + first), store(r.t, out.t + first);
      store(r.normal.x, out.normal_x + first), store(r.normal.y, out.normal_y + first);
      store(r.normal.z, out.normal_z + first);
      settle(first, ray, r, bits(certain(patch, r, stretch)));
    }
  }

  // Neighbouring rays mostly meet the same leaf.
  HWY_INLINE void settle(int first, const RayFrame& ray, const Roots& r, std::uint32_t pending) {
    while (pending != 0) {
      const int i = first + std::countr_zero(pending);
      const std::int32_t index = leaf_at(pool, patch, out.param_u[i], out.param_v[i]);
      const LeafBound& leaf = pool.bounds[index];
      const Mask on = (abs(r.u - Lanes(leaf.mid_u)) <= Lanes(leaf.half_u + trace::kLeafSlack)) &
                      (abs(r.v - Lanes(leaf.mid_v)) <= Lanes(leaf.half_v + trace::kLeafSlack));
      const std::uint32_t here = bits(on) & pending;
      for (std::uint32_t rest = here; rest != 0; rest &= rest - 1)
        out.leaf[first + std::countr_zero(rest)] = index;
      out.one |= (here & bits(proof_of(leaf, ray.d).holds)) << first;
      pending &= ~here & (pending - 1);
    }
  }
};

void seeded_entry(const Patch& patch, const PatchPool& pool, const RayLanes& rays, const SeedLanes& seeds,
                  SeededRoots& out) {
  SeededWork work{patch, pool, rays, seeds, out};
  with_form(patch, pool.coef.data() + patch.coef, work);
}

std::uint32_t beside_entry(const LeafBound& leaf, const RayLanes& rays, const double* param_u,
                           const double* param_v) {
  std::uint32_t result = 0;
  // Parameters of a root that another start found may differ in their last bits.
  const Lanes least_u(leaf.half_u + 2.0 * trace::kLeafSlack), least_v(leaf.half_v + 2.0 * trace::kLeafSlack);
  const double reach = trace::kExtend * (1.0 - 1e-6);
  for (int first = 0; first < trace::kLanes; first += kWidth) {
    const Vec3 d{load(rays.dir_x + first), load(rays.dir_y + first), load(rays.dir_z + first)};
    const Lanes off_u = abs(load(param_u + first) - Lanes(leaf.mid_u));
    const Lanes off_v = abs(load(param_v + first) - Lanes(leaf.mid_v));
    const Mask beside = ((off_u > least_u) | (off_v > least_v)) & (off_u <= Lanes(leaf.half_u * reach)) &
                        (off_v <= Lanes(leaf.half_v * reach)) & proof_of(leaf, d).holds;
    result |= bits(beside) << first;
  }
  return result & rays.active;
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray {

HWY_EXPORT(seeded_entry);
HWY_EXPORT(beside_entry);

namespace trace {

void solve_from_seeds(const Patch& patch, const PatchPool& pool, const RayLanes& rays, const SeedLanes& seeds,
                      SeededRoots& out) {
  out.one = out.steps = 0;
  if (patch.offset != 0.0) return;  // its leaves claim no uniqueness
  HWY_DYNAMIC_DISPATCH(seeded_entry)(patch, pool, rays, seeds, out);
  for (std::uint32_t m = out.one; m != 0; m &= m - 1) {
    const int i = std::countr_zero(m);
    out.u[i] = patch.u.to_face(out.param_u[i]);
    out.v[i] = patch.v.to_face(out.param_v[i]);
  }
}

std::uint32_t lies_beside(const LeafBound& leaf, const RayLanes& rays, const double* param_u,
                          const double* param_v) {
  return HWY_DYNAMIC_DISPATCH(beside_entry)(leaf, rays, param_u, param_v);
}

}  // namespace trace
}  // namespace trimray
#endif
