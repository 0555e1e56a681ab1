// Vectors of lanes. Included once per Highway target.
#if defined(TRIMRAY_CORE_TRACE_VEC3_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_TRACE_VEC3_INL_H_
#undef TRIMRAY_CORE_TRACE_VEC3_INL_H_
#else
#define TRIMRAY_CORE_TRACE_VEC3_INL_H_
#endif

#include "core/base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

struct Vec3 {
  Lanes x, y, z;
};
HWY_INLINE Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
HWY_INLINE Vec3 operator*(const Vec3& a, Lanes s) { return {a.x * s, a.y * s, a.z * s}; }
HWY_INLINE Lanes dot(const Vec3& a, const Vec3& b) { return mul_add(a.x, b.x, mul_add(a.y, b.y, a.z * b.z)); }
HWY_INLINE Vec3 cross(const Vec3& a, const Vec3& b) {
  return {neg_mul_add(a.z, b.y, a.y * b.z), neg_mul_add(a.x, b.z, a.z * b.x),
          neg_mul_add(a.y, b.x, a.x * b.y)};
}
HWY_INLINE Vec3 neg_mul_add(Lanes s, const Vec3& a, const Vec3& b) {  // b - s a
  return {neg_mul_add(s, a.x, b.x), neg_mul_add(s, a.y, b.y), neg_mul_add(s, a.z, b.z)};
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
