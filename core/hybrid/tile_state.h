// What a tile's rays have met so far. A slot is one ray: place * kTileSlots + y * kMaxTile + x.
#pragma once

#include <vector>

#include "core/hybrid/footprint.h"
#include "core/trace/scene_impl.h"
#include "core/trace/tile.h"

namespace trimray::hybrid {

inline constexpr int kTileSlots = kMaxTile * kMaxTile;

// What is certain of a ray about one surface, beyond its nearest hit.
struct KnownRoot {
  std::int32_t instance = -1;
  std::int32_t face = kNoFace;  // all of this face's roots (closed forms) have been considered
  std::int32_t primitive = -1;  // or all on this leaf,
  std::int32_t patch = -1;      // of this patch, where a root lies at
  double u = 0.0, v = 0.0;      // these parameters
};

struct TileState {
  std::vector<float> best;  // depth of the nearest hit, rounded up, relative to the view's reference
  std::vector<double> t;    // of it, in the world
  std::vector<trace::HitPlace> place;  // of it; no face: none yet
  std::vector<dvec3> normal;           // of patch roots, outward, in the prototype
  std::vector<KnownRoot> known;
  std::vector<std::uint64_t> near_edge;  // by place and row: bits of pixels that may be near an edge

  void reset(const trace::Tile& tile) {
    const std::size_t slots = tile.places.size() * kTileSlots;
    if (best.size() < slots)
      best.resize(slots), t.resize(slots), place.resize(slots), normal.resize(slots), known.resize(slots);
    near_edge.assign(tile.places.size() * kMaxTile, 0);
    for (std::size_t p = 0; p < tile.places.size(); ++p)
      for (int y = 0; y < tile.y1 - tile.y0; ++y) {
        const std::size_t row = p * kTileSlots + static_cast<std::size_t>(y) * kMaxTile;
        std::fill_n(best.begin() + row, tile.width(), kFarDepth);
        std::fill_n(t.begin() + row, tile.width(), kInf);
        for (int x = 0; x < tile.width(); ++x) place[row + x].face = kNoFace, known[row + x].instance = -1;
      }
  }
};

}  // namespace trimray::hybrid
