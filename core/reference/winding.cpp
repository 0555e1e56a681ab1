#include "core/reference/winding.h"

#include <algorithm>

namespace trimray::reference {
namespace {

constexpr int kMaxDepth = 60;

int halve(std::vector<dvec2>& c, int depth) {
  const bool start = c.front().y >= 0.0, end = c.back().y >= 0.0;
  bool above = true, below = true, right = true, left = true;
  for (const dvec2& p : c) {
    above = above && p.y >= 0.0, below = below && p.y < 0.0;
    right = right && p.x >= 0.0, left = left && p.x < 0.0;
  }
  if (above || below || left) return 0;
  const int rise = int(end) - int(start);
  if (right) return rise;
  if (c.size() == 2 || depth == kMaxDepth) {
    if (rise == 0) return 0;
    // The chord meets y = 0 at x = (x0 y1 - x1 y0) / (y1 - y0), whose sign needs no division.
    const dvec2 a = c.front(), b = c.back();
    const double cross = a.x * b.y - b.x * a.y;
    return (rise > 0 ? cross >= 0.0 : cross <= 0.0) ? rise : 0;
  }
  std::vector<dvec2> low(c.size());
  const std::size_t n = c.size();
  for (std::size_t r = 0; r < n; ++r) {
    low[r] = c[0];
    for (std::size_t i = 0; i + r + 1 < n; ++i) c[i] = 0.5 * (c[i] + c[i + 1]);
  }
  // What is left in c is the upper half: c[i] = b_i^(n-1-i).
  return halve(low, depth + 1) + halve(c, depth + 1);
}

}  // namespace

int half_line_crossings(const std::vector<dvec2>& curve) {
  std::vector<dvec2> c = curve;
  return c.empty() ? 0 : halve(c, 0);
}

}  // namespace trimray::reference
