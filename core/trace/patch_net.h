// Bernstein control nets: restriction to a part of the domain.
#pragma once

#include <cmath>
#include <cstddef>

namespace trimray::trace {

// The n + 1 control points c[i * stride] over [0, 1] become those over [a, b], a < b, which may reach beyond
// [0, 1] (the polynomial continues). Two de Casteljau passes, the better conditioned cut first.
template <typename P>
void restrict_line(P* c, int n, std::ptrdiff_t stride, double a, double b) {
  const auto keep_left = [&](double t) {
    for (int r = 1; r <= n; ++r)
      for (int i = n; i >= r; --i) c[i * stride] = (1.0 - t) * c[(i - 1) * stride] + t * c[i * stride];
  };
  const auto keep_right = [&](double t) {
    for (int r = 1; r <= n; ++r)
      for (int i = 0; i + r <= n; ++i) c[i * stride] = (1.0 - t) * c[i * stride] + t * c[(i + 1) * stride];
  };
  if (std::fabs(b) >= std::fabs(1.0 - a)) {
    if (b != 1.0) keep_left(b);
    if (a != 0.0) keep_right(a / b);
  } else {
    if (a != 0.0) keep_right(a);
    if (b != 1.0) keep_left((b - a) / (1.0 - a));
  }
}

// net[i * (dv + 1) + j] over [0, 1]^2 becomes the net over [u0, u1] x [v0, v1].
template <typename P>
void restrict_net(P* net, int du, int dv, double u0, double u1, double v0, double v1) {
  for (int i = 0; i <= du; ++i) restrict_line(net + i * (dv + 1), dv, 1, v0, v1);
  for (int j = 0; j <= dv; ++j) restrict_line(net + j, du, dv + 1, u0, u1);
}

}  // namespace trimray::trace
