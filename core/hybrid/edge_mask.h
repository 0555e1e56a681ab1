// Which rays of a tile may pass near an edge: the capsules of the edges, rasterized conservatively.
#pragma once

#include "core/hybrid/instance_view.h"
#include "core/hybrid/tile_state.h"

namespace trimray::hybrid {

// Sets bits of state.near_edge for the rays that may come within the band of one of the instance's edges no
// farther behind the ray's nearest hit than reach (mm). rect: the tile's. reference: that of state.best. far:
// no ray's best is beyond.
void mark_edges(const InstanceView& view, const trace::Tile& tile, const FrameRect& rect, double reference,
                double reach, float far, TileState& state);

}  // namespace trimray::hybrid
