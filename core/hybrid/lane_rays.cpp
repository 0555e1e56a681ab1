#include "core/hybrid/lane_rays.h"

#include <algorithm>

#include "core/base/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/hybrid/lane_rays.cpp"
#include <hwy/foreach_target.h>

#include "core/base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

struct RayLane {
  Lanes x, y, z;
};

// glm's order of operations throughout, and nothing fused.
HWY_INLINE RayLane times(const dmat3& m, const RayLane& v) {
  return {Lanes(m[0][0]) * v.x + Lanes(m[1][0]) * v.y + Lanes(m[2][0]) * v.z,
          Lanes(m[0][1]) * v.x + Lanes(m[1][1]) * v.y + Lanes(m[2][1]) * v.z,
          Lanes(m[0][2]) * v.x + Lanes(m[1][2]) * v.y + Lanes(m[2][2]) * v.z};
}
HWY_INLINE Lanes length2(const RayLane& v) { return v.x * v.x + v.y * v.y + v.z * v.z; }
HWY_INLINE RayLane in_picture(const dvec3& from, const dvec3& right, const dvec3& up, Lanes x, Lanes y) {
  return {Lanes(from.x) + x * Lanes(right.x) + y * Lanes(up.x),
          Lanes(from.y) + x * Lanes(right.y) + y * Lanes(up.y),
          Lanes(from.z) + x * Lanes(right.z) + y * Lanes(up.z)};
}
HWY_INLINE void store(const RayLane& v, double* x, double* y, double* z) {
  store(v.x, x), store(v.y, y), store(v.z, z);
}

void LaneRaysKernel(const view::Camera& c, const hybrid::InstanceView& view, const double* x_px,
                    const double* y_px, trace::RayLanes& rays, hybrid::LaneScales& scales) {
  const trace::InstanceScene& instance = *view.instance;
  for (int i = 0; i < trace::kLanes; i += kWidth) {
    const Lanes x = (load(x_px + i) - Lanes(0.5 * c.width_px)) * Lanes(c.pixel);
    const Lanes y = (Lanes(0.5 * c.height_px) - load(y_px + i)) * Lanes(c.pixel);
    RayLane org, dir;
    Lanes scale(view.scale), depth(1.0);
    if (c.perspective) {
      org = {Lanes(c.eye.x), Lanes(c.eye.y), Lanes(c.eye.z)};
      dir = in_picture(c.forward, c.right, c.up, x, y);
      const Lanes inverse = Lanes(1.0) / sqrt(length2(dir));
      dir = {dir.x * inverse, dir.y * inverse, dir.z * inverse};
      depth = inverse;
      if (!instance.identity) dir = times(instance.to_prototype, dir);
      const Lanes squared = length2(dir);
      const Mask unit = abs(squared - Lanes(1.0)) <= Lanes(trace::kUnitSlack);
      const Lanes length = sqrt(squared);
      scale = select(unit, Lanes(1.0), length);
      dir = {select(unit, dir.x, dir.x / length), select(unit, dir.y, dir.y / length),
             select(unit, dir.z, dir.z / length)};
    } else {
      org = in_picture(c.eye, c.right, c.up, x, y);
      dir = {Lanes(view.dir.x), Lanes(view.dir.y), Lanes(view.dir.z)};
    }
    if (!instance.identity) {
      const dvec3& t = instance.translation;
      org = times(instance.to_prototype, {org.x - Lanes(t.x), org.y - Lanes(t.y), org.z - Lanes(t.z)});
    }
    store(org, rays.org_x + i, rays.org_y + i, rays.org_z + i);
    store(dir, rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    store(scale, scales.scale + i), store(depth, scales.depth + i);
  }
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray {
HWY_EXPORT(LaneRaysKernel);
namespace hybrid {

void lane_rays(const view::Camera& camera, const InstanceView& view, const double* x_px, const double* y_px,
               int count, trace::RayLanes& rays, LaneScales& scales) {
  alignas(64) double x[trace::kLanes], y[trace::kLanes];
  for (int k = 0; k < trace::kLanes; ++k) x[k] = x_px[k < count ? k : 0], y[k] = y_px[k < count ? k : 0];
  HWY_DYNAMIC_DISPATCH(LaneRaysKernel)(camera, view, x, y, rays, scales);
  scales.unit = true;
  for (const double scale : scales.scale) scales.unit &= scale == 1.0;
  rays.active = (1u << count) - 1u;
}

}  // namespace hybrid
}  // namespace trimray
#endif
