// The makers of rasterizers, and what all of them do alike.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "raster/rasterizer.h"

namespace trimray::raster {

// backend: kOsmesa or kEgl. All throw Error with the reason where the library does not load or cannot draw.
std::unique_ptr<Rasterizer> make_gl_rasterizer(Backend backend);
std::string gl_version(Backend backend);
std::unique_ptr<Rasterizer> make_embree_rasterizer();
std::string embree_version();

// What every backend asks of a view before it draws. Throws ArgumentError.
void check_view(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store, const view::Camera& camera);

// Targets of all instances, one after the other; first[i]: the id of instance i's first target.
struct AllTargets {
  std::vector<SeedTarget> targets;
  std::vector<std::uint32_t> first;

  void add(std::int32_t instance, const std::vector<SeedTarget>& more);
};

}  // namespace trimray::raster
