#include "core/view/sampling.h"

#include <cmath>
#include <numbers>

namespace trimray::view {

std::vector<dvec2> sample_pattern(int count) {
  if (count <= 1) return {{0.5, 0.5}};
  if (count == 4) return {{0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}};
  std::vector<dvec2> points;
  points.reserve(static_cast<std::size_t>(count));
  dvec2 mean(0.0);
  for (int i = 0; i < count; ++i) {
    const double x = (i + 0.5) * (std::numbers::phi - 1.0);
    points.push_back({x - std::floor(x), (i + 0.5) / count});
    mean += points.back() / static_cast<double>(count);
  }
  // Centred: a picture must not shift by a part of a pixel with the number of samples.
  for (dvec2& p : points) p = glm::clamp(p + dvec2(0.5) - mean, dvec2(0.0), dvec2(1.0));
  return points;
}

}  // namespace trimray::view
