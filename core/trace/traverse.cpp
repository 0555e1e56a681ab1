#include "core/trace/traverse.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/traverse.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/base/simd_floats-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::trace {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using trimray::HWY_NAMESPACE::bits_of;
using trimray::HWY_NAMESPACE::Floats;

// Slab test of one child box; groups of lanes with no ray of `rays` are skipped.
HWY_INLINE std::uint64_t meet_box(const RayPacket& p, const BvhNode& node, int child, std::uint64_t rays) {
  const Floats d;
  const std::size_t lanes = hn::Lanes(d);
  const std::uint64_t group = (std::uint64_t{1} << lanes) - 1;
  const auto lx = hn::Set(d, node.lower[0][child]), ux = hn::Set(d, node.upper[0][child]);
  const auto ly = hn::Set(d, node.lower[1][child]), uy = hn::Set(d, node.upper[1][child]);
  const auto lz = hn::Set(d, node.lower[2][child]), uz = hn::Set(d, node.upper[2][child]);
  std::uint64_t result = 0;
  for (std::size_t i = 0; i < kPacketSize; i += lanes) {
    if (!((rays >> i) & group)) continue;
    const auto ox = hn::Load(d, p.org[0] + i), ix = hn::Load(d, p.inv[0] + i);
    const auto oy = hn::Load(d, p.org[1] + i), iy = hn::Load(d, p.inv[1] + i);
    const auto oz = hn::Load(d, p.org[2] + i), iz = hn::Load(d, p.inv[2] + i);
    const auto x0 = hn::Mul(hn::Sub(lx, ox), ix), x1 = hn::Mul(hn::Sub(ux, ox), ix);
    const auto y0 = hn::Mul(hn::Sub(ly, oy), iy), y1 = hn::Mul(hn::Sub(uy, oy), iy);
    const auto z0 = hn::Mul(hn::Sub(lz, oz), iz), z1 = hn::Mul(hn::Sub(uz, oz), iz);
    const auto enter =
        hn::Max(hn::Max(hn::Min(x0, x1), hn::Min(y0, y1)), hn::Max(hn::Min(z0, z1), hn::Load(d, p.tmin + i)));
    const auto leave =
        hn::Min(hn::Min(hn::Max(x0, x1), hn::Max(y0, y1)), hn::Min(hn::Max(z0, z1), hn::Load(d, p.tmax + i)));
    result |= bits_of(hn::Le(enter, leave)) << i;
  }
  return result & rays;
}

struct Entry {
  std::int32_t node, child;
  std::uint64_t rays;
};

// Children are pushed far to near along the packet's direction and tested when they are popped, when
// the rays' tmax is as short as it can be.
HWY_INLINE int push_children(const Bvh& bvh, const RayPacket& p, std::int32_t index, std::uint64_t rays,
                             Entry* stack, int top) {
  const BvhNode& node = bvh.nodes[index];
  float key[kBvhWidth];
  for (int i = 0; i < node.count; ++i) {
    key[i] = 0.0f;
    for (int a = 0; a < 3; ++a)
      key[i] += p.order[a] * (p.order[a] > 0.0f ? node.lower[a][i] : node.upper[a][i]);
  }
  const int first = top;
  for (int i = 0; i < node.count; ++i) {
    int at = top++;
    for (; at > first && key[stack[at - 1].child] < key[i]; --at) stack[at] = stack[at - 1];
    stack[at] = {index, i, rays};
  }
  return top;
}

void TraverseKernel(const Bvh& bvh, RayPacket& p, LeafVisitor visit, void* context, std::uint64_t* nodes) {
  Entry stack[kBvhDepth * kBvhWidth];
  int top = push_children(bvh, p, 0, p.live, stack, 0);
  std::uint64_t opened = 1;
  while (top > 0) {
    const Entry entry = stack[--top];
    std::uint64_t rays = entry.rays & p.live;
    if (rays == 0) continue;
    const BvhNode& node = bvh.nodes[entry.node];
    rays = meet_box(p, node, entry.child, rays);
    if (rays == 0) continue;
    const std::int32_t child = node.child[entry.child];
    if (child < 0) {
      visit(context, ~child, rays);
    } else {
      top = push_children(bvh, p, child, rays, stack, top);
      ++opened;
    }
  }
  *nodes += opened;
}

