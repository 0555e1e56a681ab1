// The hybrid tracer: the first hits of a camera's rays, bit by bit those of trace::Scene::cast, found from
// seeds and certified against all that could lie in front of them.
#pragma once

#include <memory>

#include "core/trace/scene.h"
#include "core/trace/tile.h"
#include "core/view/camera.h"
#include "raster/seed_buffers.h"

namespace trimray::hybrid {

// Counters for reports and tests.
struct HybridStats {
  std::uint64_t rays = 0, hits = 0;
  std::uint64_t seeded = 0;        // hits that the seed's own surface gave
  std::uint64_t solves = 0;        // rays x surfaces that an intersector was called for
  std::uint64_t newton_steps = 0;  // of all solves
  std::uint64_t newton_roots = 0;  // solves that ran Newton's method
  std::uint64_t open = 0;          // solves that Newton's method left open: subdivision
  std::uint64_t edge_rays = 0;     // traced one by one through the hierarchy: near an edge
  std::uint64_t candidates = 0;    // leaves, summed over tiles
  std::uint64_t crowded = 0;       // rays of tiles with so many leaves that packets of rays did them instead
};

// Leaves a pixel of a tile from which on packets of rays are the faster way to the same hits: measured on
// boards and assemblies of 20 to 50,000 leaves in pictures of 256 to 1024 px, with 1 and 4 samples; between 1
// and 2 it makes little difference.
inline constexpr double kCrowdedLeaves = 1.0;

// One camera on one scene. Immutable; trace() may be called from many threads, tile by tile.
class HybridView {
 public:
  // scene and seeds must outlive the view. seeds: of the same camera, or null: every ray finds its surface
  // among the leaves that cover its pixel. crowded_leaves: see above; infinity: never packets.
  HybridView(const trace::Scene& scene, const view::Camera& camera, const raster::SeedBuffers* seeds,
             double crowded_leaves = kCrowdedLeaves);
  HybridView(HybridView&&) noexcept;
  ~HybridView();

  // Adds to *stats. Throws ArgumentError for a tile of more than 64 px a side, or not within the picture.
  void trace(const trace::Tile& tile, trace::TileHits& out, HybridStats* stats = nullptr) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trimray::hybrid
