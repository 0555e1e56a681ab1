#include "core/trace/open_lanes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <new>

#include "core/base/simd.h"
#include "core/trace/clipping.h"
#include "core/trace/open_work.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/open_lanes.cpp"
#include <hwy/foreach_target.h>

#include "core/base/simd.h"
#include "core/trace/newton-inl.h"
#include "core/trace/open_net-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

using trace::OpenCandidate;
using trace::OpenWork;
using trace::SubDomain;

// Room for nets that outlives the call: count Lanes.
HWY_INLINE Lanes* scratch(std::size_t count) {
  struct Free {
    void operator()(void* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  thread_local std::unique_ptr<void, Free> memory;
  thread_local std::size_t size = 0;
  if (size < count) {
    memory.reset(::operator new (count * sizeof(Lanes), std::align_val_t{64}));
    size = count;
  }
  return static_cast<Lanes*>(memory.get());
}

// Newton on up to kWidth candidates.
template <typename Form>
HWY_INLINE void find_roots(const Form& form, const Patch& patch, const LeafBound& leaf, const RayLanes& rays,
                           const OpenCandidate* candidates, int count, OpenWork& work) {
  RayLanes own;
  double start[4][trace::kLanes];  // u, v, their longest steps
  for (int i = 0; i < kWidth; ++i) {
    const OpenCandidate& c = candidates[i < count ? i : 0];
    own.org_x[i] = rays.org_x[c.lane], own.org_y[i] = rays.org_y[c.lane], own.org_z[i] = rays.org_z[c.lane];
    own.dir_x[i] = rays.dir_x[c.lane], own.dir_y[i] = rays.dir_y[c.lane], own.dir_z[i] = rays.dir_z[c.lane];
    start[0][i] = c.u, start[1][i] = c.v;
    start[2][i] = c.part.u1 - c.part.u0, start[3][i] = c.part.v1 - c.part.v0;
  }
  const Lanes from[2] = {load(start[0]), load(start[1])}, limit[2] = {load(start[2]), load(start[3])};
  Roots r;
  newton(form, patch.poles, near_patch(patch, own, 0), from, limit, trace::kMaxNewtonSteps,
         mask_from_bits((1u << count) - 1u), work.stats.steps, r, nullptr);
  double x[6][trace::kLanes];
  store(r.u, x[0]), store(r.v, x[1]), store(r.t, x[2]);
  store(r.normal.x, x[3]), store(r.normal.y, x[4]), store(r.normal.z, x[5]);
  const std::uint32_t converged = bits(r.converged);
  const SubDomain core = trace::core_of(leaf);
  for (int i = 0; i < count; ++i) {
    const OpenCandidate& c = candidates[i];
    const dvec3 n(x[3][i], x[4][i], x[5][i]);
    if ((converged >> i & 1u) == 0 || !trace::contains(c.part, x[0][i], x[1][i])) {
      work.search(c.lane, c.part);
    } else if (trace::contains(core, x[0][i], x[1][i])) {
      // Where two roots nearly coincide, only the same steps give the same bits.
      const double slope = glm::dot(n, dvec3(own.dir_x[i], own.dir_y[i], own.dir_z[i]));
      if (!(std::fabs(slope) > trace::kTangent)) work.whole |= 1u << c.lane;
      work.roots.push_back({c.lane, {x[0][i], x[1][i], x[2][i], n}});
    }
  }
}

// Degrees 0: known at run time only.
template <int kDegreeU, int kDegreeV>
class OpenSearch {
 public:
  OpenSearch(const Patch& patch, const dvec4* points, const double* coef, const LeafBound& leaf,
             const RayLanes& rays, int first, OpenWork& work)
      : patch_(patch), points_(points), coef_(coef), leaf_(leaf), rays_(rays), first_(first), work_(work) {}

  HWY_INLINE void run(std::uint32_t active) {
    const RayFrame ray = near_patch(patch_, rays_, first_);
    const std::uint32_t poles = active & bits(meets_pole(ray));
    work_.whole |= poles << first_;
    active &= ~poles;
    if (active == 0) return;
    Lanes* room = scratch(static_cast<std::size_t>(2 * count()) * (trace::kMaxHalvings + 1));
    const NetView net = take(room);
    const SubDomain whole = project(ray, net);
    visit(net, room, whole, 0, mask_from_bits(active));
    flush();
  }

  template <typename Form>
  HWY_INLINE void operator()(const Form& form) {
    for (int k = 0; k < queued_; k += kWidth)
      find_roots(form, patch_, leaf_, rays_, queue_ + k, std::min(kWidth, queued_ - k), work_);
  }

 private:
  HWY_INLINE int du() const { return kDegreeU ? kDegreeU : patch_.degree_u; }
  HWY_INLINE int dv() const { return kDegreeV ? kDegreeV : patch_.degree_v; }
  HWY_INLINE int count() const { return (du() + 1) * (dv() + 1); }

  HWY_INLINE NetView take(Lanes*& room) const {
    const NetView net{room, room + count()};
    room += 2 * count();
    return net;
  }

  // Lines so near a collapsed side's point that clip_roots may find that.
  HWY_INLINE Mask meets_pole(const RayFrame& ray) const {
    Mask met = mask_from_bits(0);
    if (patch_.poles == 0) return met;
    const Lanes reach(4.0 * patch_.pole_reach * patch_.pole_reach);
    const int corner[4] = {0, du() * (dv() + 1), 0, dv()};
    for (int side = 0; side < 4; ++side) {
      if ((patch_.poles >> side & 1) == 0) continue;
      const dvec4& h = points_[corner[side]];
      const Vec3 p{Lanes(h.x / h.w), Lanes(h.y / h.w), Lanes(h.z / h.w)};
      const Vec3 off = cross(p - ray.o, ray.d);
      met = met | (dot(off, off) <= reach);
    }
    return met;
  }

  // The leaf's net; returns the part of the patch it stands for.
  HWY_INLINE SubDomain project(const RayFrame& ray, const NetView& net) {
    // Across the line: as near to the leaf's normal as can be, and at right angles.
    const Vec3& d = ray.d;
    const auto across = [&](const Vec3& n) HWY_ATTR { return neg_mul_add(dot(n, d), d, n); };
    const Vec3 normal = broadcast(leaf_.ab), tangent = broadcast(leaf_.a);
    const Vec3 a0 = across(normal), a1 = across(tangent);
    const Mask steep = dot(a0, a0) <= Lanes(1e-3) * dot(normal, normal);
    Vec3 a{select(steep, a1.x, a0.x), select(steep, a1.y, a0.y), select(steep, a1.z, a0.z)};
    a = a * (Lanes(1.0) / sqrt(dot(a, a)));
    const Vec3 b = cross(d, a);
    const Lanes oa = dot(ray.o, a), ob = dot(ray.o, b);
    for (int k = 0; k < count(); ++k) {
      const Vec3 p{Lanes(points_[k].x), Lanes(points_[k].y), Lanes(points_[k].z)};
      const Lanes w(points_[k].w);
      net.x[k] = neg_mul_add(w, oa, dot(p, a)), net.y[k] = neg_mul_add(w, ob, dot(p, b));
    }
    noise_ = Lanes(2e-14 * patch_.max_weight) * (Lanes(patch_.size) + sqrt(dot(ray.o, ray.o)));
    const double reach_u = leaf_.half_u * (1.0 + 1e-7) + trace::kLeafSlack,
                 reach_v = leaf_.half_v * (1.0 + 1e-7) + trace::kLeafSlack;
    const SubDomain part{leaf_.mid_u - reach_u, leaf_.mid_u + reach_u, leaf_.mid_v - reach_v,
                         leaf_.mid_v + reach_v};
    restrict_leaf(net, du(), dv(), part.u0, part.u1, part.v0, part.v1);
    return part;
  }

  void visit(const NetView& net, Lanes* room, const SubDomain& part, int halvings, Mask open) {
    const auto whole = mask_from_bits(work_.whole >> first_);
    open = and_not(whole, open);
    if (none(open)) return;
    ++work_.stats.parts;
    open = and_not(beside_axes(net, count(), noise_), open);
    if (none(open)) return;
    open = and_not(beside_origin(net, count(), noise_), open);
    if (none(open)) return;
    const Prospect p = prospect(net, du(), dv(), noise_);
    const Lanes zero(0.0), one(1.0);
    const Mask found = open & p.one & (zero <= p.u) & (p.u <= one) & (zero <= p.v) & (p.v <= one);
    if (!none(found)) {
      double u[trace::kLanes], v[trace::kLanes];
      store(p.u, u), store(p.v, v);
      for (std::uint32_t rest = bits(found); rest != 0; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        if (queued_ == kQueue) flush();
        queue_[queued_++] = {first_ + i, part.u0 + (part.u1 - part.u0) * u[i],
                             part.v0 + (part.v1 - part.v0) * v[i], part};
      }
      open = and_not(found, open);
      if (none(open)) return;
    }
    if (halvings == trace::kMaxHalvings) {
      work_.whole |= bits(open) << first_;
      return;
    }
    const double wu = part.u1 - part.u0, wv = part.v1 - part.v0;
    const double bend_u = patch_.bend_uu * wu * wu, bend_v = patch_.bend_vv * wv * wv;
    // A part bent alike in both directions, or in none, is halved where it is longer.
    const bool in_u = bend_u > 2.0 * bend_v || (2.0 * bend_u >= bend_v && size_u_ * wu >= size_v_ * wv);
    const NetView upper = take(room);
    halve_net(net, upper, du(), dv(), in_u);
    SubDomain low = part, high = part;
    if (in_u)
      low.u1 = high.u0 = 0.5 * (part.u0 + part.u1);
    else
      low.v1 = high.v0 = 0.5 * (part.v0 + part.v1);
    visit(net, room, low, halvings + 1, open);
    visit(upper, room, high, halvings + 1, open);
  }

  void flush() {
    if (queued_ > 0) with_form(patch_, coef_, *this);
    queued_ = 0;
  }

  static double length(const double (&v)[3]) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

  static constexpr int kQueue = 64;
  const Patch& patch_;
  const dvec4* const points_;
  const double* const coef_;
  const LeafBound& leaf_;
  const RayLanes& rays_;
  const int first_;
  const double size_u_ = length(leaf_.a) / leaf_.half_u,
               size_v_ = length(leaf_.b) / leaf_.half_v;  // per unit of the parameter
  OpenWork& work_;
  Lanes noise_;
  OpenCandidate queue_[kQueue];
  int queued_ = 0;
};

void open_entry(const Patch& patch, const dvec4* points, const double* coef, const LeafBound& leaf,
                const RayLanes& rays, OpenWork& work) {
  for (int first = 0; first < trace::kLanes; first += kWidth) {
    const std::uint32_t active = (rays.active >> first) & ((1u << kWidth) - 1u);
    if (active == 0) continue;
    if (patch.degree_u == 3 && patch.degree_v == 3)
      OpenSearch<3, 3>(patch, points, coef, leaf, rays, first, work).run(active);
    else
      OpenSearch<0, 0>(patch, points, coef, leaf, rays, first, work).run(active);
  }
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray {

HWY_EXPORT(open_entry);

namespace trace {
namespace {

Ray lane_ray(const RayLanes& rays, int i) {
  return {{rays.org_x[i], rays.org_y[i], rays.org_z[i]}, {rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]}};
}

// The same root from two parts counts once, by the rule of clip_roots.
void add(std::vector<LanePatchRoot>& roots, std::size_t begin, const LanePatchRoot& found, const Ray& ray) {
  for (std::size_t k = begin; k < roots.size(); ++k) {
    const PatchRoot &r = roots[k].root, &f = found.root;
    if (roots[k].lane == found.lane && std::fabs(r.u - f.u) <= 1e-10 && std::fabs(r.v - f.v) <= 1e-10 &&
        glm::dot(r.normal, ray.dir) * glm::dot(f.normal, ray.dir) > 0.0)
      return;
  }
  roots.push_back(found);
}

// The part of the leaf as a leaf of its own, for clip_roots.
LeafBound bound_of(const LeafBound& leaf, const SubDomain& part) {
  const SubDomain core = core_of(leaf);
  const double u0 = std::max(part.u0, core.u0), u1 = std::min(part.u1, core.u1);
  const double v0 = std::max(part.v0, core.v0), v1 = std::min(part.v1, core.v1);
  LeafBound bound = leaf;
  bound.mid_u = 0.5 * (u0 + u1), bound.half_u = 0.5 * (u1 - u0);
  bound.mid_v = 0.5 * (v0 + v1), bound.half_v = 0.5 * (v1 - v0);
  return bound;
}

}  // namespace

OpenStats open_lane_roots(const Patch& patch, const PatchPool& pool, const LeafBound& leaf,
                          const RayLanes& rays, std::vector<LanePatchRoot>& roots) {
  thread_local OpenWork work;
  thread_local std::vector<PatchRoot> found;
  work.clear();
  HWY_DYNAMIC_DISPATCH(open_entry)
  (patch, pool.net.data() + patch.net, pool.coef.data() + patch.coef, leaf, rays, work);
  const std::size_t begin = roots.size();
  for (const LanePatchRoot& r : work.roots)
    if ((work.whole >> r.lane & 1u) == 0) add(roots, begin, r, lane_ray(rays, r.lane));
  const auto search = [&](int lane, const LeafBound& bound) {
    const Ray ray = lane_ray(rays, lane);
    found.clear();
    ++work.stats.searched;
    work.stats.exhausted += clip_roots(patch, pool, bound, ray, found).exhausted;
    for (const PatchRoot& root : found) add(roots, begin, {lane, root}, ray);
  };
  for (const OpenPart& p : work.parts)
    if ((work.whole >> p.lane & 1u) == 0) search(p.lane, bound_of(leaf, p.part));
  for (std::uint32_t rest = work.whole; rest != 0; rest &= rest - 1) search(std::countr_zero(rest), leaf);
  return work.stats;
}

}  // namespace trace
}  // namespace trimray
#endif
