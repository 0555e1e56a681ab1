#include "core/mass/moments.h"

#include <algorithm>

namespace trimray::mass {
namespace {

dmat3 outer(const dvec3& a, const dvec3& b) { return glm::outerProduct(a, b); }

double largest(const dmat3& m) {
  double r = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r = std::max(r, std::abs(m[i][j]));
  return r;
}

// How long a unit vector can become.
double stretch(const dmat3& m) {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) sum += glm::dot(m[i], m[i]);
  return std::sqrt(sum);
}

}  // namespace

Moments moments_of(const Integrals& x, const Integrals& e, dvec3 origin) {
  Moments m;
  m.origin = origin;
  m.volume = x[kVolume], m.volume_error = e[kVolume];
  m.first = {x[2], x[3], x[4]};
  m.first_error = std::max({e[2], e[3], e[4]});
  m.second = {x[5], x[6], x[7], x[6], x[8], x[9], x[7], x[9], x[10]};
  m.second_error = *std::max_element(e.begin() + kSecond, e.end());
  return m;
}

Moments moved(const Moments& m, dvec3 origin) {
  const dvec3 shift = m.origin - origin;
  const double far = glm::length(shift);
  Moments r = m;
  r.origin = origin;
  r.first = m.first + m.volume * shift;
  const dmat3 cross = outer(m.first, shift);
  r.second = m.second + cross + glm::transpose(cross) + m.volume * outer(shift, shift);
  r.first_error = m.first_error + far * m.volume_error;
  r.second_error = m.second_error + 2.0 * far * m.first_error + far * far * m.volume_error;
  return r;
}

Moments placed(const Moments& m, const Transform& placement) {
  const dmat3& l = placement.linear;
  const double scale = std::abs(glm::determinant(l)), longest = stretch(l);
  Moments r;
  r.origin = placement.point(m.origin);
  r.volume = scale * m.volume;
  r.first = scale * (l * m.first);
  r.second = scale * (l * m.second * glm::transpose(l));
  r.volume_error = scale * m.volume_error;
  r.first_error = scale * longest * m.first_error;
  r.second_error = scale * longest * longest * m.second_error;
  return r;
}

Moments operator+(const Moments& a, const Moments& b) {
  const Moments c = moved(b, a.origin);
  Moments r = a;
  r.volume += c.volume, r.first += c.first, r.second += c.second;
  r.volume_error += c.volume_error, r.first_error += c.first_error, r.second_error += c.second_error;
  return r;
}

Body body_of(const Moments& m) {
  Body r;
  if (!(std::abs(m.volume) > m.volume_error)) {
    r.centroid_error = r.inertia_error = kInf;
    return r;
  }
  const dvec3 arm = m.first / m.volume;
  const double far = glm::length(arm);
  const dmat3 central = m.second - m.volume * outer(arm, arm);
  r.centroid = m.origin + arm;
  r.inertia = dmat3(central[0][0] + central[1][1] + central[2][2]) - central;
  const double surely = std::abs(m.volume) - m.volume_error;
  r.centroid_error = (m.first_error + far * m.volume_error) / surely;
  const double off = m.second_error + 2.0 * far * m.first_error + far * far * m.volume_error;
  r.inertia_error = 3.0 * off + 1e-15 * largest(m.second);
  return r;
}

}  // namespace trimray::mass
