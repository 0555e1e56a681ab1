// A tile of a picture: which rays go through it, and what they met.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/trace/ray.h"

namespace trimray::trace {

// Pixels [x0, x1) x [y0, y1); one ray through each of `places` (in the unit square) of each pixel.
struct Tile {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  std::span<const dvec2> places;
  int width() const { return x1 - x0; }
  std::size_t rays() const {
    return static_cast<std::size_t>(x1 - x0) * static_cast<std::size_t>(y1 - y0) * places.size();
  }
};

// Rays that met something, by their number ((y - y0) * width + (x - x0)) * places + place, increasing.
struct TileHits {
  std::vector<std::int32_t> ray;
  std::vector<Hit> hit;  // as ray
};

}  // namespace trimray::trace
