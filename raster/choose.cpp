// Which backend gives seeds soonest.
#include "raster/rasterizer.h"

namespace trimray::raster {

namespace {

// Where packets of rays overtake the raster pass, in covered pixels a triangle: between 0.7 and 2.3 for
// part.igs, the teapot, NIST_MBE_PMI_2 and Bowden_Module at 512 px. They never do on a mesh drawn for the
// first time, since their hierarchy takes 0.3 us a triangle to build, and the raster pass's blocks 0.07 us.
constexpr double kCrossing = 1.5;

}  // namespace

std::optional<Backend> choose(double covered_px, std::size_t triangles, Meshes meshes) {
  const bool raster = meshes == Meshes::kFresh || kCrossing * static_cast<double>(triangles) <= covered_px;
  constexpr Backend kRasterFirst[] = {Backend::kOsmesa, Backend::kEgl, Backend::kEmbree};
  constexpr Backend kRaysFirst[] = {Backend::kEmbree, Backend::kOsmesa, Backend::kEgl};
  for (const Backend backend : raster ? kRasterFirst : kRaysFirst)
    if (available(backend)) return backend;
  return std::nullopt;
}

}  // namespace trimray::raster