// Distance of each ray's line to the segment, in the plane across the ray.
std::uint64_t NearCapsuleKernel(const RayPacket& p, const Capsule& c, std::uint64_t rays) {
  const Floats d;
  const std::size_t lanes = hn::Lanes(d);
  const std::uint64_t group = (std::uint64_t{1} << lanes) - 1;
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f), tiny = hn::Set(d, 1e-30f);
  const auto limit = hn::Set(d, c.radius * c.radius);
  std::uint64_t result = 0;
  for (std::size_t i = 0; i < kPacketSize; i += lanes) {
    if (!((rays >> i) & group)) continue;
    const auto dx = hn::Load(d, p.dir[0] + i), dy = hn::Load(d, p.dir[1] + i), dz = hn::Load(d, p.dir[2] + i);
    auto ax = hn::Sub(hn::Set(d, c.a[0]), hn::Load(d, p.org[0] + i));
    auto ay = hn::Sub(hn::Set(d, c.a[1]), hn::Load(d, p.org[1] + i));
    auto az = hn::Sub(hn::Set(d, c.a[2]), hn::Load(d, p.org[2] + i));
    auto ex = hn::Set(d, c.b[0] - c.a[0]), ey = hn::Set(d, c.b[1] - c.a[1]), ez = hn::Set(d, c.b[2] - c.a[2]);
    const auto along_a = hn::Add(hn::Add(hn::Mul(ax, dx), hn::Mul(ay, dy)), hn::Mul(az, dz));
    const auto along_e = hn::Add(hn::Add(hn::Mul(ex, dx), hn::Mul(ey, dy)), hn::Mul(ez, dz));
    ax = hn::Sub(ax, hn::Mul(along_a, dx)), ay = hn::Sub(ay, hn::Mul(along_a, dy)),
    az = hn::Sub(az, hn::Mul(along_a, dz));
    ex = hn::Sub(ex, hn::Mul(along_e, dx)), ey = hn::Sub(ey, hn::Mul(along_e, dy)),
    ez = hn::Sub(ez, hn::Mul(along_e, dz));
    const auto ae = hn::Add(hn::Add(hn::Mul(ax, ex), hn::Mul(ay, ey)), hn::Mul(az, ez));
    const auto ee = hn::Add(hn::Add(hn::Mul(ex, ex), hn::Mul(ey, ey)), hn::Mul(ez, ez));
    const auto s = hn::Min(hn::Max(hn::Neg(hn::Div(ae, hn::Max(ee, tiny))), zero), one);
    const auto qx = hn::Add(ax, hn::Mul(s, ex)), qy = hn::Add(ay, hn::Mul(s, ey)),
               qz = hn::Add(az, hn::Mul(s, ez));
    const auto q = hn::Add(hn::Add(hn::Mul(qx, qx), hn::Mul(qy, qy)), hn::Mul(qz, qz));
    result |= bits_of(hn::Le(q, limit)) << i;
  }
  return result & rays;
}

