// Gauss-Legendre quadrature on [0, 1].
#pragma once

#include <array>
#include <span>

namespace trimray::mass {

// The numbers of nodes that are tried in turn; a rule of n nodes is exact for polynomials of degree 2 n - 1.
inline constexpr std::array<int, 5> kRuleSizes{3, 5, 8, 12, 18};
inline constexpr int kRules = static_cast<int>(kRuleSizes.size());

// node: ascending, in (0, 1). The weights sum to 1.
struct GaussRule {
  std::span<const double> node, weight;
};
GaussRule gauss_rule(int which);  // of kRuleSizes[which]

}  // namespace trimray::mass
