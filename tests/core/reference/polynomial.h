// Univariate polynomials along a ray, and all their real roots by bracketing between the roots of the
// derivative: the independent truth of the closed-form tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace trimray::reference_test {

using Polynomial = std::vector<long double>;  // coefficients, lowest first

inline Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Polynomial c(a.size() + b.size() - 1, 0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) c[i + j] += a[i] * b[j];
  return c;
}

inline Polynomial add(const Polynomial& a, const Polynomial& b, long double factor = 1) {
  Polynomial c(std::max(a.size(), b.size()), 0);
  for (std::size_t i = 0; i < a.size(); ++i) c[i] += a[i];
  for (std::size_t i = 0; i < b.size(); ++i) c[i] += factor * b[i];
  return c;
}

inline long double value(const Polynomial& p, long double t) {
  long double v = 0;
  for (std::size_t i = p.size(); i-- > 0;) v = v * t + p[i];
  return v;
}

// Roots in [a, b] where the sign changes; double roots are not listed.
inline std::vector<long double> roots(const Polynomial& p, long double a, long double b) {
  if (p.size() < 2) return {};
  Polynomial d;
  for (std::size_t i = 1; i < p.size(); ++i) d.push_back(i * p[i]);
  std::vector<long double> cuts = {a};
  for (long double t : roots(d, a, b)) cuts.push_back(t);
  cuts.push_back(b);
  std::vector<long double> out;
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    long double lo = cuts[k], hi = cuts[k + 1];
    const bool rising = value(p, hi) > 0;
    if ((value(p, lo) > 0) == rising) continue;
    for (int i = 0; i < 200; ++i) {
      const long double m = (lo + hi) / 2;
      ((value(p, m) > 0) == rising ? hi : lo) = m;
    }
    out.push_back((lo + hi) / 2);
  }
  return out;
}

}  // namespace trimray::reference_test
