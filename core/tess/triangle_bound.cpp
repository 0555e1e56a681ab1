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

// The same over the triangle enlarged by x in each barycentric coordinate. Where the three numbers cannot be
// squared lengths, one of them is raised until they can; raised is the amount. The value falls off with the
// squared distance from the circumscribed circle's centre, which lies beyond the longest side when the
// triangle is obtuse.
double enclosing_enlarged(double a, double b, double c, double x, double& raised) {
  if (a > c) std::swap(a, c);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  const double least = std::sqrt(c) - std::sqrt(a);
  raised = std::max(0.0, least * least - b);
  b += raised;
  return enclosing(a, b, c) + 0.5 * x * std::max(0.0, c - a - b);
}

dvec3 any_normal(const dvec3& v) {
  const dvec3 n = glm::cross(v, std::abs(v.x) < std::abs(v.y) ? dvec3(1, 0, 0) : dvec3(0, 1, 0));
  const double length = glm::length(n);
  return length > 0.0 ? n / length : dvec3(0, 0, 1);
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

  // A component of the error. The surface's height over the plane of interpolation is minus half the sum over
  // the sides of l_i l_j q_ij, where q is somewhere between low and high.
  struct Error {
    double low[3], high[3];  // second derivative along the sides
    double kinks;

    double side(int k) const { return std::max(-low[k], high[k]); }
    // The largest error over the triangle enlarged by x in each barycentric coordinate.
    double most(double x) const {
      double above[3], below[3], width_above = 0.0, width_below = 0.0;
      for (int k = 0; k < 3; ++k) {
        above[k] = std::max(0.0, high[k]), below[k] = std::max(0.0, -low[k]);
        width_above += above[k] - low[k], width_below += below[k] + high[k];
      }
      // Outside of the triangle products of coordinates are negative, and then the other end of q's range
      // counts.
      const double grown = x * (1.0 + 2.0 * x);
      const auto one = [&](const double(&q)[3], double width) {
        if (x == 0.0) return enclosing(q[0], q[1], q[2]);
        double raised;
        const double inside = enclosing_enlarged(q[0], q[1], q[2], x, raised);
        return inside + grown * (width + raised);
      };
      return 0.5 * std::max(one(above, width_above), one(below, width_below)) + kinks * (1.0 + 4.0 * x);
    }
  };

  Error along(const dvec3& e) const {
    const DerivativeRange& r = range_.second;
    const dvec3 sum = glm::abs(e);
    const double cu = glm::dot(e, r.uu.center()), cm = glm::dot(e, r.uv.center()),
                 cv = glm::dot(e, r.vv.center());
    const double hu = glm::dot(sum, 0.5 * r.uu.extent()), hm = glm::dot(sum, 0.5 * r.uv.extent()),
                 hv = glm::dot(sum, 0.5 * r.vv.extent());
    return error(cu, cm, cv, hu + hm * balance_, hv + hm / balance_,
                 range_.kinks > 0 ? range_.kinks * tess::along(e, range_.kink).magnitude() : 0.0);
  }

  // Of the whole vector.
  Error whole() const {
    const DerivativeRange& r = range_.second;
    const double m = largest(r.uv);
    return error(0.0, 0.0, 0.0, largest(r.uu) + m * balance_, largest(r.vv) + m / balance_,
                 range_.kinks > 0 ? range_.kinks * largest(range_.kink) : 0.0);
  }

 private:
  Error error(double cu, double cm, double cv, double hu, double hv, double kinks) const {
    Error r{};
    for (int k = 0; k < 3; ++k) {
      const dvec2 d = side_[k];
      const double c = cu * d.x * d.x + 2.0 * cm * d.x * d.y + cv * d.y * d.y,
                   h = hu * d.x * d.x + hv * d.y * d.y;
      r.low[k] = c - h, r.high[k] = c + h;
    }
    r.kinks = kinks;
    return r;
  }

  const CurvatureRange& range_;
  dvec2 side_[3], extent_;
  double balance_ = 1.0;
};

// A flat triangle is no farther from the surface than its longest side, by more than its height. A point of
// the side has a point of the surface right across it (in the plane normal to the side), as far as the
// surface's curve over it runs evenly enough.
double sliver_bound(const Interpolation& interpolation, const dvec3 s[3], const dvec3& n, double area2,
                    double x) {
  int longest = 0;
  double length = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double l = glm::distance(s[(k + 1) % 3], s[k]);
    if (l > length) length = l, longest = k;
  }
  if (!(length > 0.0)) return 0.0;
  const dvec3 side = (s[(longest + 1) % 3] - s[longest]) / length;
  const Interpolation::Error run = interpolation.along(side), up = interpolation.along(n),
                             across = interpolation.along(glm::cross(n, side));
  // Up to x beyond its ends (x < 0.1) a quadratic is no larger than in its middle.
  if (!(0.125 * run.side(longest) + run.kinks <= std::min(x, 0.1) * length)) return kInf;
  return area2 / length +
         std::hypot(0.125 * up.side(longest) + up.kinks, 0.125 * across.side(longest) + across.kinks);
}

