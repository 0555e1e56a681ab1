#include "core/trace/closed_form_lanes.h"

#include <limits>

#include "core/base/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/closed_form_lanes.cpp"
#include <hwy/foreach_target.h>

#include "core/base/simd.h"
#include "core/trace/angle-inl.h"
#include "core/trace/closed_form_local.h"
#include "core/trace/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

using nurbs::SurfaceKind;
using trace::ClosedForm;
using trace::ClosedRootLanes;
using trace::kLaneRoots;
using trace::RayLanes;

// The ray in the surface's own frame; the origin moves next to the face, so that a far camera costs no digits
// in what follows.
struct LocalRays {
  Vec3 o, d;
  Lanes t0;  // the ray's parameter at o
};

HWY_INLINE Vec3 broadcast(const dvec3& v) { return {Lanes(v.x), Lanes(v.y), Lanes(v.z)}; }

HWY_INLINE LocalRays local_rays(const ClosedForm& form, const RayLanes& rays, int first) {
  const Vec3 org{load(rays.org_x + first), load(rays.org_y + first), load(rays.org_z + first)};
  const Vec3 dir{load(rays.dir_x + first), load(rays.dir_y + first), load(rays.dir_z + first)};
  LocalRays r;
  r.t0 = dot(broadcast(form.reference) - org, dir);
  const Vec3 p = Vec3{mul_add(r.t0, dir.x, org.x), mul_add(r.t0, dir.y, org.y), mul_add(r.t0, dir.z, org.z)} -
                 broadcast(form.location);
  const Vec3 x = broadcast(form.x), y = broadcast(form.y), z = broadcast(form.z);
  r.o = {dot(p, x), dot(p, y), dot(p, z)};
  r.d = {dot(dir, x), dot(dir, y), dot(dir, z)};
  return r;
}

// A root in the surface's frame; t counts from LocalRays::t0.
struct LocalRoots {
  Lanes t;
  Vec3 p;
  Mask valid;
};

HWY_INLINE Mask is_finite(Lanes x) { return abs(x) <= Lanes(std::numeric_limits<double>::max()); }

HWY_INLINE void plane_roots(const LocalRays& ray, LocalRoots& root) {
  root.t = (Lanes(0.0) - ray.o.z) / ray.d.z;
  root.valid = is_finite(root.t);  // a ray along the plane never crosses it
  root.p = {mul_add(root.t, ray.d.x, ray.o.x), mul_add(root.t, ray.d.y, ray.o.y), Lanes(0.0)};
}

// x axis through the ray's closest approach to the axis of a circle of radius r1: the chord is symmetric
// about it. h is the distance of the ray from the axis, so r^2 - h^2 is computed as (r - h)(r + h), which
// keeps its digits where the ray grazes.
HWY_INLINE void cylinder_roots(const ClosedForm& form, const LocalRays& ray,
                               LocalRoots (&roots)[kLaneRoots]) {
  const Vec3 &o = ray.o, &d = ray.d;
  const Lanes r1(form.r1), zero(0.0);
  const Lanes a = mul_add(d.x, d.x, d.y * d.y), inverse = Lanes(1.0) / a;
  const Lanes middle = zero - mul_add(o.x, d.x, o.y * d.y) * inverse;
  const Lanes qx = mul_add(middle, d.x, o.x), qy = mul_add(middle, d.y, o.y);
  const Lanes c =
      neg_mul_add(qy, d.x, qx * d.y) * inverse;  // times (d.y, -d.x): the foot of the perpendicular
  const Lanes h = abs(c) * sqrt(a);
  const Lanes chord = (r1 - h) * (r1 + h);
  // A ray along the axis never crosses; one that touches has no root.
  const Mask valid = (a > Lanes(1e-30)) & (chord > zero);
  const Lanes half = sqrt(chord * inverse);
  for (int i = 0; i < kLaneRoots; ++i) {
    // The foot of the perpendicular, exactly perpendicular to the ray, then along the chord.
    const Lanes s = i == 0 ? zero - half : half;
    LocalRoots& r = roots[i];
    r.t = middle + s;
    r.p = {mul_add(c, d.y, s * d.x), neg_mul_add(c, d.x, s * d.y), mul_add(r.t, d.z, o.z)};
    r.valid = valid;
  }
}

