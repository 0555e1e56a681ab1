#include "core/trace/neighbours.h"

#include <algorithm>
#include <vector>

#include "core/base/parallel.h"

namespace trimray::trace {
namespace {

constexpr std::size_t kAlone = 1 << 15;  // items that one thread arranges alone

using Items = std::span<Neighbour>;

// Half of the items to the left of the other half, along the axis in which they are spread widest; the left
// half is a multiple of `run` long.
std::size_t halve(Items items, std::size_t run) {
  glm::vec3 lower(items[0].middle), upper(lower);
  for (const Neighbour& i : items) lower = glm::min(lower, i.middle), upper = glm::max(upper, i.middle);
  const glm::vec3 extent = upper - lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::size_t runs = (items.size() + run - 1) / run, left = (runs + 1) / 2 * run;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(left), items.end(),
                   [axis](const Neighbour& a, const Neighbour& b) {
                     const float x = a.middle[axis], y = b.middle[axis];
                     return x != y ? x < y : a.index < b.index;
                   });
  return left;
}

// Ranges of at most `alone` items go to `rest`.
void arrange(Items items, std::size_t run, std::size_t alone, std::vector<Items>& rest) {
  if (items.size() <= run) return;
  if (items.size() <= alone) return rest.push_back(items);
  const std::size_t left = halve(items, run);
  arrange(items.first(left), run, alone, rest);
  arrange(items.subspan(left), run, alone, rest);
}

}  // namespace

void arrange_neighbours(Items items, std::size_t run, int threads) {
  std::vector<Items> parts;
  arrange(items, run, kAlone, parts);
  parallel_ranges(parts.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Items> none;
    for (std::size_t i = begin; i < end; ++i) arrange(parts[i], run, 0, none);
  });
}

}  // namespace trimray::trace
