// Who answers a picture's rays: the standard tracer, the reference, or the hybrid one.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/trace/ray.h"
#include "core/trace/scene.h"
#include "core/trace/tile.h"
#include "core/view/camera.h"

namespace trimray::trace {

// All are called from many threads at once, and must not start threads of their own. They agree: a ray's
// nearest hit is the first of `all`, bit by bit.
struct Caster {
  std::function<void(const Tile&, TileHits&)> tile;                        // rays of the picture's camera
  std::function<void(const Ray&, std::vector<Hit>&)> all;                  // sorted by t
  std::function<void(std::span<const Ray>, std::span<Hit>)> nearest = {};  // rays of any kind
  double edge_band = 0.0;  // mm: how far around an edge a hit may be taken for either of its faces
};

// The rays of `camera`, tile by tile, out of `nearest`: they are given to it in packets
// that stay within small squares of the picture, with the samples of a pixel side by side.
std::function<void(const Tile&, TileHits&)> tiles_of(
    const view::Camera& camera, std::function<void(std::span<const Ray>, std::span<Hit>)> nearest);

// scene must outlive the caster.
Caster standard_caster(const Scene& scene, const view::Camera& camera);

}  // namespace trimray::trace
