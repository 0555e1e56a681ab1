#include "core/tess/triangle_bound.h"

#include <array>
#include <cmath>

namespace trimray::tess {

using nurbs::Surface;
using nurbs::SurfaceKind;

namespace {

// The largest value of l0 l1 a + l1 l2 b + l2 l0 c over barycentric l, for a, b, c >= 0: were they squared
// lengths of a triangle's sides, the squared radius of its smallest enclosing circle.
double enclosing(double a, double b, double c) {
  const double most = std::max(a, std::max(b, c));
  if (2.0 * most >= a + b + c) return 0.25 * most;
  return a * b * c / (2.0 * (a * b + b * c + c * a) - (a * a + b * b + c * c));
}

double square(double x) { return x * x; }

// Cylinders and cones: at its own height no point of the triangle is nearer to the axis than the middle of
// the arc's chord.
TriangleBound round_bound(const Surface& f, const dvec2 p[3]) {
  const double turn[3] = {std::abs(p[1].x - p[0].x), std::abs(p[2].x - p[1].x), std::abs(p[0].x - p[2].x)};
  TriangleBound r;
  const double most = std::max(turn[0], std::max(turn[1], turn[2]));
  double radius = std::abs(f.r1), tilt = 1.0;
  bool through_apex = false;
  if (f.kind == SurfaceKind::kCone) {
    const double slope = std::sin(f.semi_angle);
    double least = kInf, largest = -kInf;
    for (int k = 0; k < 3; ++k) {
      const double at = f.r1 + p[k].y * slope;
      least = std::min(least, at), largest = std::max(largest, at);
    }
    through_apex = std::min(-least, largest) > 1e-9 * std::max(-least, largest);
    radius = std::max(-least, largest), tilt = std::abs(std::cos(f.semi_angle));
  }
  const auto deviation = [&](double angle) { return 2.0 * radius * square(std::sin(0.25 * angle)) * tilt; };
  for (int k = 0; k < 3; ++k) r.side[k] = deviation(turn[k]);
  if (most < 3.0 && !through_apex) r.deviation = deviation(most);
  return r;
}

TriangleBound sphere_bound(const Surface& f, const dvec3 s[3]) {
  double l2[3];
  for (int k = 0; k < 3; ++k) {
    const dvec3 d = s[(k + 1) % 3] - s[k];
    l2[k] = glm::dot(d, d);
  }
  TriangleBound r;
  for (int k = 0; k < 3; ++k) r.side[k] = 0.125 * l2[k] / std::abs(f.r1);
  const double radius2 = f.r1 * f.r1, depth = enclosing(l2[0], l2[1], l2[2]);
  if (depth < 0.75 * radius2) r.deviation = depth / (std::abs(f.r1) + std::sqrt(radius2 - depth));
  return r;
}

// Bounds on a component of the interpolation's error.
class Interpolation {
 public:
  Interpolation(const CurvatureRange& range, const dvec2 p[3]) : range_(range) {
    Box2 box;
    for (int k = 0; k < 3; ++k) box.add(p[k]), side_[k] = p[(k + 1) % 3] - p[k];
    extent_ = box.extent();
    balance_ = extent_.x > 0.0 && extent_.y > 0.0 ? extent_.y / extent_.x : 1.0;
  }

  struct Error {
    double most;     // over the triangle
    double spread;   // grows by spread * (x + x^2) when it is enlarged by x in each barycentric coordinate
    double side[3];  // |second derivative| along the sides
  };

  Error along(const dvec3& e) const {
    const DerivativeRange& r = range_.second;
    const dvec3 sum = glm::abs(e);
    const double cu = glm::dot(e, r.uu.center()), cm = glm::dot(e, r.uv.center()),
                 cv = glm::dot(e, r.vv.center());
    const double hu = glm::dot(sum, 0.5 * r.uu.extent()), hm = glm::dot(sum, 0.5 * r.uv.extent()),
                 hv = glm::dot(sum, 0.5 * r.vv.extent());
    return error(cu, cm, cv, hu + hm * balance_, hv + hm / balance_,
                 kink(tess::along(e, range_.kink_u).magnitude(), tess::along(e, range_.kink_v).magnitude()));
  }

  // Of the whole vector.
  Error whole() const {
    const DerivativeRange& r = range_.second;
    const double m = largest(r.uv);
    return error(0.0, 0.0, 0.0, largest(r.uu) + m * balance_, largest(r.vv) + m / balance_,
                 kink(largest(range_.kink_u), largest(range_.kink_v)));
  }

