// Random trim loops, gentle and nasty, for property tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/core/tess/trimmed_stores.h"

namespace trimray::nurbs {

using Random = std::mt19937;

inline double uniform(Random& random, double lo, double hi) {
  return lo + (hi - lo) * (static_cast<double>(random()) / 4294967296.0);
}

// Corners around c, radius `r` times [depth, 1], counter-clockwise: a star as seen from c.
inline std::vector<dvec2> star(Random& random, dvec2 c, double r, int corners, double depth) {
  std::vector<dvec2> points;
  for (int i = 0; i < corners; ++i) {
    const double a = 2.0 * std::numbers::pi * (i + uniform(random, 0.1, 0.9)) / corners;
    points.push_back(c + r * uniform(random, depth, 1.0) * dvec2(std::cos(a), std::sin(a)));
  }
  return points;
}

// Cubics through the points, tangents along the chords of their neighbours (Catmull and Rom).
inline TrimLoop smooth(const std::vector<dvec2>& p) {
  TrimLoop loop;
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    const dvec2 a = p[i], b = p[(i + 1) % n];
    const dvec2 ta = 0.5 * (b - p[(i + n - 1) % n]), tb = 0.5 * (p[(i + 2) % n] - a);
    loop.push_back({dvec3(a, 1), dvec3(a + ta / 4.0, 1), dvec3(b - tb / 4.0, 1), dvec3(b, 1)});
  }
  return loop;
}

inline TrimLoop rectangle(dvec2 lo, dvec2 hi) { return polygon({lo, {hi.x, lo.y}, hi, {lo.x, hi.y}}); }

// An outer loop in [0, 1]^2 and up to `holes` holes that stay clear of it and of one another.
inline std::vector<TrimLoop> gentle_loops(Random& random, int holes) {
  const int corners = 3 + static_cast<int>(random() % 14);
  std::vector<TrimLoop> loops;
  double inner = 0.2;
  if (random() % 3 == 0) {
    loops.push_back(rectangle({0.02, 0.02}, {0.98, 0.98})), inner = 0.48;
  } else if (random() % 2 == 0) {
    loops.push_back(polygon(star(random, dvec2(0.5), 0.49, std::max(corners, 7), 0.6))), inner = 0.17;
  } else {
    loops.push_back(smooth(star(random, dvec2(0.5), 0.42, std::max(corners, 7), 0.7))), inner = 0.2;
  }
  // Cells of a grid over the square that lies within.
  const int cells = 3;
  const double size = 1.4 * inner / cells;
  std::vector<int> order(cells * cells);
  for (int i = 0; i < cells * cells; ++i) order[i] = i;
  for (int i = cells * cells - 1; i > 0; --i) std::swap(order[i], order[random() % (i + 1)]);
  for (int h = 0; h < holes && h < cells * cells; ++h) {
    const dvec2 c = dvec2(0.5 - 0.7 * inner) + size * (dvec2(order[h] % cells, order[h] / cells) + 0.5);
    const double r = 0.45 * size * uniform(random, 0.05, 1.0);
    switch (random() % 3) {
      case 0:
        loops.push_back(turned(ellipse(c, r, r * uniform(random, 0.01, 1.0))));
        break;
      case 1:
        loops.push_back(turned(polygon(star(random, c, r, 3 + int(random() % 9), 0.1))));
        break;
      default:
        loops.push_back(turned(smooth(star(random, c, 0.8 * r, 6 + int(random() % 6), 0.6))));
    }
  }
  return loops;
}

// Loops that touch, coincide or nearly do so; all within [0, 1]^2.
inline std::vector<TrimLoop> nasty_loops(Random& random, int kind) {
  std::vector<TrimLoop> loops{rectangle({0, 0}, {1, 1})};
  const double gaps[] = {0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3};
  const double gap = gaps[random() % 7];
  const auto circle = [](dvec2 c, double r) { return turned(ellipse(c, r, r)); };
  switch (kind % 10) {
    case 0:  // a chain of circles, each touching the next
      for (int i = 0; i < 5; ++i) loops.push_back(circle({0.12 + i * (0.18 + gap), 0.5}, 0.09));
      break;
    case 1:  // a circle that touches the rim
      loops.push_back(circle({0.2 + gap, 0.5}, 0.2));
      break;
    case 2:  // a square hole with a corner on the rim
      loops.push_back(turned(polygon({{gap, 0.5}, {0.2, 0.3}, {0.4, 0.5}, {0.2, 0.7}})));
      break;
    case 3:  // two holes that share a side
      loops.push_back(turned(rectangle({0.2, 0.2}, {0.5, 0.8})));
      loops.push_back(turned(rectangle({0.5 + gap, 0.2}, {0.8, 0.8})));
      break;
    case 4:  // a slot of next to no width
      loops.push_back(turned(rectangle({0.1, 0.5}, {0.9, 0.5 + std::max(gap, 1e-12)})));
      break;
    case 5:  // a rim with a spike of next to no width
      loops = {polygon({{0, 0}, {1, 0}, {1, 0.5 - gap}, {3, 0.5}, {1, 0.5 + gap}, {1, 1}, {0, 1}})};
      break;
    case 6:  // a spike inwards
      loops = {polygon({{0, 0}, {1, 0}, {1, 0.5 - gap}, {0.1, 0.5}, {1, 0.5 + gap}, {1, 1}, {0, 1}})};
      break;
    case 7:  // very short sides
      loops = {polygon({{0, 0}, {0.5, 0}, {0.5 + std::max(gap, 1e-14), 0}, {1, 0}, {1, 1}, {0, 1}})};
      break;
    case 8:  // holes corner to corner
      loops.push_back(turned(rectangle({0.2, 0.2}, {0.5, 0.5})));
      loops.push_back(turned(rectangle({0.5 + gap, 0.5 + gap}, {0.8, 0.8})));
      break;
    default:  // a hole that crosses the rim by a hair or more: no region at all, strictly
      loops.push_back(turned(rectangle({-gap, 0.4}, {0.5, 0.6})));
  }
  // Somewhere else, at some other size and turn.
  const double turn = uniform(random, 0.0, 6.28), size = std::pow(10.0, uniform(random, -2.0, 2.0));
  const dvec2 shift(uniform(random, -9.0, 9.0), uniform(random, -9.0, 9.0));
  if (random() % 2 == 0) return loops;
  for (TrimLoop& loop : loops)
    for (TrimPiece& piece : loop)
      for (dvec3& h : piece) {
        const dvec2 uv = dvec2(h.x, h.y) / h.z;
        const dvec2 moved = shift + size * dvec2(std::cos(turn) * uv.x - std::sin(turn) * uv.y,
                                                 std::sin(turn) * uv.x + std::cos(turn) * uv.y);
        h = h.z * dvec3(moved, 1.0);
      }
  return loops;
}

// A Bezier patch over [0, 1]^2 that bulges at random.
inline SurfaceForm random_patch(Random& random, int degree_u, int degree_v, double bulge, bool rational) {
  std::vector<dvec4> ctrl;
  for (int i = 0; i <= degree_u; ++i) {
    for (int j = 0; j <= degree_v; ++j) {
      const double w = rational ? uniform(random, 0.5, 2.0) : 1.0;
      const dvec3 p(double(i) / degree_u + uniform(random, -0.1, 0.1) * bulge,
                    double(j) / degree_v + uniform(random, -0.1, 0.1) * bulge,
                    uniform(random, -0.3, 0.3) * bulge);
      ctrl.emplace_back(w * 10.0 * p, w);
    }
  }
  return make_bezier(degree_u, degree_v, std::move(ctrl));
}

}  // namespace trimray::nurbs
