// Angles of points in SIMD lanes. Included once per Highway target.
#if defined(TRIMRAY_CORE_TRACE_ANGLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_TRACE_ANGLE_INL_H_
#undef TRIMRAY_CORE_TRACE_ANGLE_INL_H_
#else
#define TRIMRAY_CORE_TRACE_ANGLE_INL_H_
#endif

#include "core/base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

// Pi and its parts as sums of two doubles.
inline constexpr double kPi = 3.141592653589793116, kPiRest = 1.2246467991473532e-16;
inline constexpr double kBelowTwoPi = 0x1.921fb54442d17p+2;  // the double before that of 2 pi

// (arctan(x) / x - 1) / x^2 as a polynomial in x^2, least first, for |x| <= tan(pi / 8): an arctan with a
// relative error of 2^-57, rounding aside. Chebyshev interpolation.
inline constexpr double kArctan[11] = {-0x1.5555555555555p-2, 0x1.999999999934cp-3,  -0x1.2492492436201p-3,
                                       0x1.c71c71853d7fap-4,  -0x1.745d0b28a7e36p-4, 0x1.3b1263064f6b9p-4,
                                       -0x1.10fa77b1a6d51p-4, 0x1.dfe6497e962bap-5,  -0x1.a0999c632b4c8p-5,
                                       0x1.4162c02b1d771p-5,  -0x1.3a31b1c0fc488p-6};

// arctan(small / large) for 0 <= small <= large, in [0, pi / 4]; 0 where both vanish. Within 1.5 ulp.
HWY_INLINE Lanes first_octant(Lanes small, Lanes large) {
  // Above tan(pi / 8): pi / 4 + arctan((s - l) / (s + l)).
  const Mask upper = small > large * Lanes(0.41421356237309503);
  const Lanes num = select(upper, small - large, small), den = select(upper, small + large, large);
  const Lanes x = select(den > Lanes(0.0), num / den, Lanes(0.0)), z = x * x, z2 = z * z, z4 = z2 * z2;
  const auto pair = [&](int i) HWY_ATTR { return mul_add(Lanes(kArctan[i + 1]), z, Lanes(kArctan[i])); };
  const Lanes low = mul_add(pair(2), z2, pair(0)), middle = mul_add(pair(6), z2, pair(4));
  const Lanes high = mul_add(Lanes(kArctan[10]), z2, pair(8));
  const Lanes series = mul_add(mul_add(high, z4, middle), z4, low);
  const Lanes rest = select(upper, Lanes(0.25 * kPiRest), Lanes(0.0));
  return select(upper, Lanes(0.25 * kPi), Lanes(0.0)) + (x + mul_add(x * z, series, rest));
}

// The angle of (x, y) in [0, 2 pi), 0 where both vanish. Within 2 ulp.
HWY_INLINE Lanes turn_angle(Lanes y, Lanes x) {
  const Lanes ax = abs(x), ay = abs(y), zero(0.0);
  const Mask steep = ay > ax;
  const Lanes octant = first_octant(select(steep, ax, ay), select(steep, ay, ax));
  const Lanes quarter = select(steep, Lanes(0.5 * kPi) - (octant - Lanes(0.5 * kPiRest)), octant);
  const Lanes half = select(x < zero, Lanes(kPi) - (quarter - Lanes(kPiRest)), quarter);
  const Lanes below = Lanes(2.0 * kPi) - (half - Lanes(2.0 * kPiRest));
  return select(y < zero, select(below < Lanes(kBelowTwoPi), below, Lanes(kBelowTwoPi)), half);
}

// The angle of (rho, z) in [-pi / 2, pi / 2], for rho >= 0. Within 2 ulp.
HWY_INLINE Lanes latitude(Lanes z, Lanes rho) {
  const Lanes az = abs(z);
  const Mask steep = az > rho;
  const Lanes octant = first_octant(select(steep, rho, az), select(steep, az, rho));
  const Lanes angle = select(steep, Lanes(0.5 * kPi) - (octant - Lanes(0.5 * kPiRest)), octant);
  return select(z < Lanes(0.0), Lanes(0.0) - angle, angle);
}

// Where x, up to full turns, lies in [lower, upper].
HWY_INLINE Mask in_turn(Lanes x, double lower, double upper) {
  const Lanes middle(0.5 * (lower + upper)), magic(6755399441055744.0);  // 1.5 * 2^52: rounds to integers
  const Lanes turns = (mul_add(middle - x, Lanes(0.5 / kPi), magic)) - magic;
  const Lanes moved = mul_add(turns, Lanes(2.0 * kPi), x);
  return (Lanes(lower) <= moved) & (moved <= Lanes(upper));
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
