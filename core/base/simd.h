// Eight doubles that compute alike on every machine. The only file of the project that names instruction sets.
//
// Included inside Highway's foreach_target loop, once a target: each pass defines Lanes and Mask in
// trimray::HWY_NAMESPACE. kWidth lanes per Lanes: 8 with AVX-512, 4 with AVX2, 8 doubles in plain C++ where the
// machine has no fused multiply-add. mul_add is fused everywhere and division and sqrt are IEEE, so a lane's
// bits depend neither on the machine nor on the other lanes.
//
//   #define HWY_TARGET_INCLUDE "core/.../this_file.cpp"
//   #include <hwy/foreach_target.h>
//   #include "core/base/simd.h"
#ifndef HWY_DISABLED_TARGETS
// Between the fallback and AVX2 nothing has fused multiply-add: SSSE3 and SSE4 would only cost build time.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4)
#endif
#include <cmath>
#include <cstdint>

#include <hwy/highway.h>

#if defined(TRIMRAY_CORE_BASE_SIMD_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_BASE_SIMD_H_
#undef TRIMRAY_CORE_BASE_SIMD_H_
#else
#define TRIMRAY_CORE_BASE_SIMD_H_
#endif

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

#if HWY_NATIVE_FMA && HWY_HAVE_FLOAT64 && HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;
using LaneTag = hn::CappedTag<double, 8>;
inline constexpr int kWidth = HWY_MAX_BYTES >= 64 ? 8 : HWY_MAX_BYTES >= 32 ? 4 : 2;

struct Mask {
  hn::MFromD<LaneTag> m;
};
struct Lanes {
  hn::VFromD<LaneTag> v;
  Lanes() = default;
  HWY_INLINE Lanes(hn::VFromD<LaneTag> x) : v(x) {}
  HWY_INLINE Lanes(double x) : v(hn::Set(LaneTag(), x)) {}
};

HWY_INLINE Lanes load(const double* p) { return hn::LoadU(LaneTag(), p); }
HWY_INLINE void store(Lanes a, double* p) { hn::StoreU(a.v, LaneTag(), p); }
HWY_INLINE Lanes operator+(Lanes a, Lanes b) { return hn::Add(a.v, b.v); }
HWY_INLINE Lanes operator-(Lanes a, Lanes b) { return hn::Sub(a.v, b.v); }
HWY_INLINE Lanes operator*(Lanes a, Lanes b) { return hn::Mul(a.v, b.v); }
HWY_INLINE Lanes operator/(Lanes a, Lanes b) { return hn::Div(a.v, b.v); }
HWY_INLINE Lanes mul_add(Lanes a, Lanes b, Lanes c) { return hn::MulAdd(a.v, b.v, c.v); }       // a b + c
HWY_INLINE Lanes neg_mul_add(Lanes a, Lanes b, Lanes c) { return hn::NegMulAdd(a.v, b.v, c.v); }  // c - a b
HWY_INLINE Lanes abs(Lanes a) { return hn::Abs(a.v); }
HWY_INLINE Lanes sqrt(Lanes a) { return hn::Sqrt(a.v); }
// Comparisons with NaN are false.
HWY_INLINE Mask operator<(Lanes a, Lanes b) { return {hn::Lt(a.v, b.v)}; }
HWY_INLINE Mask operator<=(Lanes a, Lanes b) { return {hn::Le(a.v, b.v)}; }
HWY_INLINE Mask operator>(Lanes a, Lanes b) { return {hn::Gt(a.v, b.v)}; }
HWY_INLINE Mask operator&(Mask a, Mask b) { return {hn::And(a.m, b.m)}; }
HWY_INLINE Mask operator|(Mask a, Mask b) { return {hn::Or(a.m, b.m)}; }
HWY_INLINE Mask and_not(Mask a, Mask b) { return {hn::AndNot(a.m, b.m)}; }  // b and not a
HWY_INLINE Lanes select(Mask m, Lanes yes, Lanes no) { return hn::IfThenElse(m.m, yes.v, no.v); }
HWY_INLINE bool none(Mask m) { return hn::AllFalse(LaneTag(), m.m); }
HWY_INLINE std::uint32_t bits(Mask m) {
  std::uint8_t b[8] = {};
  hn::StoreMaskBits(LaneTag(), m.m, b);
  return b[0] & ((1u << kWidth) - 1u);
}
HWY_INLINE Mask mask_from_bits(std::uint32_t b) {
  const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(b)};
  return {hn::LoadMaskBits(LaneTag(), bytes)};
}

