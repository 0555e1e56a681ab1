// Knot vectors and B-spline basis functions.
//
// A flat knot vector repeats each knot by its multiplicity: count + degree + 1 values. Its natural domain is
// [knots[degree], knots[count]]. Spans are half-open, [knots[i], knots[i + 1]), the last one closed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/nurbs/store.h"

namespace trimray::nurbs {

// The highest degree that is evaluated; OpenCascade stops at 25.
inline constexpr int kMaxDegree = 30;

// Index i with knots[i] <= s < knots[i + 1], never an empty span. s before or behind the domain belongs to
// the first or last span.
int find_span(std::span<const double> knots, int degree, double s);

// Values and derivatives of the degree + 1 basis functions that do not vanish on a span, at s, which may
// lie outside it (the polynomials continue). out[k][j]: k-th derivative of function span - degree + j.
// Algorithm A2.3, The NURBS Book, for derivatives up to the second.
struct Basis {
  double value[3][kMaxDegree + 1];
};
void basis_functions(std::span<const double> knots, int degree, int span, double s, int derivatives,
                     Basis& out);

// One direction's parameter map on the span [a, b]: s(u) and its first two derivatives.
struct MappedParameter {
  double s = 0.0, ds = 1.0, dds = 0.0;
};
MappedParameter map_parameter(ParamMap map, double a, double b, double u);
double unmap_parameter(ParamMap map, double a, double b, double s);

// u + k * period next to middle; u when period is 0.
double wrap_near(double u, double middle, double period);

// The distinct values of a flat knot vector within its natural domain, both ends included.
std::vector<double> distinct_knots(std::span<const double> knots, int degree);

}  // namespace trimray::nurbs
