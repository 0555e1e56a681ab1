#include "core/nurbs/trim_roots.h"

#include <algorithm>
#include <cmath>

#include "core/nurbs/trim_bezier.h"

namespace trimray::nurbs {
namespace {

constexpr int kMaxDepth = 52;

// Bernstein coefficients of the product of two polynomials in Bernstein form.
std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
  const int m = static_cast<int>(a.size()) - 1, n = static_cast<int>(b.size()) - 1;
  const auto binomials = [](int k) {
    std::vector<double> row(k + 1, 1.0);
    for (int i = 1; i <= k; ++i) row[i] = row[i - 1] * (k - i + 1) / i;
    return row;
  };
  const std::vector<double> bm = binomials(m), bn = binomials(n), bs = binomials(m + n);
  std::vector<double> c(m + n + 1, 0.0);
  for (int i = 0; i <= m; ++i)
    for (int j = 0; j <= n; ++j) c[i + j] += bm[i] * bn[j] * a[i] * b[j];
  for (int i = 0; i <= m + n; ++i) c[i] /= bs[i];
  return c;
}

std::vector<double> derivative(const std::vector<double>& a) {
  const int n = static_cast<int>(a.size()) - 1;
  std::vector<double> d(std::max(n, 1), 0.0);
  for (int i = 0; i < n; ++i) d[i] = n * (a[i + 1] - a[i]);
  return d;
}

// Numerator of (x / w)': x' w - x w', and the size of what rounding may have put into it.
std::vector<double> numerator(std::span<const dvec3> ctrl_h, int axis, double& noise) {
  const std::size_t count = ctrl_h.size();
  std::vector<double> x(count), w(count);
  // A shift of the coordinate leaves its derivative alone and keeps the products small.
  const double shift = ctrl_h[0][axis] / ctrl_h[0].z;
  double x_max = 0.0, w_max = 0.0, size = std::abs(shift);
  bool polynomial = true;
  for (std::size_t i = 0; i < count; ++i) {
    w[i] = ctrl_h[i].z;
    x[i] = ctrl_h[i][axis] - shift * w[i];
    x_max = std::max(x_max, std::abs(x[i]));
    w_max = std::max(w_max, std::abs(w[i]));
    polynomial = polynomial && w[i] == w[0];
  }
  noise = 1e-15 * static_cast<double>(count) * w_max * (x_max + w_max * size);
  if (polynomial) {
    std::vector<double> d = derivative(x);
    for (double& c : d) c *= w[0];
    return d;
  }
  std::vector<double> a = product(derivative(x), w), b = product(x, derivative(w));
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

int sign_changes(std::span<const double> c) {
  int changes = 0, last = 0;
  for (double value : c) {
    const int sign = (value > 0.0) - (value < 0.0);
    if (sign == 0) continue;
    changes += last != 0 && sign != last;
    last = sign;
  }
  return changes;
}

// Sign changes of the polynomial c on [t0, t1], by halving; a stretch that is nothing but rounding
// counts as flat.
void find(std::vector<double>& c, double t0, double t1, double noise, int depth, std::vector<double>& roots) {
  if (sign_changes(c) == 0) return;
  const double largest = std::abs(
      *std::max_element(c.begin(), c.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
  const double middle = 0.5 * (t0 + t1);
  if (depth == kMaxDepth || !(largest > noise)) {
    if (c.front() * c.back() < 0.0) roots.push_back(middle);
    return;
  }
  std::vector<double> left(c.size()), right(c.size());
  split_bezier<double>(c, 0.5, left.data(), right.data());
  if (left.back() == 0.0 && c.front() * c.back() < 0.0 && sign_changes(c) == 1) {
    roots.push_back(middle);
    return;
  }
  find(left, t0, middle, noise, depth + 1, roots);
  if (left.back() == 0.0) {
    const auto other = [](const std::vector<double>& side, bool from_back) {
      for (std::size_t i = 0; i < side.size(); ++i) {
        const double value = from_back ? side[side.size() - 1 - i] : side[i];
        if (value != 0.0) return value;
      }
      return 0.0;
    };
    if (other(left, true) * other(right, false) < 0.0) roots.push_back(middle);
  }
  find(right, middle, t1, noise, depth + 1, roots);
}

}  // namespace

void append_extrema(std::span<const dvec3> ctrl_h, int axis, std::vector<double>& parameters) {
  if (ctrl_h.size() < 3) return;
  double noise = 0.0;
  std::vector<double> c = numerator(ctrl_h, axis, noise);
  find(c, 0.0, 1.0, noise, 0, parameters);
}

}  // namespace trimray::nurbs