HWY_INLINE void sphere_roots(const ClosedForm& form, const LocalRays& ray, LocalRoots (&roots)[kLaneRoots]) {
  const Lanes r1(form.r1), zero(0.0);
  const Lanes middle = zero - dot(ray.o, ray.d);
  const Vec3 q{mul_add(middle, ray.d.x, ray.o.x), mul_add(middle, ray.d.y, ray.o.y),
               mul_add(middle, ray.d.z, ray.o.z)};
  const Lanes h = sqrt(dot(q, q));
  const Lanes chord = (r1 - h) * (r1 + h);
  const Mask valid = chord > zero;
  const Lanes half = sqrt(chord);
  for (int i = 0; i < kLaneRoots; ++i) {
    const Lanes s = i == 0 ? zero - half : half;
    roots[i] = {
        middle + s, {mul_add(s, ray.d.x, q.x), mul_add(s, ray.d.y, q.y), mul_add(s, ray.d.z, q.z)}, valid};
  }
}

// rho^2 = w^2 with w = r1 + z tan a. In the Minkowski metric (x, y, w) the discriminant is a difference of
// squares of 2x2 minors, computed as a product so that grazing rays keep their digits.
HWY_INLINE void cone_roots(const ClosedForm& form, const LocalRays& ray, LocalRoots (&roots)[kLaneRoots]) {
  const Vec3 &o = ray.o, &d = ray.d;
  const Lanes r1(form.r1), k(form.sin_a / form.cos_a), zero(0.0);
  const Lanes w = mul_add(k, o.z, r1), wd = k * d.z;
  const Lanes a = neg_mul_add(wd, wd, mul_add(d.x, d.x, d.y * d.y));
  const Lanes b = neg_mul_add(w, wd, mul_add(o.x, d.x, o.y * d.y));
  const Lanes c = neg_mul_add(w, w, mul_add(o.x, o.x, o.y * o.y));
  const Lanes m1 = neg_mul_add(w, d.x, o.x * wd), m2 = neg_mul_add(w, d.y, o.y * wd);
  const Lanes m3 = neg_mul_add(o.y, d.x, o.x * d.y);
  const Lanes g = sqrt(mul_add(m1, m1, m2 * m2));
  const Lanes disc = (g - abs(m3)) * (g + abs(m3));
  const Mask crosses = disc > zero;
  const Lanes root = sqrt(disc);
  const Lanes q = select(b > zero, zero - (b + root), root - b);
  const Lanes t0 = q / a, t1 = c / q;
  const Mask swapped = t1 < t0;
  const Lanes t[kLaneRoots] = {select(swapped, t1, t0), select(swapped, t0, t1)};
  const Lanes gap = abs(t[1] - t[0]);
  const Mask apart = is_finite(gap);
  for (int i = 0; i < kLaneRoots; ++i) {
    LocalRoots& r = roots[i];
    r.t = t[i];
    r.valid = crosses & is_finite(t[i]);  // parallel to a generator: one root is at infinity
    // Newton's steps with the residual taken at the root, where it has all its digits. A step beyond the
    // neighbour root's side would leave the basin: a tangent ray keeps what it has.
    Mask going = r.valid;
    for (int step = 0; step <= 2; ++step) {
      r.p = {mul_add(r.t, d.x, o.x), mul_add(r.t, d.y, o.y), mul_add(r.t, d.z, o.z)};
      if (step == 2) break;
      const Lanes wr = mul_add(k, r.p.z, r1);
      const Lanes rho = sqrt(mul_add(r.p.x, r.p.x, r.p.y * r.p.y));
      const Lanes slope = neg_mul_add(wr, wd, mul_add(r.p.x, d.x, r.p.y * d.y));
      const Lanes move = (rho - abs(wr)) * (rho + abs(wr)) / (slope + slope);
      going = going & is_finite(move) & and_not(and_not(abs(move) <= gap * Lanes(1e-3), apart), r.valid);
      r.t = select(going, r.t - move, r.t);
    }
  }
}

