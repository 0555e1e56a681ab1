#include "core/hybrid/footprint.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/hybrid/footprint.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/base/simd_floats-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::hybrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using trimray::HWY_NAMESPACE::bits_of;
using trimray::HWY_NAMESPACE::Float;
using trimray::HWY_NAMESPACE::Floats;
using trimray::HWY_NAMESPACE::set;

// Of a sum of some floats that have been rounded, with a margin.
constexpr float kRounding = 1e-6f;

// Footprints of perspective views that reach no farther from their middle, px, are plain.
constexpr float kPlainPx = 9.0f;

struct Vec {
  Float x, y, z;
};
HWY_INLINE Float dot(const Vec& a, const Vec& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Float cross_z(const Vec& a, const Vec& b) { return hn::NegMulAdd(a.y, b.x, hn::Mul(a.x, b.y)); }
HWY_INLINE Vec cross(const Vec& a, const Vec& b) {
  return {hn::NegMulAdd(a.z, b.y, hn::Mul(a.y, b.z)), hn::NegMulAdd(a.x, b.z, hn::Mul(a.z, b.x)),
          cross_z(a, b)};
}
HWY_INLINE Float sum_abs(Float a, Float b, Float c) {
  return hn::Add(hn::Add(hn::Abs(a), hn::Abs(b)), hn::Abs(c));
}

// An affine function of the place, a leaf a lane.
struct Function {
  Float at, dx, dy;
  HWY_INLINE void store(AffineBatch& out, int i) const {
    const Floats d;
    hn::Store(at, d, out.at + i), hn::Store(dx, d, out.dx + i), hn::Store(dy, d, out.dy + i);
  }
  // Largest size of its slope's part over a tile.
  HWY_INLINE Float reach(Float half) const { return hn::Mul(half, hn::Add(hn::Abs(dx), hn::Abs(dy))); }
  HWY_INLINE Float rounding(Float half) const {
    return hn::Mul(set(kRounding), hn::Add(hn::Abs(at), reach(half)));
  }
  HWY_INLINE Function scaled(Float s) const { return {hn::Mul(at, s), hn::Mul(dx, s), hn::Mul(dy, s)}; }
};

struct Setup {
  const TileFrame& frame;
  Footprints& out;
  Float half, error_x, error_y, error_z;

  // u, v or k orthographic: g = (dy - y, x - dx, 0) at the place (x, y), for the axis e; divided by the
  // limit.
  HWY_INLINE void slab(const Vec& c, const Vec& e, Float limit, AffineBatch& function, float* bound,
                       int i) const {
    const Float one = set(1.0f);
    const Float inverse =
        hn::IfThenElseZero(hn::Gt(limit, set(1e-30f)), hn::Div(one, hn::Max(limit, set(1e-30f))));
    const Function f =
        Function{hn::NegMulAdd(c.x, e.y, hn::Mul(c.y, e.x)), e.y, hn::Neg(e.x)}.scaled(inverse);
    f.store(function, i);
    // The point may be off, the axis may be off, and the sum will be rounded.
    const Float moved = hn::MulAdd(error_x, hn::Abs(f.dx), hn::Mul(error_y, hn::Abs(f.dy)));
    const Float products =
        hn::Mul(hn::Mul(set(kRounding), inverse),
                hn::MulAdd(hn::Abs(c.x), hn::Abs(e.y), hn::Mul(hn::Abs(c.y), hn::Abs(e.x))));
    const Float slack = hn::Add(hn::Add(moved, products), f.rounding(half));
    hn::Store(hn::Add(hn::Add(one, set(4.0f * kRounding)), slack), Floats(), bound + i);
  }

  HWY_INLINE void orthographic(const Vec& c, const Vec& a, const Vec& b, const Vec& k, int i) const {
    const Floats d;
    const Vec ab = cross(a, b);
    const Float wab = hn::Abs(ab.z), wak = hn::Abs(cross_z(a, k)), wbk = hn::Abs(cross_z(b, k));
    slab(c, b, hn::Add(wab, wbk), out.u, out.limit_u, i);
    slab(c, a, hn::Add(wab, wak), out.v, out.limit_v, i);
    slab(c, k, hn::Add(wak, wbk), out.k, out.limit_k, i);
    // The nearest plane: depth = c.z - reference + (c - place) . ab.xy / ab.z - |ab.k| / |ab.z|.
    const auto flat = hn::And(hn::Gt(wab, hn::Mul(set(1e-4f), hn::Add(hn::Abs(ab.x), hn::Abs(ab.y)))),
                              hn::Gt(wab, set(1e-30f)));
    const Float inverse = hn::Div(set(1.0f), hn::IfThenElse(flat, ab.z, set(1.0f)));
    const Float sx = hn::Mul(ab.x, inverse), sy = hn::Mul(ab.y, inverse);
    const Float height = hn::Sub(c.z, set(frame.reference));
    const Function f{hn::MulAdd(c.x, sx, hn::MulAdd(c.y, sy, height)), hn::Neg(sx), hn::Neg(sy)};
    const Float thick = hn::Abs(hn::Mul(dot(ab, k), inverse));
    const Float products =
        hn::Mul(set(4.0f * kRounding), sum_abs(hn::Mul(c.x, sx), hn::Mul(c.y, sy), hn::Abs(height)));
    const Float moved = hn::MulAdd(error_x, hn::Abs(sx), hn::MulAdd(error_y, hn::Abs(sy), error_z));
    const Float slack = hn::Add(hn::Add(hn::Add(moved, products), f.rounding(half)),
                                hn::Mul(thick, set(1.0f + 16.0f * kRounding)));
    hn::Store(hn::IfThenElse(flat, hn::Sub(f.at, slack), set(-kFarDepth)), d, out.depth.at + i);
    hn::Store(hn::IfThenElseZero(flat, f.dx), d, out.depth.dx + i);
    hn::Store(hn::IfThenElseZero(flat, f.dy), d, out.depth.dy + i);
  }

  // d . m for d = (x, y, 1).
  HWY_INLINE static Function along(const Vec& m) { return {m.z, m.x, m.y}; }

  // How far g . e can be off at any place of the tile.
  HWY_INLINE Float moved(const Vec& c, const Vec& e) const {
    const Float r = set(4.0f * kRounding);
    const Float x = hn::MulAdd(r, hn::Abs(c.x), error_x), y = hn::MulAdd(r, hn::Abs(c.y), error_y),
                z = hn::MulAdd(r, hn::Abs(c.z), error_z);
    const Float xz = hn::MulAdd(z, half, x), yz = hn::MulAdd(z, half, y);
    return hn::MulAdd(hn::Abs(e.x), yz,
                      hn::MulAdd(hn::Abs(e.y), xz, hn::Mul(hn::Abs(e.z), hn::Mul(half, hn::Add(x, y)))));
  }

  // near: of the hulls; middle_x to reach_y: the middle and half the size of the footprints, px. Returns
  // which of them are plain: so small that the largest limits and the least depth in them will do.
  HWY_INLINE std::uint32_t perspective(const Vec& c, const Vec& a, const Vec& b, const Vec& k, Float middle_x,
                                       Float middle_y, Float reach_x, Float reach_y, int i) const {
    const Floats d;
    // g . b = d . (b x c), and so on.
    const Function u = along(cross(b, c)), v = along(cross(a, c)), w = along(cross(k, c));
    const Vec normal = cross(a, b);
    const Function ab = along(normal), ak = along(cross(a, k)), bk = along(cross(b, k));
    u.store(out.u, i), v.store(out.v, i), w.store(out.k, i);
    ab.store(out.ab, i), ak.store(out.ak, i), bk.store(out.bk, i);
    // Each product of two axes has rounding of its own.
    const auto product = [&](const Vec& p, const Vec& q) HWY_ATTR {
      const Float px = hn::MulAdd(half, hn::Abs(p.z), hn::Add(hn::Abs(p.x), hn::Abs(p.y)));
      const Float qx = hn::MulAdd(half, hn::Abs(q.z), hn::Add(hn::Abs(q.x), hn::Abs(q.y)));
      return hn::Mul(set(8.0f * kRounding), hn::Mul(px, qx));
    };
    const Float slack_ab = hn::Add(ab.rounding(half), product(a, b));
    const Float slack_ak = hn::Add(ak.rounding(half), product(a, k));
    const Float slack_bk = hn::Add(bk.rounding(half), product(b, k));
    const Float most = set(kPlainPx);
    const auto plain = hn::And(hn::Le(reach_x, most), hn::Le(reach_y, most));
    const auto largest = [&](const Function& f) HWY_ATTR {
      const Float at = hn::MulAdd(f.dx, middle_x, hn::MulAdd(f.dy, middle_y, f.at));
      return hn::MulAdd(reach_x, hn::Abs(f.dx), hn::MulAdd(reach_y, hn::Abs(f.dy), hn::Abs(at)));
    };
    const Float most_ab = largest(ab), most_ak = largest(ak), most_bk = largest(bk);
    const auto limit = [&](const Function& f, const Vec& e, Float p, Float q, Float slack,
                           float* bound) HWY_ATTR {
      const Float rounded = hn::Add(hn::Add(f.rounding(half), moved(c, e)), slack);
      hn::Store(hn::Add(rounded, hn::IfThenElseZero(plain, hn::Add(p, q))), d, bound + i);
    };
    limit(u, b, most_ab, most_bk, hn::Add(slack_ab, slack_bk), out.limit_u);
    limit(v, a, most_ab, most_ak, hn::Add(slack_ab, slack_ak), out.limit_v);
    limit(w, k, most_ak, most_bk, hn::Add(slack_ak, slack_bk), out.limit_k);
    // Depth minus reference = (c . ab - reference d . ab) / (d . ab).
    const Float reference = set(-frame.reference);
    const Function numerator{hn::MulAdd(reference, ab.at, dot(normal, c)), hn::Mul(reference, ab.dx),
                             hn::Mul(reference, ab.dy)};
    hn::Store(hn::IfThenElse(plain, set(-kFarDepth), numerator.at), d, out.depth.at + i);
    hn::Store(hn::IfThenZeroElse(plain, numerator.dx), d, out.depth.dx + i);
    hn::Store(hn::IfThenZeroElse(plain, numerator.dy), d, out.depth.dy + i);
    const Float r = set(4.0f * kRounding);
    Float slack = hn::Mul(hn::Abs(normal.x), hn::MulAdd(r, hn::Abs(c.x), error_x));
    slack = hn::MulAdd(hn::Abs(normal.y), hn::MulAdd(r, hn::Abs(c.y), error_y), slack);
    slack = hn::MulAdd(hn::Abs(normal.z), hn::MulAdd(r, hn::Abs(c.z), error_z), slack);
    slack = hn::Add(hn::Add(slack, numerator.rounding(half)), hn::Mul(hn::Abs(reference), slack_ab));
    slack = hn::MulAdd(hn::Abs(dot(normal, k)), set(1.0f + 16.0f * kRounding), slack);
    // c . (what rounding does to a x b): across the ray's middle c is small, along it the product of the
    // parts across.
    const Float across = hn::Mul(hn::Add(hn::Abs(a.x), hn::Abs(a.y)), hn::Add(hn::Abs(b.x), hn::Abs(b.y)));
    slack = hn::MulAdd(hn::Mul(set(8.0f * kRounding), across), hn::Abs(c.z), slack);
    const Float lateral = hn::Mul(
        hn::Mul(set(8.0f * kRounding), hn::Add(hn::Abs(c.x), hn::Abs(c.y))),
        hn::MulAdd(sum_abs(a.x, a.y, a.z), hn::Abs(b.z), hn::Mul(hn::Abs(a.z), sum_abs(b.x, b.y, b.z))));
    hn::Store(hn::Add(slack, lateral), d, out.slack_depth + i);
    hn::Store(slack_ab, d, out.slack_ab + i);
    return static_cast<std::uint32_t>(bits_of(plain));
  }
};

// Pixels whose places can lie in [low, high], px from the tile's middle.
HWY_INLINE void store_range(Float low, Float high, int count, std::int32_t* first, std::int32_t* last) {
  const Floats d;
  const hn::Rebind<std::int32_t, Floats> di;
  const Float zero = hn::Zero(d), size = set(static_cast<float>(count)),
              shift = set(0.5f * static_cast<float>(count));
  const Float slack = set(1e-2f);
  low = hn::Min(hn::Max(hn::Floor(hn::Sub(hn::Add(low, shift), slack)), zero), size);
  high = hn::Min(hn::Max(hn::Ceil(hn::Add(hn::Add(high, shift), slack)), zero), size);
  hn::Store(hn::ConvertTo(di, low), di, first), hn::Store(hn::ConvertTo(di, high), di, last);
}

void SetupKernel(const TileFrame& frame, const float* hulls, const std::int32_t* index, int count, int width,
                 int height, Footprints& out) {
  const Floats d;
  const hn::Rebind<std::int32_t, Floats> di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  std::uint32_t plain = 0;
  const Setup setup{
      frame, out, set(frame.half), set(frame.error[0]), set(frame.error[1]), set(frame.error[2])};
  for (int i = 0; i < count; i += lanes) {
    const auto at = hn::LoadU(di, index + i);
    Vec v[4];  // center, a, b, k in the frame
    for (int n = 0; n < 4; ++n) {
      const Float x = hn::GatherIndex(d, hulls + 3 * n, at), y = hn::GatherIndex(d, hulls + 3 * n + 1, at),
                  z = hn::GatherIndex(d, hulls + 3 * n + 2, at);
      const auto row = [&](int r) HWY_ATTR {
        const float* m = frame.linear[r];
        const Float shift = set(n == 0 ? frame.shift[r] : 0.0f);
        return hn::MulAdd(set(m[0]), x, hn::MulAdd(set(m[1]), y, hn::MulAdd(set(m[2]), z, shift)));
      };
      v[n] = {row(0), row(1), row(2)};
    }
    const Vec& c = v[0];
    const Float grow = set(1.0f + 8.0f * kRounding);
    const Vec reach{hn::MulAdd(sum_abs(v[1].x, v[2].x, v[3].x), grow, setup.error_x),
                    hn::MulAdd(sum_abs(v[1].y, v[2].y, v[3].y), grow, setup.error_y),
                    hn::MulAdd(sum_abs(v[1].z, v[2].z, v[3].z), grow, setup.error_z)};
    Float left = hn::Sub(c.x, reach.x), right = hn::Add(c.x, reach.x), top = hn::Sub(c.y, reach.y),
          bottom = hn::Add(c.y, reach.y);
    const Float nearest = hn::Sub(c.z, reach.z), farthest = hn::Add(c.z, reach.z);
    const Float near = hn::Sub(nearest, set(frame.reference));
    hn::Store(hn::NegMulAdd(set(kRounding), hn::Abs(near), near), d, out.near + i);
    if (frame.perspective) {
      // Where the hull comes near the plane of the eye it may be seen anywhere; behind it, nowhere.
      const auto before = hn::Gt(nearest, hn::Mul(set(1e-3f), hn::Abs(farthest)));
      const Float p = hn::Div(set(1.0f), hn::IfThenElse(before, nearest, set(1.0f)));
      const Float q = hn::Div(set(1.0f), hn::IfThenElse(before, farthest, set(1.0f)));
      const Float all = set(1e9f);
      const auto behind = hn::Lt(farthest, hn::Zero(d));
      left = hn::IfThenElse(before, hn::Min(hn::Mul(left, p), hn::Mul(left, q)), hn::Neg(all));
      top = hn::IfThenElse(before, hn::Min(hn::Mul(top, p), hn::Mul(top, q)), hn::Neg(all));
      right = hn::IfThenElse(before, hn::Max(hn::Mul(right, p), hn::Mul(right, q)), all);
      bottom = hn::IfThenElse(before, hn::Max(hn::Mul(bottom, p), hn::Mul(bottom, q)), all);
      right = hn::IfThenElse(behind, hn::Neg(all), right);
    }
    store_range(left, right, width, out.x0 + i, out.x1 + i);
    store_range(top, bottom, height, out.y0 + i, out.y1 + i);
    if (frame.perspective) {
      const Float one_half = set(0.5f);
      // A place may be half a pixel from the middle of its own.
      const Float reach_x = hn::MulAdd(one_half, hn::Sub(right, left), set(1.0f)),
                  reach_y = hn::MulAdd(one_half, hn::Sub(bottom, top), set(1.0f));
      plain |= setup.perspective(c, v[1], v[2], v[3], hn::Mul(one_half, hn::Add(left, right)),
                                 hn::Mul(one_half, hn::Add(top, bottom)), reach_x, reach_y, i)
               << i;
    } else {
      setup.orthographic(c, v[1], v[2], v[3], i);
      plain |= 0xffffu << i;
    }
  }
  out.plain = plain;
}

// One leaf's function along a row.
struct Row {
  Float at, dx;
  HWY_INLINE Row(const AffineBatch& f, int i, float x, float y)
      : at(set(f.at[i] + f.dx[i] * x + f.dy[i] * y)), dx(set(f.dx[i])) {}
  HWY_INLINE Float operator()(Float x) const { return hn::MulAdd(dx, x, at); }
};

HWY_INLINE std::uint64_t row_mask(const Footprints& f, int leaf, const float* best, float x, float y,
                                  int first, int last) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Float limit_u = set(f.limit_u[leaf]), limit_v = set(f.limit_v[leaf]), limit_k = set(f.limit_k[leaf]),
              near = set(f.near[leaf]);
  const Row u(f.u, leaf, x, y), v(f.v, leaf, x, y), k(f.k, leaf, x, y), depth(f.depth, leaf, x, y);
  std::uint64_t mask = 0;
  for (int i = first; i < last; i += lanes) {
    const Float px = hn::Iota(d, static_cast<float>(i)), b = hn::LoadU(d, best + i);
    auto on = hn::And(hn::Le(hn::Abs(u(px)), limit_u), hn::Le(hn::Abs(v(px)), limit_v));
    on = hn::And(on, hn::Le(hn::Abs(k(px)), limit_k));
    on = hn::And(on, hn::And(hn::Le(near, b), hn::Le(depth(px), b)));
    mask |= bits_of(on) << i;
  }
  return mask;
}

