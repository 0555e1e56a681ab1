// Bezier pieces of the store's surfaces by blossoming, and the few operations on them that the reference
// tracer needs. Written for plainness: long double where it is free, vectors of coefficients elsewhere.
#pragma once

#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/nurbs/store.h"

namespace trimray::reference {

using Real = long double;
using Vec2 = glm::vec<2, Real>;
using Vec3 = glm::vec<3, Real>;
using Vec4 = glm::vec<4, Real>;

// One rational Bezier piece of a face over [s0, s1] x [t0, t1] of the NURBS parameters; ctrl[i * (q + 1) + j]
// is homogeneous and relative to the face's own origin: (w (x - cx), ..., w).
struct Patch {
  int p = 0, q = 0;
  double s0 = 0, s1 = 0, t0 = 0, t1 = 0;
  std::vector<Vec4> ctrl;
};

struct PatchPoint {
  Vec4 h{0}, hx{0}, hy{0};  // homogeneous point and its derivatives in the piece's [0, 1] parameters
};

// Part of the NURBS parameter line that one knot span answers for.
struct Span {
  int index = 0;  // knots[index] <= s <= knots[index + 1], except where an end span is extended
  double lower = 0.0, upper = 0.0;
};

// The spans of a clamped knot vector that meet [lower, upper]; the first and the last span reach out to the
// interval's ends where these lie beyond the knots.
std::vector<Span> spans_over(std::span<const double> knots, int degree, double lower, double upper);

// The piece of the surface over one span in each direction, exact up to rounding: the Bezier points are the
// values of the blossom at repeated span ends (Ramshaw 1987), whether the interval lies within the knots or
// not.
Patch extract(const nurbs::NurbsStore& store, const nurbs::Surface& surface, const Span& u, const Span& v,
              const Vec3& origin);

PatchPoint evaluate(const Patch& patch, Real x, Real y);

// NURBS parameter of a uv_face coordinate and back, by the formulas of nurbs::ParamMap.
double to_nurbs(std::span<const double> knots, nurbs::ParamMap map, double u);
double to_face(std::span<const double> knots, nurbs::ParamMap map, double s);

}  // namespace trimray::reference