// uv and normal of the roots on the surface, and which of them are in the box. The cheap coordinate is tested
// first.
HWY_INLINE void accept(const ClosedForm& form, const LocalRoots& root, const Box2& box, Mask wanted,
                       int first, int k, ClosedRootLanes& out) {
  const Lanes zero(0.0), one(1.0);
  const Vec3& p = root.p;
  const auto within = [](Lanes x, double low, double high)
                          HWY_ATTR { return (Lanes(low) <= x) & (x <= Lanes(high)); };
  const auto in_v = [&](Lanes v) HWY_ATTR { return wanted & within(v, box.lower.y, box.upper.y); };
  Lanes u, v = p.z;
  Vec3 n{zero, zero, one};  // in the surface's frame
  Mask found = wanted;
  if (form.kind == SurfaceKind::kPlane) {
    u = p.x, v = p.y;
    found = in_v(v) & within(u, box.lower.x, box.upper.x);
    if (none(found)) return;
  } else {
    Lanes x = p.x, y = p.y;
    const Lanes rho2 = mul_add(x, x, y * y), rho = sqrt(rho2);
    if (form.kind == SurfaceKind::kCone) {
      v = p.z / Lanes(form.cos_a);
      // Beyond the apex w is negative, and so are the factors of cos u and sin u.
      const Mask beyond = mul_add(v, Lanes(form.sin_a), Lanes(form.r1)) < zero;
      x = select(beyond, zero - x, x), y = select(beyond, zero - y, y);
      n.z = select(beyond, Lanes(form.sin_a), Lanes(-form.sin_a));
      n.x = select(beyond, Lanes(-form.cos_a), Lanes(form.cos_a));
    } else if (form.kind == SurfaceKind::kSphere) {
      v = latitude(p.z, rho);
    }
    found = in_v(v);
    if (none(found)) return;
    u = turn_angle(y, x);
    found = found & in_turn(u, box.lower.x, box.upper.x);
    if (none(found)) return;
    if (form.kind == SurfaceKind::kSphere) {
      n = p * (one / sqrt(mul_add(p.z, p.z, rho2)));
    } else {
      // At the apex the limit along the meridian of u = 0.
      const Lanes inverse = one / rho;
      const Mask apex = rho <= zero;
      const Lanes cos_u = select(apex, one, x * inverse), sin_u = select(apex, zero, y * inverse);
      if (form.kind == SurfaceKind::kCone)
        n = {n.x * cos_u, n.x * sin_u, n.z};
      else
        n = {cos_u, sin_u, zero};
    }
  }
  const Lanes hand(form.hand);
  const Vec3 ax = broadcast(form.x), ay = broadcast(form.y), az = broadcast(form.z);
  const auto world = [&](Lanes x, Lanes y, Lanes z)
                         HWY_ATTR { return hand * mul_add(n.x, x, mul_add(n.y, y, n.z * z)); };
  store(u, out.u[k] + first), store(v, out.v[k] + first);
  store(world(ax.x, ay.x, az.x), out.normal_x[k] + first);
  store(world(ax.y, ay.y, az.y), out.normal_y[k] + first);
  store(world(ax.z, ay.z, az.z), out.normal_z[k] + first);
  out.found[k] |= bits(found) << first;
}

void closed_entry(const ClosedForm& form, const RayLanes& rays, const Box2& box, const double* tmin,
                  const double* tmax, ClosedRootLanes& out) {
  for (int first = 0; first < trace::kLanes; first += kWidth) {
    const std::uint32_t wanted = (rays.active >> first) & ((1u << kWidth) - 1u);
    if (wanted == 0) continue;
    const LocalRays ray = local_rays(form, rays, first);
    LocalRoots roots[kLaneRoots];
    roots[1].valid = mask_from_bits(0), roots[1].t = Lanes(0.0);
    switch (form.kind) {
      case SurfaceKind::kPlane:
        plane_roots(ray, roots[0]);
        break;
      case SurfaceKind::kCylinder:
        cylinder_roots(form, ray, roots);
        break;
      case SurfaceKind::kCone:
        cone_roots(form, ray, roots);
        break;
      case SurfaceKind::kSphere:
        sphere_roots(form, ray, roots);
        break;
      default:
        return;
    }
    const Mask active = mask_from_bits(wanted);
    for (int k = 0; k < kLaneRoots; ++k) {
      const Lanes t = ray.t0 + roots[k].t;
      const Mask in_range = active & roots[k].valid & (load(tmin + first) <= t) & (t <= load(tmax + first));
      if (none(in_range)) continue;
      store(t, out.t[k] + first);
      accept(form, roots[k], box, in_range, first, k, out);
    }
  }
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray {

HWY_EXPORT(closed_entry);

namespace trace {

void closed_form_lanes(const ClosedForm& form, const RayLanes& rays, const Box2& uv, const double* tmin,
                       const double* tmax, ClosedRootLanes& out) {
  for (std::uint32_t& found : out.found) found = 0;
  HWY_DYNAMIC_DISPATCH(closed_entry)(form, rays, uv, tmin, tmax, out);
}

}  // namespace trace
}  // namespace trimray
#endif