HWY_INLINE std::uint64_t row_mask_perspective(const Footprints& f, int leaf, const float* best, float x,
                                              float y, int first, int last) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Row u(f.u, leaf, x, y), v(f.v, leaf, x, y), k(f.k, leaf, x, y), ab(f.ab, leaf, x, y),
      ak(f.ak, leaf, x, y), bk(f.bk, leaf, x, y), numerator(f.depth, leaf, x, y);
  const Float slack_u = set(f.limit_u[leaf]), slack_v = set(f.limit_v[leaf]), slack_k = set(f.limit_k[leaf]),
              slack_depth = set(f.slack_depth[leaf]), slack_ab = set(f.slack_ab[leaf]),
              near = set(f.near[leaf]);
  std::uint64_t mask = 0;
  for (int i = first; i < last; i += lanes) {
    const Float px = hn::Iota(d, static_cast<float>(i)), b = hn::LoadU(d, best + i);
    const Float signed_ab = ab(px), wab = hn::Abs(signed_ab), wak = hn::Abs(ak(px)), wbk = hn::Abs(bk(px));
    auto on = hn::And(hn::Le(hn::Abs(u(px)), hn::Add(hn::Add(wab, wbk), slack_u)),
                      hn::Le(hn::Abs(v(px)), hn::Add(hn::Add(wab, wak), slack_v)));
    on = hn::And(on, hn::Le(hn::Abs(k(px)), hn::Add(hn::Add(wak, wbk), slack_k)));
    const Float side = hn::CopySign(set(1.0f), signed_ab);
    const Float reach = hn::MulAdd(hn::Abs(b), hn::MulAdd(set(kRounding), wab, slack_ab), slack_depth);
    // Where the sign of d . ab is not certain, nothing is said about depth.
    on = hn::And(
        on, hn::Or(hn::Le(hn::Mul(side, numerator(px)), hn::MulAdd(b, wab, reach)), hn::Le(wab, slack_ab)));
    on = hn::And(on, hn::Le(near, b));
    mask |= bits_of(on) << i;
  }
  return mask;
}

