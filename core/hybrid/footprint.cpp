#include "core/hybrid/footprint.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/hybrid/footprint.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace trimray::hybrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;

template <class Mask>
HWY_INLINE std::uint64_t bits_of(Floats d, Mask mask) {
  alignas(8) std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  std::uint16_t bits;
  std::memcpy(&bits, bytes, 2);
  return bits & ((std::uint64_t{1} << hn::Lanes(d)) - 1);
}

// An affine function along a row.
struct Row {
  hn::Vec<Floats> at, dx;
  HWY_INLINE Row(const Affine& f, float x, float y)
      : at(hn::Set(Floats(), f.at + f.dx * x + f.dy * y)), dx(hn::Set(Floats(), f.dx)) {}
  HWY_INLINE hn::Vec<Floats> operator()(hn::Vec<Floats> x) const { return hn::MulAdd(dx, x, at); }
};

HWY_INLINE std::uint64_t row_mask(const Footprint& f, const float* best, float x, float y, int first,
                                  int last) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto limit_u = hn::Set(d, f.limit_u), limit_v = hn::Set(d, f.limit_v),
             limit_k = hn::Set(d, f.limit_k);
  const auto near = hn::Set(d, f.near);
  const Row u(f.u, x, y), v(f.v, x, y), k(f.k, x, y), depth(f.depth, x, y);
  std::uint64_t mask = 0;
  for (int i = first; i < last; i += lanes) {
    const auto px = hn::Iota(d, static_cast<float>(i));
    const auto b = hn::LoadU(d, best + i);
    auto on = hn::And(hn::Le(hn::Abs(u(px)), limit_u), hn::Le(hn::Abs(v(px)), limit_v));
    on = hn::And(on, hn::Le(hn::Abs(k(px)), limit_k));
    on = hn::And(on, hn::And(hn::Le(near, b), hn::Le(depth(px), b)));
    mask |= bits_of(d, on) << i;
  }
  return mask;
}

HWY_INLINE std::uint64_t row_mask_perspective(const Footprint& f, const float* best, float x, float y,
                                              int first, int last) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto near = hn::Set(d, f.near);
  const Row u(f.u, x, y), v(f.v, x, y), k(f.k, x, y), ab(f.ab, x, y), ak(f.ak, x, y), bk(f.bk, x, y),
      numerator(f.numerator, x, y);
  const auto slack_u = hn::Set(d, f.slack_u), slack_v = hn::Set(d, f.slack_v),
             slack_k = hn::Set(d, f.slack_k);
  const auto slack_depth = hn::Set(d, f.slack_depth), slack_ab = hn::Set(d, f.slack_ab);
  const auto relative = hn::Set(d, 1e-6f);
  std::uint64_t mask = 0;
  for (int i = first; i < last; i += lanes) {
    const auto px = hn::Iota(d, static_cast<float>(i));
    const auto b = hn::LoadU(d, best + i);
    const auto signed_ab = ab(px), wab = hn::Abs(signed_ab), wak = hn::Abs(ak(px)), wbk = hn::Abs(bk(px));
    auto on = hn::And(hn::Le(hn::Abs(u(px)), hn::Add(hn::Add(wab, wbk), slack_u)),
                      hn::Le(hn::Abs(v(px)), hn::Add(hn::Add(wab, wak), slack_v)));
    on = hn::And(on, hn::Le(hn::Abs(k(px)), hn::Add(hn::Add(wak, wbk), slack_k)));
    const auto left = hn::CopySign(hn::Set(d, 1.0f), signed_ab);
    const auto reach = hn::MulAdd(hn::Abs(b), hn::MulAdd(relative, wab, slack_ab), slack_depth);
    on = hn::And(on, hn::Le(hn::Mul(left, numerator(px)), hn::MulAdd(b, wab, reach)));
    on = hn::And(on, hn::Le(near, b));
    mask |= bits_of(d, on) << i;
  }
  return mask;
}

