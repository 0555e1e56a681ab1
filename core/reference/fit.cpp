#include "core/reference/fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trimray::reference {
namespace {

constexpr int kCount = kFitDegree + 1;
using Matrix = Real[kCount][kCount];

Real node(int k) { return (1 - std::cos(std::numbers::pi_v<Real> * (k + Real(0.5)) / kCount)) / 2; }

// From values at the nodes to Bernstein coefficients: the inverse of B[k][j] = B_j(node k), by Gauss and
// Jordan.
struct Inverse {
  Matrix m;
  Inverse() {
    Matrix a;
    for (int k = 0; k < kCount; ++k) {
      Real binomial = 1;
      for (int j = 0; j < kCount; ++j) {
        a[k][j] = binomial * std::pow(node(k), Real(j)) * std::pow(1 - node(k), Real(kFitDegree - j));
        m[k][j] = k == j;
        binomial = binomial * (kFitDegree - j) / (j + 1);
      }
    }
    for (int c = 0; c < kCount; ++c) {
      int pivot = c;
      for (int r = c; r < kCount; ++r)
        if (std::abs(a[r][c]) > std::abs(a[pivot][c])) pivot = r;
      for (int j = 0; j < kCount; ++j) std::swap(a[c][j], a[pivot][j]), std::swap(m[c][j], m[pivot][j]);
      const Real scale = 1 / a[c][c];
      for (int j = 0; j < kCount; ++j) a[c][j] *= scale, m[c][j] *= scale;
      for (int r = 0; r < kCount; ++r) {
        if (r == c) continue;
        const Real f = a[r][c];
        for (int j = 0; j < kCount; ++j) a[r][j] -= f * a[c][j], m[r][j] -= f * m[c][j];
      }
    }
  }
};

}  // namespace

double fit(const std::function<Vec3(Real, Real)>& f, Patch& out) {
  static const Inverse inverse;
  Vec3 values[kCount][kCount], half[kCount][kCount];
  for (int i = 0; i < kCount; ++i)
    for (int j = 0; j < kCount; ++j) values[i][j] = f(node(i), node(j)), half[i][j] = Vec3(0);
  for (int i = 0; i < kCount; ++i)
    for (int j = 0; j < kCount; ++j)
      for (int k = 0; k < kCount; ++k) half[i][j] += inverse.m[i][k] * values[k][j];
  out.p = out.q = kFitDegree;
  out.ctrl.assign(kCount * kCount, Vec4(0, 0, 0, 1));
  for (int i = 0; i < kCount; ++i)
    for (int j = 0; j < kCount; ++j) {
      Vec3 sum(0);
      for (int k = 0; k < kCount; ++k) sum += inverse.m[j][k] * half[i][k];
      out.ctrl[i * kCount + j] = Vec4(sum, 1);
    }

  Real worst = 0;
  constexpr Real kBetween[] = {0, 0.13L, 0.37L, 0.5L, 0.71L, 0.92L, 1};
  for (Real x : kBetween)
    for (Real y : kBetween) worst = std::max(worst, glm::length(Vec3(evaluate(out, x, y).h) - f(x, y)));
  return double(worst);
}

}  // namespace trimray::reference