bool CoverKernel(const Footprints& f, int leaf, const float* best, float x, float y, std::uint64_t* rows) {
  const int lanes = static_cast<int>(hn::Lanes(Floats()));
  const int first = f.x0[leaf] / lanes * lanes, last = f.x1[leaf];
  const std::uint64_t wanted = (~std::uint64_t{0} >> (64 - (last - f.x0[leaf]))) << f.x0[leaf];
  const bool plain = (f.plain >> leaf) & 1;
  std::uint64_t any = 0;
  for (int row = f.y0[leaf]; row < f.y1[leaf]; ++row) {
    const float* b = best + row * kMaxTile;
    const float row_y = y + static_cast<float>(row);
    rows[row] = wanted & (!plain ? row_mask_perspective(f, leaf, b, x, row_y, first, last)
                                 : row_mask(f, leaf, b, x, row_y, first, last));
    any |= rows[row];
  }
  return any != 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace trimray::hybrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray::hybrid {

HWY_EXPORT(SetupKernel);
HWY_EXPORT(CoverKernel);

TileFrame::TileFrame(const CameraFrame& frame, const dvec3& center, double radius, const FrameRect& rect,
                     double reference_depth)
    : reference(static_cast<float>(reference_depth)), perspective(frame.perspective) {
  const CameraFrame local = frame.about(center);
  const dmat3 rows = glm::transpose(local.linear);
  const dvec2 middle = rect.center();
  dvec3 row[3] = {rows[0], rows[1], rows[2]};
  dvec3 offset = local.shift;
  if (perspective) {
    row[0] -= middle.x * row[2], row[1] -= middle.y * row[2];
    offset.x -= middle.x * offset.z, offset.y -= middle.y * offset.z;
  } else {
    offset.x -= middle.x, offset.y -= middle.y;
    // Depths are compared only: they may start at the reference.
    offset.z -= reference_depth, reference = 0.0f;
  }
  for (int r = 0; r < 3; ++r) {
    for (int a = 0; a < 3; ++a) linear[r][a] = static_cast<float>(row[r][a]);
    shift[r] = static_cast<float>(offset[r]);
    const double size = (std::abs(row[r].x) + std::abs(row[r].y) + std::abs(row[r].z)) * radius;
    error[r] = static_cast<float>(5e-7 * (size + std::abs(offset[r])));
  }
  half = static_cast<float>(0.5 * std::max(rect.x1 - rect.x0, rect.y1 - rect.y0));
}

void make_footprints(const TileFrame& frame, std::span<const trace::LeafHull> hulls,
                     std::span<const std::int32_t> leaves, int width, int height, Footprints& out) {
  constexpr int kFloats = sizeof(trace::LeafHull) / sizeof(float);
  alignas(64) std::int32_t index[kBatch] = {};
  for (std::size_t i = 0; i < leaves.size(); ++i) index[i] = kFloats * leaves[i];
  HWY_DYNAMIC_DISPATCH(SetupKernel)
  (frame, hulls.front().center, index, static_cast<int>(leaves.size()), width, height, out);
}

bool cover(const Footprints& footprints, int i, const float* best, float place_x, float place_y, int width,
           int height, std::uint64_t* rows) {
  // The middle of pixel 0 relative to the tile's middle.
  const float x = 0.5f - 0.5f * static_cast<float>(width) + place_x,
              y = 0.5f - 0.5f * static_cast<float>(height) + place_y;
  return HWY_DYNAMIC_DISPATCH(CoverKernel)(footprints, i, best, x, y, rows);
}

}  // namespace trimray::hybrid
#endif
