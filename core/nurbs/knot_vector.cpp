#include "core/nurbs/knot_vector.h"

#include <algorithm>
#include <cmath>

namespace trimray::nurbs {

int find_span(std::span<const double> knots, int degree, double s) {
  const auto first = knots.begin() + degree;
  const auto last = knots.end() - degree - 1;  // the domain's end
  if (s >= *last) return static_cast<int>(std::lower_bound(first, last, *last) - knots.begin()) - 1;
  if (!(s >= *first)) s = *first;
  return static_cast<int>(std::upper_bound(first, last, s) - knots.begin()) - 1;
}

void basis_functions(std::span<const double> knots, int degree, int span, double s, int derivatives,
                     Basis& out) {
  // ndu[j][r]: basis functions of degree j in the upper triangle; knot differences in the lower one.
  double ndu[kMaxDegree + 1][kMaxDegree + 1];
  double left[kMaxDegree + 1], right[kMaxDegree + 1];
  ndu[0][0] = 1.0;
  for (int j = 1; j <= degree; ++j) {
    left[j] = s - knots[span + 1 - j];
    right[j] = knots[span + j] - s;
    double saved = 0.0;
    for (int r = 0; r < j; ++r) {
      ndu[j][r] = knots[span + r + 1] - knots[span + 1 - j + r];
      const double q = ndu[r][j - 1] / ndu[j][r];
      ndu[r][j] = saved + right[r + 1] * q;
      saved = left[j - r] * q;
    }
    ndu[j][j] = saved;
  }
  for (int j = 0; j <= degree; ++j) out.value[0][j] = ndu[j][degree];

  // Derivatives of the functions of degree q from values (or derivatives) of those of degree q - 1.
  const auto differentiate = [&](int q, const double* lower, double* result) {
    for (int r = 0; r <= q; ++r)
      result[r] = q * ((r >= 1 ? lower[r - 1] / ndu[q][r - 1] : 0.0) - (r < q ? lower[r] / ndu[q][r] : 0.0));
  };
  double lower[kMaxDegree + 1], slope[kMaxDegree + 1];
  for (int k = 1; k <= derivatives; ++k) {
    if (degree < k) {
      for (int j = 0; j <= degree; ++j) out.value[k][j] = 0.0;
      continue;
    }
    for (int j = 0; j <= degree - k; ++j) lower[j] = ndu[j][degree - k];
    if (k == 2) {
      differentiate(degree - 1, lower, slope);
      differentiate(degree, slope, out.value[2]);
    } else {
      differentiate(degree, lower, out.value[1]);
    }
  }
}

MappedParameter map_parameter(ParamMap map, double a, double b, double u) {
  if (map == ParamMap::kIdentity) return {u, 1.0, 0.0};
  const double half = 0.5 * (b - a), m = a + half, x = 0.5 * (u - m);
  MappedParameter r;
  if (map == ParamMap::kCircular) {
    const double k = half / std::tan(0.5 * half), c = std::cos(x);
    r.s = m + k * std::tan(x);
    r.ds = 0.5 * k / (c * c);
    r.dds = 0.5 * k * std::tan(x) / (c * c);
  } else {
    const double k = half / std::tanh(0.5 * half), c = std::cosh(x);
    r.s = m + k * std::tanh(x);
    r.ds = 0.5 * k / (c * c);
    r.dds = -0.5 * k * std::tanh(x) / (c * c);
  }
  if (u == a) r.s = a;
  if (u == b) r.s = b;
  return r;
}

double unmap_parameter(ParamMap map, double a, double b, double s) {
  if (map == ParamMap::kIdentity || s == a || s == b) return s;
  const double half = 0.5 * (b - a), m = a + half, y = (s - m) / half;
  if (map == ParamMap::kCircular) return m + 2.0 * std::atan(y * std::tan(0.5 * half));
  return m + 2.0 * std::atanh(std::clamp(y * std::tanh(0.5 * half), -1.0 + 1e-15, 1.0 - 1e-15));
}

double wrap_near(double u, double middle, double period) {
  return period > 0.0 ? u - period * std::round((u - middle) / period) : u;
}

std::vector<double> distinct_knots(std::span<const double> knots, int degree) {
  std::vector<double> out;
  for (std::size_t i = degree; i + degree < knots.size(); ++i)
    if (out.empty() || knots[i] > out.back()) out.push_back(knots[i]);
  return out;
}

}  // namespace trimray::nurbs
