// Puts things that are near each other in space next to each other in an array.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/types.h"

namespace trimray::trace {

struct Neighbour {
  glm::vec3 middle;  // near enough to sort by
  std::int32_t index;
};

// Reorders so that each `run` items in a row, counted from the first, lie close together, by halving along
// the widest axis. The same order for any number of threads; equal middles go by index.
void arrange_neighbours(std::span<Neighbour> items, std::size_t run, int threads);

}  // namespace trimray::trace
