#include "core/nurbs/spline.h"

#include <cmath>
#include <functional>

namespace trimray::nurbs {

void sort_arguments(std::span<const double> knots, int degree, int span, double* x) {
  const double begin = knots[span], end = knots[span + 1];
  double* inner = std::partition(x, x + degree, [&](double t) { return t >= end || t <= begin; });
  double* lows = std::partition(x, inner, [&](double t) { return t >= end; });
  std::sort(x, lows, std::greater<>());
  std::sort(lows, inner);
}

Respan plan_respan(std::span<const double> knots, int degree, double a, double b) {
  const int count = static_cast<int>(knots.size()) - degree - 1;
  // Old inner knots between a and b are [first, last). Those a rounding away from an end fall together with
  // it: a span so short has no extent to solve for parameters in, only noise.
  const double apart = 1e-12 * (b - a);
  int first = degree + 1;
  while (first < count && !(knots[first] > a + apart && knots[first] > knots[degree])) ++first;
  int last = first;
  while (last < count && knots[last] < b - apart && knots[last] < knots[count]) ++last;

  Respan plan;
  plan.knots.assign(degree + 1, a);
  plan.knots.insert(plan.knots.end(), knots.begin() + first, knots.begin() + last);
  plan.knots.insert(plan.knots.end(), degree + 1, b);
  const int inner = last - first, new_count = degree + 1 + inner;
  for (int i = 0; i < new_count; ++i) {
    // Any non-empty new span in the support of the point will do.
    int q = std::max(i, degree);
    const int q_end = std::min(i + degree, new_count - 1);
    while (q < q_end && !(plan.knots[q + 1] > plan.knots[q])) ++q;
    const double middle = 0.5 * (plan.knots[q] + plan.knots[q + 1]);
    plan.spans.push_back(find_span(knots, degree, middle));
    plan.copies.push_back(i >= degree && i <= inner && inner >= degree ? first + i - degree - 1 : -1);
  }
  return plan;
}

FlatKnots flatten_knots(std::span<const double> distinct, std::span<const std::int32_t> multiplicities,
                        int degree, int poles, bool periodic, double a, double b) {
  FlatKnots r;
  if (!periodic) {
    for (std::size_t i = 0; i < distinct.size(); ++i)
      r.knots.insert(r.knots.end(), multiplicities[i], distinct[i]);
    for (int i = 0; i < poles; ++i) r.wrap.push_back(i);
    return r;
  }
  // One period of knots, whose first multiplicities[0] ones are the first knot: knot number j of the endless
  // sequence is one[j mod poles] + period * (j div poles), and pole j's knots begin degree + 1 -
  // multiplicities[0] places before it.
  const double period = distinct.back() - distinct.front();
  std::vector<double> one;
  for (std::size_t i = 0; i + 1 < distinct.size(); ++i) one.insert(one.end(), multiplicities[i], distinct[i]);
  const int n = static_cast<int>(one.size());
  const int shift = degree + 1 - multiplicities[0];
  const auto turn = [&](int j) { return j >= 0 ? j / n : -((n - 1 - j) / n); };
  const auto knot = [&](int j) { return one[j - turn(j) * n] + period * turn(j); };
  // Flat knot i is knot(i - shift); the natural domain of poles [j0, j1] is [flat j0 + degree, flat j1 + 1].
  int j0 = static_cast<int>(std::floor((a - distinct.front()) / period)) * n;
  while (knot(j0 + degree - shift) > a) --j0;
  int j1 = j0 + 1;
  while (knot(j1 + 1 - shift) < b || j1 - j0 < degree) ++j1;
  for (int j = j0; j <= j1 + degree + 1; ++j) r.knots.push_back(knot(j - shift));
  for (int j = j0; j <= j1; ++j) r.wrap.push_back(j - turn(j) * n);
  return r;
}

}  // namespace trimray::nurbs
