// Eight doubles that compute alike on every machine. The only file of the project that names instruction
// sets.
//
// Included inside Highway's foreach_target loop, once a target: each pass defines Lanes and Mask in
// trimray::HWY_NAMESPACE. kWidth lanes per Lanes: 8 with AVX-512, 4 with AVX2, one double of plain C++ where
// the machine has no fused multiply-add. mul_add is fused everywhere and division and sqrt are IEEE, so a
// lane's bits depend neither on the machine nor on the other lanes.
//
//   #include "core/base/simd.h"
//   #define HWY_TARGET_INCLUDE "core/.../this_file.cpp"
//   #include <hwy/foreach_target.h>
//   #include "core/base/simd.h"
// The first inclusion only chooses the targets; so include this file before foreach_target.h and again after
// it.
#ifndef TRIMRAY_SIMD_TARGETS_
#define TRIMRAY_SIMD_TARGETS_
// Between the fallback and AVX2 nothing has fused multiply-add: SSSE3 and SSE4 would only cost build time.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4)
#else

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
HWY_INLINE Lanes mul_add(Lanes a, Lanes b, Lanes c) { return hn::MulAdd(a.v, b.v, c.v); }         // a b + c
HWY_INLINE Lanes neg_mul_add(Lanes a, Lanes b, Lanes c) { return hn::NegMulAdd(a.v, b.v, c.v); }  // c - a b
HWY_INLINE Lanes abs(Lanes a) { return hn::Abs(a.v); }
HWY_INLINE Lanes sqrt(Lanes a) { return hn::Sqrt(a.v); }
HWY_INLINE Lanes min_of(Lanes a, Lanes b) { return hn::Min(a.v, b.v); }  // of numbers
HWY_INLINE Lanes max_of(Lanes a, Lanes b) { return hn::Max(a.v, b.v); }
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

inline constexpr int kWidth = 1;

struct Mask {
  bool m;
};
struct Lanes {
  double v;
  Lanes() = default;
  Lanes(double x) : v(x) {}
};

inline Lanes load(const double* p) { return *p; }
inline void store(Lanes a, double* p) { *p = a.v; }
inline Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
inline Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
inline Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
inline Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
inline Lanes mul_add(Lanes a, Lanes b, Lanes c) { return std::fma(a.v, b.v, c.v); }
inline Lanes neg_mul_add(Lanes a, Lanes b, Lanes c) { return std::fma(-a.v, b.v, c.v); }
inline Lanes abs(Lanes a) { return std::fabs(a.v); }
inline Lanes sqrt(Lanes a) { return std::sqrt(a.v); }
inline Lanes min_of(Lanes a, Lanes b) { return a.v < b.v ? a.v : b.v; }
inline Lanes max_of(Lanes a, Lanes b) { return a.v > b.v ? a.v : b.v; }
inline Mask operator<(Lanes a, Lanes b) { return {a.v < b.v}; }
inline Mask operator<=(Lanes a, Lanes b) { return {a.v <= b.v}; }
inline Mask operator>(Lanes a, Lanes b) { return {a.v > b.v}; }
inline Mask operator&(Mask a, Mask b) { return {a.m && b.m}; }
inline Mask operator|(Mask a, Mask b) { return {a.m || b.m}; }
inline Mask and_not(Mask a, Mask b) { return {b.m && !a.m}; }
inline Lanes select(Mask m, Lanes yes, Lanes no) { return m.m ? yes : no; }
inline bool none(Mask m) { return !m.m; }
inline std::uint32_t bits(Mask m) { return m.m ? 1u : 0u; }
inline Mask mask_from_bits(std::uint32_t b) { return {(b & 1u) != 0}; }

#endif

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
#endif  // not the first inclusion
