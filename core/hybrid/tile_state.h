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

// The nearest hit of a ray so far.
struct SlotHit {
  double t = kInf;  // in the world
  trace::HitPlace place;
  dvec3 normal{0.0};  // outward, in the prototype; not of triangles
};

// What no bit stands for is not initialized: most slots of most tiles are never touched.
struct TileState {
  std::vector<float> best;  // by slot: depth of the nearest hit, rounded up, relative to the view's reference
  std::vector<SlotHit> hits;     // by slot
  std::vector<KnownRoot> known;  // by slot
  // By place and row, a bit a pixel.
  std::vector<std::uint64_t> has_hit, has_known, near_edge;

  static bool has(const std::vector<std::uint64_t>& bits, std::int32_t slot) {
    return (bits[slot / kMaxTile] >> (slot % kMaxTile)) & 1;
  }
  static void set(std::vector<std::uint64_t>& bits, std::int32_t slot) {
    bits[slot / kMaxTile] |= std::uint64_t{1} << (slot % kMaxTile);
  }
  double t(std::int32_t slot) const { return has(has_hit, slot) ? hits[slot].t : kInf; }
  void know(std::int32_t slot, const KnownRoot& root) { known[slot] = root, set(has_known, slot); }

  void reset(const trace::Tile& tile) {
    const std::size_t slots = tile.places.size() * kTileSlots;
    if (best.size() < slots) best.resize(slots), hits.resize(slots), known.resize(slots);
    for (auto* bits : {&has_hit, &has_known, &near_edge}) bits->assign(tile.places.size() * kMaxTile, 0);
    for (std::size_t p = 0; p < tile.places.size(); ++p)
      for (int y = 0; y < tile.y1 - tile.y0; ++y)
        std::fill_n(best.begin() + p * kTileSlots + static_cast<std::size_t>(y) * kMaxTile, tile.width(),
                    kFarDepth);
  }
};

}  // namespace trimray::hybrid
