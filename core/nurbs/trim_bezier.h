// De Casteljau's algorithm on Bezier control points of any vector type, homogeneous or not.
#pragma once

#include <span>

namespace trimray::nurbs {

// Highest degree of a trim or edge piece; OpenCascade stops at 25.
inline constexpr int kMaxPieceDegree = 63;

// Splits a piece at t: left and right receive degree + 1 control points each and share the middle one bit
// for bit. Neither may alias ctrl.
template <typename Vec>
void split_bezier(std::span<const Vec> ctrl, double t, Vec* left, Vec* right) {
  const int n = static_cast<int>(ctrl.size()) - 1;
  for (int i = 0; i <= n; ++i) right[i] = ctrl[i];
  for (int level = 0; level < n; ++level) {
    left[level] = right[0];
    for (int i = 0; i < n - level; ++i) right[i] = right[i] * (1.0 - t) + right[i + 1] * t;
  }
  left[n] = right[0];
}

// The homogeneous point at t. degree <= kMaxPieceDegree.
template <typename Vec>
Vec evaluate_bezier(std::span<const Vec> ctrl, double t) {
  const int n = static_cast<int>(ctrl.size()) - 1;
  Vec work[kMaxPieceDegree + 1];
  for (int i = 0; i <= n; ++i) work[i] = ctrl[i];
  for (int level = 0; level < n; ++level)
    for (int i = 0; i < n - level; ++i) work[i] = work[i] * (1.0 - t) + work[i + 1] * t;
  return work[0];
}

}  // namespace trimray::nurbs
