// Up to sixteen floats in a register, for tests that only need to be conservative. Included once per Highway
// target, after highway.h.
#if defined(TRIMRAY_CORE_BASE_SIMD_FLOATS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_BASE_SIMD_FLOATS_INL_H_
#undef TRIMRAY_CORE_BASE_SIMD_FLOATS_INL_H_
#else
#define TRIMRAY_CORE_BASE_SIMD_FLOATS_INL_H_
#endif

#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

using Floats = hwy::HWY_NAMESPACE::CappedTag<float, 16>;
using Float = hwy::HWY_NAMESPACE::Vec<Floats>;

HWY_INLINE Float set(float x) { return hwy::HWY_NAMESPACE::Set(Floats(), x); }

// A bit for each lane that is set in the mask.
template <class Mask>
HWY_INLINE std::uint64_t bits_of(Mask mask) {
  const Floats d;
  alignas(8) std::uint8_t bytes[8] = {};
  hwy::HWY_NAMESPACE::StoreMaskBits(d, mask, bytes);
  std::uint16_t bits;
  std::memcpy(&bits, bytes, 2);
  return bits & ((std::uint64_t{1} << hwy::HWY_NAMESPACE::Lanes(d)) - 1);
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
