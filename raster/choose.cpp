// Which backend gives seeds soonest.
#include "raster/rasterizer.h"

namespace trimray::raster {

namespace {

// Where packets of rays overtake the raster pass: covered pixels a triangle.
constexpr double kCrossing = 2.5;

}  // namespace

std::optional<Backend> choose(double covered_px, std::size_t triangles, int /*threads*/) {
  const bool raster = kCrossing * static_cast<double>(triangles) <= covered_px;
  constexpr Backend kRasterFirst[] = {Backend::kOsmesa, Backend::kEgl, Backend::kEmbree};
  constexpr Backend kRaysFirst[] = {Backend::kEmbree, Backend::kOsmesa, Backend::kEgl};
  for (const Backend backend : raster ? kRasterFirst : kRaysFirst)
    if (available(backend)) return backend;
  return std::nullopt;
}

}  // namespace trimray::raster
