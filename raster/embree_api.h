// The few functions and records of Embree 3 that give seeds, declared as embree3/rtcore.h has them; they are
// loaded at run time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "raster/dynamic_library.h"

namespace trimray::raster::embree {

using Device = void*;
using Scene = void*;
using Geometry = void*;

inline constexpr int kTriangles = 0, kIndexBuffer = 0, kVertexBuffer = 1, kUint3 = 0x5003, kFloat3 = 0x9003,
                     kLowQuality = 0, kCoherent = 1;
inline constexpr std::intptr_t kVersion = 0;
inline constexpr unsigned kNothing = ~0u;

// 16 rays and their hits.
struct alignas(64) RayHit16 {
  float org_x[16], org_y[16], org_z[16], tnear[16];
  float dir_x[16], dir_y[16], dir_z[16], time[16];
  float tfar[16];
  unsigned mask[16], id[16], flags[16];
  float normal_x[16], normal_y[16], normal_z[16];
  float u[16], v[16];  // weights of a triangle's second and third corner
  unsigned primitive[16], geometry[16], instance[16];
};

// With room for what some builds append.
struct alignas(16) Context {
  int flags = kCoherent;
  void* filter = nullptr;
  unsigned instance = kNothing;
  float more[13] = {};
};

struct Library {
  DynamicLibrary library{"libembree3.so.3", "libembree3.so"};
  Device (*new_device)(const char*);
  int (*device_error)(Device);
  std::ptrdiff_t (*device_property)(Device, std::intptr_t);
  void (*release_device)(Device);
  Scene (*new_scene)(Device);
  void (*set_quality)(Scene, int);
  void (*commit_scene)(Scene);
  void (*release_scene)(Scene);
  Geometry (*new_geometry)(Device, int);
  void* (*new_buffer)(Geometry, int, unsigned, int, std::size_t, std::size_t);
  void (*commit_geometry)(Geometry);
  void (*release_geometry)(Geometry);
  unsigned (*attach)(Scene, Geometry);
  void (*intersect16)(const int*, Scene, Context*, RayHit16*);

  Library() {
    library.get(new_device, "rtcNewDevice");
    library.get(device_error, "rtcGetDeviceError");
    library.get(device_property, "rtcGetDeviceProperty");
    library.get(release_device, "rtcReleaseDevice");
    library.get(new_scene, "rtcNewScene");
    library.get(set_quality, "rtcSetSceneBuildQuality");
    library.get(commit_scene, "rtcCommitScene");
    library.get(release_scene, "rtcReleaseScene");
    library.get(new_geometry, "rtcNewGeometry");
    library.get(new_buffer, "rtcSetNewGeometryBuffer");
    library.get(commit_geometry, "rtcCommitGeometry");
    library.get(release_geometry, "rtcReleaseGeometry");
    library.get(attach, "rtcAttachGeometry");
    library.get(intersect16, "rtcIntersect16");
  }
};

}  // namespace trimray::raster::embree
