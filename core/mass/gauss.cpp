#include "core/mass/gauss.h"

#include <cmath>
#include <numbers>

namespace trimray::mass {
namespace {

constexpr int kMostNodes = kRuleSizes.back();

struct Tables {
  double node[kRules][kMostNodes], weight[kRules][kMostNodes];

  // Newton's method on the Legendre polynomial, from the usual cosines (Numerical Recipes, "gauleg").
  Tables() {
    for (int r = 0; r < kRules; ++r) {
      const int n = kRuleSizes[r];
      for (int i = 0; i < n; ++i) {
        long double x = std::cos(std::numbers::pi_v<long double> * (n - i - 0.25L) / (n + 0.5L)), slope = 1;
        for (int step = 0; step < 100; ++step) {
          long double p = 1, before = 0;
          for (int k = 0; k < n; ++k) {
            const long double next = ((2 * k + 1) * x * p - k * before) / (k + 1);
            before = p, p = next;
          }
          slope = n * (x * p - before) / (x * x - 1);
          const long double move = p / slope;
          x -= move;
          if (std::abs(move) < 1e-18L) break;
        }
        node[r][i] = static_cast<double>(0.5L * (1 + x));
        weight[r][i] = static_cast<double>(1 / ((1 - x * x) * slope * slope));
      }
    }
  }
};

}  // namespace

GaussRule gauss_rule(int which) {
  static const Tables tables;
  const auto n = static_cast<std::size_t>(kRuleSizes[which]);
  return {{tables.node[which], n}, {tables.weight[which], n}};
}

}  // namespace trimray::mass