#else

inline constexpr int kWidth = 8;

struct Mask {
  std::uint32_t m;
};
struct Lanes {
  double v[8];
  Lanes() = default;
  Lanes(double x) {
    for (double& e : v) e = x;
  }
};

#define TRIMRAY_EACH_LANE(expression)                   \
  Lanes r;                                              \
  for (int i = 0; i < 8; ++i) r.v[i] = expression;      \
  return r
#define TRIMRAY_EACH_MASK(expression)                                             \
  Mask r{0};                                                                      \
  for (int i = 0; i < 8; ++i) r.m |= static_cast<std::uint32_t>(expression) << i; \
  return r
inline Lanes load(const double* p) { TRIMRAY_EACH_LANE(p[i]); }
inline void store(const Lanes& a, double* p) {
  for (int i = 0; i < 8; ++i) p[i] = a.v[i];
}
inline Lanes operator+(const Lanes& a, const Lanes& b) { TRIMRAY_EACH_LANE(a.v[i] + b.v[i]); }
inline Lanes operator-(const Lanes& a, const Lanes& b) { TRIMRAY_EACH_LANE(a.v[i] - b.v[i]); }
inline Lanes operator*(const Lanes& a, const Lanes& b) { TRIMRAY_EACH_LANE(a.v[i] * b.v[i]); }
inline Lanes operator/(const Lanes& a, const Lanes& b) { TRIMRAY_EACH_LANE(a.v[i] / b.v[i]); }
inline Lanes mul_add(const Lanes& a, const Lanes& b, const Lanes& c) {
  TRIMRAY_EACH_LANE(std::fma(a.v[i], b.v[i], c.v[i]));
}
inline Lanes neg_mul_add(const Lanes& a, const Lanes& b, const Lanes& c) {
  TRIMRAY_EACH_LANE(std::fma(-a.v[i], b.v[i], c.v[i]));
}
inline Lanes abs(const Lanes& a) { TRIMRAY_EACH_LANE(std::fabs(a.v[i])); }
inline Lanes sqrt(const Lanes& a) { TRIMRAY_EACH_LANE(std::sqrt(a.v[i])); }
inline Mask operator<(const Lanes& a, const Lanes& b) { TRIMRAY_EACH_MASK(a.v[i] < b.v[i]); }
inline Mask operator<=(const Lanes& a, const Lanes& b) { TRIMRAY_EACH_MASK(a.v[i] <= b.v[i]); }
inline Mask operator>(const Lanes& a, const Lanes& b) { TRIMRAY_EACH_MASK(a.v[i] > b.v[i]); }
inline Mask operator&(Mask a, Mask b) { return {a.m & b.m}; }
inline Mask operator|(Mask a, Mask b) { return {a.m | b.m}; }
inline Mask and_not(Mask a, Mask b) { return {b.m & ~a.m}; }
inline Lanes select(Mask m, const Lanes& yes, const Lanes& no) {
  TRIMRAY_EACH_LANE(((m.m >> i) & 1u) ? yes.v[i] : no.v[i]);
}
inline bool none(Mask m) { return m.m == 0; }
inline std::uint32_t bits(Mask m) { return m.m; }
inline Mask mask_from_bits(std::uint32_t b) { return {b & 0xffu}; }
#undef TRIMRAY_EACH_LANE
#undef TRIMRAY_EACH_MASK

#endif

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
