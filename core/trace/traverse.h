// Packets of rays through a Bvh: 64 rays at a time, SIMD over the rays of a node's box.
#pragma once

#include <cstdint>

#include "core/trace/bvh.h"

namespace trimray::trace {

inline constexpr int kPacketSize = 64;

// Rays of one packet relative to one Bvh, structure of arrays, in float. t counts from the ray's point
// nearest to the Bvh's center. The boxes are dilated enough to cover every rounding in here.
struct RayPacket {
  alignas(64) float org[3][kPacketSize];
  alignas(64) float dir[3][kPacketSize];
  alignas(64) float inv[3][kPacketSize];  // 1 / dir, finite
  alignas(64) float tmin[kPacketSize], tmax[kPacketSize];
  alignas(64) double t0[kPacketSize];  // the ray's own t at org
  std::uint64_t live = 0;              // rays still of interest; a leaf may take bits away
  float order[3];                      // direction along which children are sorted

  // Places ray i; returns false (and leaves it out) when the ray passes the Bvh by or is not finite.
  bool set(int i, const Bvh& bvh, dvec3 ray_org, dvec3 ray_dir, double ray_tmin, double ray_tmax);
  void set_tmax(int i, double ray_tmax);
  // Call once after the last set().
  void finish();
};

// What a traversal does at a primitive: `rays` are those that meet its box before their tmax. It may shorten
// packet.tmax and clear bits of packet.live.
using LeafVisitor = void (*)(void* context, std::int32_t primitive, std::uint64_t rays);

// Visits primitives roughly front to back. Adds the number of nodes opened to *nodes.
void traverse(const Bvh& bvh, RayPacket& packet, LeafVisitor visit, void* context, std::uint64_t* nodes);

// Line segments with a radius (what an edge's path is close to), in floats relative to a Bvh's center.
struct Capsule {
  float a[3], b[3], radius;
};

// Those of `rays` whose line may pass within the capsule's radius of its segment; none is missed when
// the radius includes kCapsuleSlack of the Bvh's radius.
std::uint64_t near_capsule(const RayPacket& packet, const Capsule& capsule, std::uint64_t rays);
inline constexpr double kCapsuleSlack = 4e-6;

// One ray, without SIMD: the primitives whose boxes it meets, in no particular order.
template <typename Visit>
void traverse_one(const Bvh& bvh, dvec3 org, dvec3 dir, double tmin, double tmax, const Visit& visit);

}  // namespace trimray::trace

#include "core/trace/traverse_one.h"
