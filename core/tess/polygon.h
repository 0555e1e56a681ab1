// A polygon in space as triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace trimray::tess {

// Appends corners.size() - 2 triangles (fewer where corners coincide) that cover the polygon and run round
// as it does. corners: indices into points, at least 3. Concave polygons are cut where they should be, seen
// along their mean normal; of one that crosses itself, what cannot be cut so becomes a fan.
void triangulate_polygon(std::span<const dvec3> points, std::span<const std::int32_t> corners,
                         std::vector<std::array<std::int32_t, 3>>& triangles);

}  // namespace trimray::tess
