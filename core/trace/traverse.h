// Packets of rays through a Bvh: 64 rays at a time, SIMD over the rays of a node's box.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/trace/bvh.h"

namespace trimray::trace {

inline constexpr int kPacketSize = 64;

// Rays of one packet in double, structure of arrays. dir has unit length.
struct RayBlock {
  alignas(64) double org[3][kPacketSize];
  alignas(64) double dir[3][kPacketSize];
  alignas(64) double tmin[kPacketSize], tmax[kPacketSize];

  dvec3 origin(int i) const { return {org[0][i], org[1][i], org[2][i]}; }
  dvec3 direction(int i) const { return {dir[0][i], dir[1][i], dir[2][i]}; }
  void set(int i, dvec3 o, dvec3 d, double near, double far) {
    for (int a = 0; a < 3; ++a) org[a][i] = o[a], dir[a][i] = d[a];
    tmin[i] = near, tmax[i] = far;
  }
};

// The same rays relative to one Bvh, in float. t counts from the ray's point nearest to the Bvh's center.
// The boxes are dilated enough to cover every rounding in here. Not initialized before set().
struct RayPacket {
  alignas(64) float org[3][kPacketSize];
  alignas(64) float dir[3][kPacketSize];
  alignas(64) float inv[3][kPacketSize];  // 1 / dir, finite
  alignas(64) float tmin[kPacketSize], tmax[kPacketSize];
  alignas(64) double t0[kPacketSize];  // the ray's own t at org
  std::uint64_t live;                  // rays still of interest; a leaf may take bits away
  float order[3];                      // direction along which children are sorted

  // Makes those of `rays` live that do not pass the Bvh by and are finite.
  void set(const Bvh& bvh, const RayBlock& block, std::uint64_t rays);
  void set_tmax(int i, double ray_tmax) { tmax[i] = float_above(ray_tmax - t0[i]); }

  // Rounded towards +infinity by more than a float's half ulp; finite.
  static float float_above(double t) {
    return static_cast<float>(
        std::clamp(t + std::abs(t) * kAbove, -static_cast<double>(kFar), static_cast<double>(kFar)));
  }
  static constexpr double kAbove = 1.2e-7;
  static constexpr float kFar = 3e37f;
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