 private:
  double kink(double ku, double kv) const {
    double r = 0.0;
    if (range_.kinks_u > 0) r += 0.25 * range_.kinks_u * ku * extent_.x;
    if (range_.kinks_v > 0) r += 0.25 * range_.kinks_v * kv * extent_.y;
    return r;
  }

  Error error(double cu, double cm, double cv, double hu, double hv, double kinks) const {
    double above[3], below[3];
    Error r{};
    for (int k = 0; k < 3; ++k) {
      const dvec2 d = side_[k];
      const double c = cu * d.x * d.x + 2.0 * cm * d.x * d.y + cv * d.y * d.y,
                   h = hu * d.x * d.x + hv * d.y * d.y;
      above[k] = std::max(0.0, c + h), below[k] = std::max(0.0, h - c);
      r.side[k] = std::max(above[k], below[k]);
      r.spread += 0.5 * r.side[k];
    }
    r.most =
        0.5 * std::max(enclosing(above[0], above[1], above[2]), enclosing(below[0], below[1], below[2])) +
        kinks;
    r.spread += 4.0 * kinks;
    return r;
  }

  const CurvatureRange& range_;
  dvec2 side_[3], extent_;
  double balance_ = 1.0;
};

TriangleBound general_bound(const CurvatureTree& tree, const dvec2 p[3], const dvec3 s[3]) {
  Box2 box;
  for (int k = 0; k < 3; ++k) box.add(p[k]);
  const dvec3 cross = glm::cross(s[1] - s[0], s[2] - s[0]);
  const double area2 = glm::length(cross);
  TriangleBound r;
  // How far the triangle is enlarged so that the shifted surface still covers it.
  double reach = 0.025;
  for (int attempt = 0; attempt < 3; ++attempt) {
    Box2 wide = box;
    wide.lower -= 4.0 * reach * box.extent(), wide.upper += 4.0 * reach * box.extent();
    const CurvatureRange range = tree.over(wide);
    const Interpolation interpolation(range, p);
    const Interpolation::Error whole = interpolation.whole();
    if (attempt == 0) {
      r.deviation = whole.most;
      for (int k = 0; k < 3; ++k) r.side[k] = 0.125 * whole.side[k];
      if (!(area2 > 0.0)) return r;
    }
    const dvec3 n = cross / area2;
    const Interpolation::Error height = interpolation.along(n);
    if (attempt == 0)
      for (int k = 0; k < 3; ++k) r.side[k] = 0.125 * height.side[k];
    double shift = 0.0, growth = 0.0;
    for (int k = 0; k < 3; ++k) {
      const dvec3 side = s[(k + 1) % 3] - s[k];
      const double length = glm::length(side);
      const Interpolation::Error across = interpolation.along(glm::cross(n, side) / length);
      shift = std::max(shift, across.most * length / area2),
      growth = std::max(growth, across.spread * length / area2);
    }
    // Enlarged by x, the shift is at most shift + growth (x + x^2); it must not exceed x.
    const double x = shift < 1.0 ? 1.02 * shift / std::max(1.0 - 1.5 * growth, 0.05) : kInf;
    if (!(x < 0.4)) return r;
    if (x <= reach && shift + growth * (x + x * x) <= x) {
      r.deviation = std::min(r.deviation, height.most + height.spread * (x + x * x));
      return r;
    }
    reach = std::max(1.2 * x, 1.5 * reach);
  }
  return r;
}

}  // namespace

bool needs_tree(SurfaceKind kind) {
  return kind != SurfaceKind::kPlane && kind != SurfaceKind::kCylinder && kind != SurfaceKind::kCone &&
         kind != SurfaceKind::kSphere;
}

TriangleBound bound_triangle(const Chart& chart, const CurvatureTree* tree, const dvec2 p[3],
                             const dvec3 s[3]) {
  const Surface& f = chart.surface();
  switch (f.kind) {
    case SurfaceKind::kPlane:
      return {0.0, {0.0, 0.0, 0.0}};
    case SurfaceKind::kCylinder:
    case SurfaceKind::kCone:
      return round_bound(f, p);
    case SurfaceKind::kSphere:
      return sphere_bound(f, s);
    default:
      return general_bound(*tree, p, s);
  }
}

}  // namespace trimray::tess
