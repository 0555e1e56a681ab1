// What a raster pass saw at each pixel: where on which surface the tracer should look first.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace trimray::raster {

// The paper's two variants (Abert, Broecker, Spring, WSCG 2008, section 4).
enum class SeedProcess : std::uint8_t {
  kId,  // the buffer names a triangle; the seed is the mean of its corners' uv
  kUv   // the buffer names a surface, and holds the interpolated uv beside it
};

// u, v: fractions of the face's uv_box, so that floats are fine enough wherever the box lies.
struct SeedTarget {
  std::int32_t instance = -1, face = -1;
  float u = 0.5f, v = 0.5f;  // kUv: not used
};

// Row by row from the top, one entry a pixel, as seen through the pixel's centre. Nothing here is trusted:
// wrong seeds cost time, never a hit. The spans point into memory that `owner` keeps, in the format in which
// the raster pass left it.
struct SeedBuffers {
  int width_px = 0, height_px = 0;
  SeedProcess process = SeedProcess::kUv;
  std::span<const std::uint32_t> id;  // 0: nothing; else targets[id - 1]
  std::span<const float> uv;          // kUv: 2 a pixel; kId: empty
  std::vector<SeedTarget> targets;    // kId: by triangle; kUv: by surface
  std::shared_ptr<const void> owner;
};

}  // namespace trimray::raster