// Infinite ranges say nothing, and sums of them are no numbers.
bool bounded(const CurvatureRange& r) {
  return largest(r.second.uu) < kInf && largest(r.second.uv) < kInf && largest(r.second.vv) < kInf &&
         (r.kinks == 0 || largest(r.kink) < kInf);
}

TriangleBound general_bound(const CurvatureTree& tree, const dvec2 p[3], const dvec3 s[3], double enough,
                            bool sharp) {
  Box2 box;
  for (int k = 0; k < 3; ++k) box.add(p[k]);
  const dvec3 cross = glm::cross(s[1] - s[0], s[2] - s[0]);
  const double area2 = glm::length(cross);
  const dvec3 n = area2 > 0.0 ? cross / area2 : any_normal(s[1] - s[0]);
  TriangleBound r;
  // How far the triangle is enlarged so that the surface, shifted sideways, still covers it.
  double x = 0.05;
  for (int attempt = 0; attempt < 3 && x < 0.4; ++attempt) {
    Box2 wide = box;
    wide.lower -= 2.0 * x * box.extent(), wide.upper += 2.0 * x * box.extent();
    const CurvatureRange range = tree.over(wide, sharp);
    if (!bounded(range)) return r;
    const Interpolation interpolation(range, p);
    const Interpolation::Error height = interpolation.along(n);
    if (attempt == 0) {
      r.deviation = interpolation.whole().most(0.0);
      r.kinks = height.kinks;
      for (int k = 0; k < 3; ++k) r.side[k] = 0.125 * height.side(k);
      r.deviation = std::min(r.deviation, sliver_bound(interpolation, s, n, area2, x));
      if (!(area2 > 0.0) || height.most(0.0) > enough) return r;
    }
    // The shift across a side, in units of the triangle's height over it.
    double shift = 0.0;
    for (int k = 0; k < 3; ++k) {
      const dvec3 side = s[(k + 1) % 3] - s[k];
      const double length = glm::length(side);
      shift = std::max(shift, interpolation.along(glm::cross(n, side) / length).most(x) * length / area2);
    }
    if (shift <= x) {
      r.deviation = std::min(r.deviation, height.most(shift));
      return r;
    }
    x = std::max(1.3 * shift, 2.0 * x);
  }
  return r;
}

// Offset surfaces: the largest distance found at some points, and half as much again.
TriangleBound sampled_bound(const Chart& chart, const dvec2 p[3], const dvec3 s[3]) {
  constexpr double kSafety = 1.5;
  const auto distance = [&](const dvec3& l) {
    const dvec3 x = l.x * s[0] + l.y * s[1] + l.z * s[2];
    const dvec2 guess = l.x * p[0] + l.y * p[1] + l.z * p[2];
    return kSafety * glm::distance(x, chart.point(chart.project(x, guess)));
  };
  TriangleBound r;
  r.side[0] = distance({0.5, 0.5, 0.0}), r.side[1] = distance({0.0, 0.5, 0.5}),
  r.side[2] = distance({0.5, 0.0, 0.5});
  r.deviation = std::max(std::max(r.side[0], r.side[1]), r.side[2]);
  for (const dvec3& l :
       {dvec3(1, 1, 1) / 3.0, dvec3(4, 1, 1) / 6.0, dvec3(1, 4, 1) / 6.0, dvec3(1, 1, 4) / 6.0})
    r.deviation = std::max(r.deviation, distance(l));
  return r;
}

}  // namespace

bool needs_tree(SurfaceKind kind) {
  return kind != SurfaceKind::kPlane && kind != SurfaceKind::kCylinder && kind != SurfaceKind::kCone &&
         kind != SurfaceKind::kSphere && kind != SurfaceKind::kOffset;
}

TriangleBound bound_triangle(const Chart& chart, const CurvatureTree* tree, const dvec2 p[3],
                             const dvec3 s[3], double enough) {
  const Surface& f = chart.surface();
  switch (f.kind) {
    case SurfaceKind::kPlane:
      return {0.0, {0.0, 0.0, 0.0}, 0.0};
    case SurfaceKind::kCylinder:
    case SurfaceKind::kCone:
      return round_bound(f, p);
    case SurfaceKind::kSphere:
      return sphere_bound(f, s);
    case SurfaceKind::kOffset:
      return sampled_bound(chart, p, s);
    default: {
      const TriangleBound quick = general_bound(*tree, p, s, enough, false);
      return quick.deviation <= enough && enough < kInf ? quick : general_bound(*tree, p, s, enough, true);
    }
  }
}

}  // namespace trimray::tess
