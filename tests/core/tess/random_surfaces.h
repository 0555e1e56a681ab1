// Random surfaces in stores of their own, for property tests of charts and bounds.
#pragma once

#include <string>
#include <vector>

#include "core/tess/chart.h"
#include "tests/core/tess/random_loops.h"

namespace trimray::nurbs {

struct RandomSurface {
  NurbsStore store;
  Box2 box;  // of the chart, clear of poles
  std::string name;
  const Surface& surface() const { return store.surfaces[0]; }
};

inline RandomSurface in_store(const SurfaceForm& form, const Box2& box, std::string name) {
  RandomSurface r;
  append_surface(r.store, form);
  r.box = box, r.name = std::move(name);
  return r;
}

// Plane, cylinder, cone, sphere, torus: native (forms 0-4) and as NURBS (5-9; charts in uv_face, as mapped).
inline RandomSurface random_closed_form(Random& random, int form) {
  const Frame3 frame{{uniform(random, -5, 5), uniform(random, -5, 5), 3},
                     {1, uniform(random, -1, 1), 0},
                     {uniform(random, -1, 1), uniform(random, -1, 1), 1.5}};
  const double r = uniform(random, 0.5, 4.0);
  const char* names[] = {"plane", "cylinder", "cone", "sphere", "torus"};
  SurfaceForm f;
  Box2 box{{0.2, -1.0}, {5.8, 1.1}};
  switch (form % 5) {
    case 0:
      f = make_plane(frame);
      break;
    case 1:
      f = make_cylinder(frame, r);
      break;
    case 2:
      f = make_cone(frame, r + 1.5, uniform(random, -1.0, 1.0));
      break;
    case 3:
      f = make_sphere(frame, r);
      break;
    default:
      f = make_torus(frame, r + 1.0, uniform(random, 0.2, 1.0) * r);
      box.lower.y = 0.3, box.upper.y = 5.9;
  }
  std::string name = names[form % 5];
  if (form >= 5) f = as_nurbs(f), name += " as NURBS";
  return in_store(f, box, name);
}

// Clamped, over [0, 1]^2, inner knots at random with up to full multiplicity when kinked.
inline RandomSurface random_bspline(Random& random, bool rational, bool kinked) {
  int degree[2], count[2];
  std::vector<double> knots[2];
  for (int d = 0; d < 2; ++d) {
    degree[d] = 1 + static_cast<int>(random() % 4);
    knots[d].assign(degree[d] + 1, 0.0);
    const int inner = static_cast<int>(random() % 4);
    for (int k = 1; k <= inner; ++k) {
      const double x = (k + uniform(random, -0.3, 0.3)) / (inner + 1);
      const int most = kinked ? degree[d] : std::max(1, degree[d] - 1);
      knots[d].insert(knots[d].end(), 1 + static_cast<int>(random() % most), x);
    }
    knots[d].insert(knots[d].end(), degree[d] + 1, 1.0);
    count[d] = static_cast<int>(knots[d].size()) - degree[d] - 1;
  }
  std::vector<dvec4> ctrl;
  for (int i = 0; i < count[0]; ++i)
    for (int j = 0; j < count[1]; ++j) {
      const double w = rational ? uniform(random, 0.5, 2.0) : 1.0;
      const dvec3 p(10.0 * i / (count[0] - 1) + uniform(random, -0.5, 0.5),
                    8.0 * j / (count[1] - 1) + uniform(random, -0.5, 0.5), uniform(random, -1.5, 1.5));
      ctrl.emplace_back(w * p, w);
    }
  const std::string name = "degree " + std::to_string(degree[0]) + " x " + std::to_string(degree[1]) +
                           (rational ? ", rational" : "") + (kinked ? ", kinked" : "");
  return in_store(make_bspline(degree[0], degree[1], knots[0], knots[1], std::move(ctrl)), {{0, 0}, {1, 1}},
                  name);
}

inline dvec2 uv_in(Random& random, const Box2& box) {
  return {uniform(random, box.lower.x, box.upper.x), uniform(random, box.lower.y, box.upper.y)};
}

inline Box2 box_in(Random& random, const Box2& box) {
  Box2 r;
  const double share = std::pow(10.0, uniform(random, -2.0, 0.0));
  const dvec2 a = uv_in(random, box);
  r.add(a), r.add(a + share * (uv_in(random, box) - a));
  return r;
}

// Second derivatives by central differences of the first, which are exact; good to about 1e-6 of them. Not
// across a knot.
struct SecondDerivatives {
  dvec3 uu, uv, vv;
};
inline SecondDerivatives second_derivatives(const tess::Chart& chart, dvec2 p) {
  constexpr double h = 1e-5;
  const auto u0 = chart.at(p - dvec2(h, 0)), u1 = chart.at(p + dvec2(h, 0)), v0 = chart.at(p - dvec2(0, h)),
             v1 = chart.at(p + dvec2(0, h));
  return {(u1.du - u0.du) / (2 * h), (v1.du - v0.du) / (2 * h), (v1.dv - v0.dv) / (2 * h)};
}

// Is p within 2e-5 of a knot in either direction?
inline bool near_knot(const RandomSurface& s, dvec2 p) {
  const Range ranges[2] = {s.surface().knots_u, s.surface().knots_v};
  for (int d = 0; d < 2; ++d)
    for (std::int32_t k = ranges[d].begin; k < ranges[d].end; ++k)
      if (std::abs(s.store.knots[k] - p[d]) < 2e-5) return true;
  return false;
}

}  // namespace trimray::nurbs
