// Rays and what they meet.
#pragma once

#include <cstdint>

#include "core/base/types.h"

namespace trimray::trace {

// dir has unit length inside the tracer; entry points divide by the caller's length and give t back in
// multiples of it.
struct Ray {
  dvec3 org{0.0}, dir{0.0};
  double tmin = 0.0, tmax = kInf;
};

inline constexpr int kLanes = 8;  // doubles in one AVX-512 register; narrower targets take several passes

// One ray a lane, structure of arrays; inactive lanes may hold anything finite.
struct RayLanes {
  alignas(64) double org_x[kLanes], org_y[kLanes], org_z[kLanes];
  alignas(64) double dir_x[kLanes], dir_y[kLanes], dir_z[kLanes];  // unit
  std::uint32_t active = 0;                                        // bit i: lane i
};

inline void copy_lane(const RayLanes& from, int i, RayLanes& to, int k) {
  to.org_x[k] = from.org_x[i], to.org_y[k] = from.org_y[i], to.org_z[k] = from.org_z[i];
  to.dir_x[k] = from.dir_x[i], to.dir_y[k] = from.dir_y[i], to.dir_z[k] = from.dir_z[i];
}

// A crossing of a ray's line with the (extended) surface of one face.
struct Root {
  double t = 0.0;
  dvec2 uv_face{0.0};
  dvec3 normal{0.0};  // unit, outward: Su x Sv, turned if the face is reversed
  std::int32_t face = kNoFace;
  std::int8_t sign =
      0;  // +1 where the line leaves through the face (dot(normal, dir) > 0), -1 where it enters
  bool inside = false;  // by the p-curves
};

struct Hit {
  double t = kInf;
  std::int32_t face = kNoFace, instance = -1;
  dvec2 uv_face{0.0};
  dvec3 normal{0.0};  // outward, unit, in the world
};

}  // namespace trimray::trace
