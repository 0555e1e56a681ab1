// The integrals over a face that make area and moments, and sums of them.
#pragma once

#include <array>
#include <cmath>

#include "core/base/types.h"

namespace trimray::mass {

// Of 1 over the surface, and by the divergence theorem over the body on its inner side, r from an origin:
//   kArea    |N|             N = Su x Sv, outward
//   kVolume  r . N / 3       div r = 3
//   kFirst   r_i r . N / 4   div (r_i r) = 4 r_i
//   kSecond  r_i r_j r . N / 5: xx, xy, xz, yy, yz, zz
inline constexpr int kArea = 0, kVolume = 1, kFirst = 2, kSecond = 5, kIntegrals = 11;
using Integrals = std::array<double, kIntegrals>;

inline void add_integrand(const dvec3& r, const dvec3& normal, double weight, Integrals& to) {
  const double flux = weight * glm::dot(r, normal);
  to[kArea] += std::abs(weight) * glm::length(normal);
  to[kVolume] += flux * (1.0 / 3.0);
  const double first = 0.25 * flux, second = 0.2 * flux;
  to[2] += first * r.x, to[3] += first * r.y, to[4] += first * r.z;
  const dvec3 s = second * r;
  to[5] += s.x * r.x, to[6] += s.x * r.y, to[7] += s.x * r.z;
  to[8] += s.y * r.y, to[9] += s.y * r.z, to[10] += s.z * r.z;
}

// How large each integral can be over an area of 1 within `reach` of the origin.
inline Integrals largest_integrals(double reach) {
  Integrals k{};
  k[kArea] = 1.0, k[kVolume] = reach / 3.0;
  for (int i = kFirst; i < kSecond; ++i) k[i] = 0.25 * reach * reach;
  for (int i = kSecond; i < kIntegrals; ++i) k[i] = 0.2 * reach * reach * reach;
  return k;
}

// A sum whose rounding is that of its result (Neumaier 1974).
class Sum {
 public:
  void add(double x) {
    const double next = sum_ + x;
    lost_ += std::abs(sum_) >= std::abs(x) ? (sum_ - next) + x : (x - next) + sum_;
    sum_ = next;
  }
  double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0.0, lost_ = 0.0;
};

// Of Integrals, one by one.
class IntegralSums {
 public:
  void add(const Integrals& x, double factor = 1.0) {
    for (int i = 0; i < kIntegrals; ++i) sums_[i].add(factor * x[i]);
  }
  Integrals value() const {
    Integrals r;
    for (int i = 0; i < kIntegrals; ++i) r[i] = sums_[i].value();
    return r;
  }

 private:
  std::array<Sum, kIntegrals> sums_;
};

}  // namespace trimray::mass