// The ray from its point nearest to the center of the Bvh, in double, then rounded to float.
void SetKernel(RayPacket& p, const Bvh& bvh, const RayBlock& block, std::uint64_t rays) {
  using Doubles = hn::CappedTag<double, 8>;
  const Doubles d;
  const hn::Rebind<float, Doubles> f;
  const std::size_t lanes = hn::Lanes(d);
  const std::uint64_t group = (std::uint64_t{1} << lanes) - 1;
  const auto radius = hn::Set(d, bvh.radius), radius2 = hn::Set(d, bvh.radius * bvh.radius);
  const auto far = hn::Set(d, static_cast<double>(RayPacket::kFar)), grow = hn::Set(d, RayPacket::kAbove);
  const auto min_dir = hn::Set(f, 1e-18f);  // in its place, a direction of zero keeps the ray in its slab
  // As RayPacket::float_above.
  const auto above = [&](auto t) HWY_ATTR {
    return hn::DemoteTo(f, hn::Min(hn::Max(hn::Add(t, hn::Mul(hn::Abs(t), grow)), hn::Neg(far)), far));
  };
  auto sum_x = hn::Zero(d), sum_y = hn::Zero(d), sum_z = hn::Zero(d);
  p.live = 0;
  for (std::size_t i = 0; i < kPacketSize; i += lanes) {
    if (!((rays >> i) & group)) continue;
    const auto dx = hn::Load(d, block.dir[0] + i), dy = hn::Load(d, block.dir[1] + i),
               dz = hn::Load(d, block.dir[2] + i);
    auto x = hn::Sub(hn::Load(d, block.org[0] + i), hn::Set(d, bvh.center.x));
    auto y = hn::Sub(hn::Load(d, block.org[1] + i), hn::Set(d, bvh.center.y));
    auto z = hn::Sub(hn::Load(d, block.org[2] + i), hn::Set(d, bvh.center.z));
    const auto nearest = hn::Neg(hn::Add(hn::Add(hn::Mul(x, dx), hn::Mul(y, dy)), hn::Mul(z, dz)));
    x = hn::Add(x, hn::Mul(nearest, dx)), y = hn::Add(y, hn::Mul(nearest, dy)),
    z = hn::Add(z, hn::Mul(nearest, dz));
    const auto tmin = hn::Load(d, block.tmin + i), tmax = hn::Load(d, block.tmax + i);
    const auto distance2 = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    const auto in_ball = hn::And(hn::Le(distance2, radius2), hn::Le(tmin, tmax));
    const auto in_range =
        hn::And(hn::Ge(tmax, hn::Sub(nearest, radius)), hn::Le(tmin, hn::Add(nearest, radius)));
    const auto meets = hn::And(in_ball, in_range);
    alignas(8) std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, meets, bytes);
    const std::uint64_t bits = bytes[0] & group & (rays >> i);
    if (bits == 0) continue;
    p.live |= bits << i;
    hn::Store(hn::DemoteTo(f, x), f, p.org[0] + i);
    hn::Store(hn::DemoteTo(f, y), f, p.org[1] + i);
    hn::Store(hn::DemoteTo(f, z), f, p.org[2] + i);
    const auto store_dir = [&](int axis, auto direction) HWY_ATTR {
      const auto v = hn::DemoteTo(f, direction);
      hn::Store(v, f, p.dir[axis] + i);
      const auto safe = hn::IfThenElse(hn::Lt(hn::Abs(v), min_dir), hn::CopySign(min_dir, v), v);
      hn::Store(hn::Div(hn::Set(f, 1.0f), safe), f, p.inv[axis] + i);
    };
    store_dir(0, dx), store_dir(1, dy), store_dir(2, dz);
    hn::Store(nearest, d, p.t0 + i);
    hn::Store(hn::Neg(above(hn::Sub(nearest, tmin))), f, p.tmin + i);
    hn::Store(above(hn::Sub(tmax, nearest)), f, p.tmax + i);
    sum_x = hn::Add(sum_x, hn::IfThenElseZero(meets, dx)),
    sum_y = hn::Add(sum_y, hn::IfThenElseZero(meets, dy));
    sum_z = hn::Add(sum_z, hn::IfThenElseZero(meets, dz));
  }
  // A kernel loads more floats at once than doubles go in here: what lies in between must not be denormal,
  // or every operation on it costs as much as a whole packet.
  const std::size_t wide = hn::Lanes(Floats());
  for (std::size_t i = 0; i < kPacketSize; i += lanes) {
    if ((p.live >> i & group) || !(p.live >> (i / wide * wide) & ((std::uint64_t{1} << wide) - 1))) continue;
    const auto zero = hn::Zero(f);
    for (int a = 0; a < 3; ++a)
      hn::Store(zero, f, p.org[a] + i), hn::Store(zero, f, p.dir[a] + i), hn::Store(zero, f, p.inv[a] + i);
    hn::Store(zero, f, p.tmin + i), hn::Store(zero, f, p.tmax + i);
  }
  p.order[0] = static_cast<float>(hn::GetLane(hn::SumOfLanes(d, sum_x)));
  p.order[1] = static_cast<float>(hn::GetLane(hn::SumOfLanes(d, sum_y)));
  p.order[2] = static_cast<float>(hn::GetLane(hn::SumOfLanes(d, sum_z)));
}

}  // namespace HWY_NAMESPACE
}  // namespace trimray::trace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trimray::trace {

HWY_EXPORT(TraverseKernel);
HWY_EXPORT(NearCapsuleKernel);
HWY_EXPORT(SetKernel);

void traverse(const Bvh& bvh, RayPacket& packet, LeafVisitor visit, void* context, std::uint64_t* nodes) {
  if (bvh.nodes.empty() || packet.live == 0) return;
  HWY_DYNAMIC_DISPATCH(TraverseKernel)(bvh, packet, visit, context, nodes);
}

std::uint64_t near_capsule(const RayPacket& packet, const Capsule& capsule, std::uint64_t rays) {
  return HWY_DYNAMIC_DISPATCH(NearCapsuleKernel)(packet, capsule, rays);
}

void RayPacket::set(const Bvh& bvh, const RayBlock& block, std::uint64_t rays) {
  HWY_DYNAMIC_DISPATCH(SetKernel)(*this, bvh, block, rays);
}

}  // namespace trimray::trace
#endif
