#include "core/trace/triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/triangle.cpp"
#include <hwy/foreach_target.h>

#include "core/base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

using trace::kTrianglesPerBlock;
using trace::RayShear;
using trace::TriangleBlock;

static_assert(kTrianglesPerBlock % kWidth == 0);

// Twice the area of (origin, a, b), rounded; where it is not zero its sign is exact.
HWY_INLINE Lanes area(Lanes ax, Lanes ay, Lanes bx, Lanes by) { return ax * by - ay * bx; }

// Bits of the triangles that the line may cross: all but those with strictly positive and strictly negative
// areas. The same steps as crosses() below, without its care for zeros.
HWY_INLINE std::uint32_t candidates(const TriangleBlock& block, const RayShear& ray) {
  const Lanes ox(ray.org[ray.x]), oy(ray.org[ray.y]), oz(ray.org[ray.z]), sx(ray.sx), sy(ray.sy), zero(0.0);
  std::uint32_t result = 0;
  for (int k = 0; k < block.count; k += kWidth) {
    Lanes x[3], y[3];
    for (int c = 0; c < 3; ++c) {
      const Lanes z = load(block.corner[c][ray.z] + k) - oz;
      x[c] = (load(block.corner[c][ray.x] + k) - ox) - sx * z;
      y[c] = (load(block.corner[c][ray.y] + k) - oy) - sy * z;
    }
    const Lanes a = area(x[1], y[1], x[2], y[2]), b = area(x[2], y[2], x[0], y[0]),
                c = area(x[0], y[0], x[1], y[1]);
    const Mask positive = (a > zero) | (b > zero) | (c > zero),
               negative = (a < zero) | (b < zero) | (c < zero);
    result |= (bits(positive & negative) ^ ((1u << kWidth) - 1u)) << k;
  }
  return result & ((1u << block.count) - 1u);
}

// Of the active rays, those with candidates.
std::uint64_t may_cross(const TriangleBlock& block, const RayShear* rays, std::uint64_t active,
                        std::uint8_t* lanes) {
  std::uint64_t found = 0;
  for (; active != 0; active &= active - 1) {
    const int ray = std::countr_zero(active);
    lanes[ray] = static_cast<std::uint8_t>(candidates(block, rays[ray]));
    if (lanes[ray] != 0) found |= active & -active;
  }
  return found;
}

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray {

HWY_EXPORT(may_cross);

namespace trace {
namespace {

struct Area {
  double value;
  int sign;  // of the moved origin; 0 only where a = b
};

// Twice the area of (origin, a, b). Rounding is monotone, so two products that differ have the order of the
// exact ones; of equal ones the rounding errors decide, and then the move of the origin by (e, e^2).
Area area(const dvec2& a, const dvec2& b) {
  const double p = a.x * b.y, q = a.y * b.x;
  if (p != q) return {p - q, p > q ? 1 : -1};
  const double rest = std::fma(a.x, b.y, -p) - std::fma(a.y, b.x, -q);
  if (rest != 0.0) return {rest, rest > 0.0 ? 1 : -1};
  if (a.y != b.y) return {0.0, a.y > b.y ? 1 : -1};
  return {0.0, a.x == b.x ? 0 : a.x < b.x ? 1 : -1};
}

bool crosses(const TriangleBlock& block, int lane, const RayShear& ray, TriangleCrossing& out) {
  dvec2 p[3];
  double z[3];
  for (int c = 0; c < 3; ++c) {
    z[c] = block.corner[c][ray.z][lane] - ray.org[ray.z];
    p[c].x = (block.corner[c][ray.x][lane] - ray.org[ray.x]) - ray.sx * z[c];
    p[c].y = (block.corner[c][ray.y][lane] - ray.org[ray.y]) - ray.sy * z[c];
  }
  const Area a = area(p[1], p[2]), b = area(p[2], p[0]), c = area(p[0], p[1]);
  if (a.sign == 0 || a.sign != b.sign || a.sign != c.sign) return false;
  const double sum = a.value + b.value + c.value;  // not zero: the three areas are not all zero
  out.t = (a.value * z[0] + b.value * z[1] + c.value * z[2]) / sum * ray.sz;
  out.weights = dvec2(b.value, c.value) / sum;
  return std::isfinite(out.t);
}

}  // namespace

RayShear::RayShear(const dvec3& o, const dvec3& d) : org{o.x, o.y, o.z} {
  const dvec3 length = glm::abs(d);
  z = length.x >= length.y && length.x >= length.z ? 0 : length.y >= length.z ? 1 : 2;
  x = (z + 1) % 3, y = (z + 2) % 3;
  sx = d[x] / d[z], sy = d[y] / d[z], sz = 1.0 / d[z];
}

int cross_triangles(const TriangleBlock& block, std::span<const RayShear> rays, std::uint64_t active,
                    TriangleCrossing* out) {
  std::uint8_t candidates[64];
  active = HWY_DYNAMIC_DISPATCH(may_cross)(block, rays.data(), active, candidates);
  int count = 0;
  for (; active != 0; active &= active - 1) {
    const int ray = std::countr_zero(active);
    for (unsigned lanes = candidates[ray]; lanes != 0; lanes &= lanes - 1) {
      TriangleCrossing& crossing = out[count];
      crossing.ray = ray, crossing.lane = std::countr_zero(lanes);
      count += crosses(block, crossing.lane, rays[ray], crossing);
    }
  }
  return count;
}

dvec3 triangle_normal(const dvec3& a, const dvec3& b, const dvec3& c) {
  dvec3 e = b - a, f = c - a;
  // So that the product of the sides of the smallest triangles does not vanish.
  const dvec3 longest = glm::max(glm::abs(e), glm::abs(f));
  const double scale = std::max({longest.x, longest.y, longest.z});
  if (!(scale > 0.0)) return {0.0, 0.0, 1.0};
  e /= scale, f /= scale;
  const dvec3 n = glm::cross(e, f);
  const double length = glm::length(n);
  return length > 0.0 ? n / length : dvec3(0.0, 0.0, 1.0);
}

}  // namespace trace
}  // namespace trimray
#endif