void CoverKernel(const Footprint& f, const float* best, float x, float y, std::uint64_t* rows) {
  const int lanes = static_cast<int>(hn::Lanes(Floats()));
  const int first = f.x0 / lanes * lanes;
  const std::uint64_t wanted = (~std::uint64_t{0} >> (64 - (f.x1 - f.x0))) << f.x0;
  for (int row = f.y0; row < f.y1; ++row) {
    const float* b = best + row * kMaxTile;
    const float row_y = y + static_cast<float>(row);
    rows[row] = wanted & (f.affine_denominator ? row_mask_perspective(f, b, x, row_y, first, f.x1)
                                               : row_mask(f, b, x, row_y, first, f.x1));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trimray::hybrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray::hybrid {

HWY_EXPORT(CoverKernel);

namespace {

constexpr double kRounding = 1e-6;  // of a sum of three floats that have been rounded, with a margin

// The affine function of the frame's place (x, y), about the middle of the tile.
Affine about(const dvec3& m, const dvec2& middle) {
  return {static_cast<float>(m.x * middle.x + m.y * middle.y + m.z), static_cast<float>(m.x),
          static_cast<float>(m.y)};
}

// What rounding can add to the function anywhere in a tile of this half size.
float rounding(const Affine& f, double half) {
  return static_cast<float>(kRounding * (std::abs(f.at) + half * (std::abs(f.dx) + std::abs(f.dy))));
}

// Divided by its limit.
Affine scaled(const Affine& f, double limit, double half, float& bound) {
  const double inverse = limit > 0.0 ? 1.0 / limit : 0.0;
  const Affine g{static_cast<float>(f.at * inverse), static_cast<float>(f.dx * inverse),
                 static_cast<float>(f.dy * inverse)};
  bound = 1.0f + static_cast<float>(kRounding) + rounding(g, half);
  return g;
}

// Pixels whose places can lie in [lo, hi], px from the tile's edge.
void pixel_range(double lo, double hi, int count, int& first, int& last) {
  lo = std::floor(lo - 1e-3), hi = std::ceil(hi + 1e-3);
  first = lo > 0.0 ? (lo < count ? static_cast<int>(lo) : count) : 0;
  last = hi < count ? (hi > 0.0 ? static_cast<int>(hi) : 0) : count;
}

}  // namespace

Footprint make_footprint(const trace::LeafHull& h, bool perspective, const FrameRect& rect, int width,
                         int height, double reference) {
  Footprint f;
  const dvec3 c = h.center, a = h.a, b = h.b, k = h.k;
  const dvec3 reach = glm::abs(a) + glm::abs(b) + glm::abs(k);
  const double half = 0.5 * std::max(width, height) + 1.0;
  const dvec2 middle = rect.center();
  const dvec3 ab = glm::cross(a, b);
  const double thick = std::abs(glm::dot(ab, k));
  f.affine_denominator = perspective;
  const double nearest = c.z - reach.z;
  f.near = static_cast<float>(nearest - reference - kRounding * (std::abs(nearest - reference)));
  double left = c.x - reach.x, right = c.x + reach.x, top = c.y - reach.y, bottom = c.y + reach.y;
  if (perspective) {
    if (c.z + reach.z <= 0.0) return f;  // behind the eye
    if (nearest > 1e-6 * (c.z + reach.z)) {
      const double p = 1.0 / nearest, q = 1.0 / (c.z + reach.z);
      left = std::min(left * p, left * q), right = std::max(right * p, right * q);
      top = std::min(top * p, top * q), bottom = std::max(bottom * p, bottom * q);
    } else {
      left = top = -kInf, right = bottom = kInf;
    }
  }
  pixel_range(left - rect.x0, right - rect.x0, width, f.x0, f.x1);
  pixel_range(top - rect.y0, bottom - rect.y0, height, f.y0, f.y1);
  if (f.x0 >= f.x1 || f.y0 >= f.y1) {
    f.x0 = f.x1 = f.y0 = f.y1 = 0;
    return f;
  }
  if (perspective) {
    // g.b = d.(b x c) and so on, d = (x, y, 1).
    const dvec3 bc = glm::cross(b, c), ac = glm::cross(a, c), kc = glm::cross(k, c);
    const dvec3 ak = glm::cross(a, k), bk = glm::cross(b, k);
    f.u = about(bc, middle), f.v = about(ac, middle), f.k = about(kc, middle);
    f.ab = about(ab, middle), f.ak = about(ak, middle), f.bk = about(bk, middle);
    f.numerator = about(dvec3(0.0, 0.0, glm::dot(ab, c)) - reference * ab, middle);
    // Cancellation in the products above, in double.
    const double fine =
        1e-14 * (std::abs(middle.x) + std::abs(middle.y) + half + 1.0) * (glm::length(c) + 1e-300);
    const double la = glm::length(a), lb = glm::length(b), lk = glm::length(k);
    f.slack_ab = rounding(f.ab, half);
    f.slack_u = rounding(f.u, half) + f.slack_ab + rounding(f.bk, half) + static_cast<float>(fine * lb);
    f.slack_v = rounding(f.v, half) + f.slack_ab + rounding(f.ak, half) + static_cast<float>(fine * la);
    f.slack_k =
        rounding(f.k, half) + rounding(f.ak, half) + rounding(f.bk, half) + static_cast<float>(fine * lk);
    f.slack_depth =
        rounding(f.numerator, half) + static_cast<float>((thick + fine * la * lb) * (1.0 + kRounding));
    return f;
  }
  const double dx = c.x - middle.x, dy = c.y - middle.y;
  const double wab = std::abs(ab.z), wak = std::abs(a.x * k.y - a.y * k.x),
               wbk = std::abs(b.x * k.y - b.y * k.x);
  // g = (dy - y, x - dx, 0) for the place (x, y).
  const auto across = [&](const dvec3& e) {
    return Affine{static_cast<float>(dy * e.x - dx * e.y), static_cast<float>(e.y), static_cast<float>(-e.x)};
  };
  f.u = scaled(across(b), wab + wbk, half, f.limit_u);
  f.v = scaled(across(a), wab + wak, half, f.limit_v);
  f.k = scaled(across(k), wak + wbk, half, f.limit_k);
  const double scale = wab > 0.0 ? 1.0 / ab.z : 0.0;
  const double slope_x = ab.x * scale, slope_y = ab.y * scale;
  if (wab > 1e-9 * (std::abs(ab.x) + std::abs(ab.y))) {
    f.depth = {static_cast<float>(c.z - reference + dx * slope_x + dy * slope_y),
               static_cast<float>(-slope_x), static_cast<float>(-slope_y)};
    f.depth.at -= static_cast<float>(thick / wab * (1.0 + kRounding)) + rounding(f.depth, half);
  } else {
    f.depth = {-kFarDepth, 0.0f, 0.0f};
  }
  return f;
}

void cover(const Footprint& footprint, const float* best, float place_x, float place_y, int width, int height,
           std::uint64_t* rows) {
  // The middle of pixel 0 relative to the tile's middle.
  const float x = 0.5f - 0.5f * static_cast<float>(width) + place_x,
              y = 0.5f - 0.5f * static_cast<float>(height) + place_y;
  HWY_DYNAMIC_DISPATCH(CoverKernel)(footprint, best, x, y, rows);
}

}  // namespace trimray::hybrid
#endif
