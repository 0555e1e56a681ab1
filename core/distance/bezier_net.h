// Rational Bezier nets, homogeneous (w x, w y, w z, w): derivatives at a point, and what is certain about all
// points. A curve is a net with dv = 0.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/nurbs/trim_bezier.h"

namespace trimray::distance {

inline constexpr int kMaxNetDegree = nurbs::kMaxPieceDegree;

struct Jet {
  dvec3 p{0.0}, u{0.0}, v{0.0}, uu{0.0}, uv{0.0}, vv{0.0};
};

// net[i * (dv + 1) + j]; u, v in [0, 1] or close to it.
Jet jet_at(const dvec4* net, int du, int dv, double u, double v);
dvec3 point_at(const dvec4* net, int du, int dv, double u, double v);

// Holds for all points of the net over [0, 1]^2.
struct NetBound {
  Jet middle;                           // at (1/2, 1/2)
  double radius = 0.0;                  // no point is farther from middle.p
  double uu = 0.0, uv = 0.0, vv = 0.0;  // |S_uu|, |S_uv|, |S_vv| are at most this
  double turn_u = 0.0, turn_v = 0.0;    // |S_u - middle.u| and |S_v - middle.v| are at most this
  // What is left of S beyond its linear part T at the middle, as a homogeneous net (w (S - T), w) of degrees
  // rest_u, rest_v: small where S is nearly flat, so that the derivatives of the weights hardly matter.
  std::vector<dvec4> rest;
  int rest_u = 0, rest_v = 0;
  double rest_radius = 0.0;  // |S - T| at most
  double w_lower = 1.0, w_upper = 1.0, wu = 0.0, wv = 0.0, wuu = 0.0, wuv = 0.0, wvv = 0.0;  // |.| at most
};

// False where a weight is not positive or a number not finite.
bool bound_net(const dvec4* net, int du, int dv, NetBound& out);

// The squared distance of a curve from q is strictly convex if no point of it is farther from q than this; 0
// where nothing can be said.
double convex_radius(const NetBound& bound);

struct Span {
  double lower = 0.0, upper = 0.0;
};

// What is known of a surface's derivatives in an orthonormal frame, for a quick proof of convexity.
struct HessianBound {
  double uu = 0.0, vv = 0.0, uv = 0.0;   // |S_u|^2 and |S_v|^2 at least, |S_u . S_v| at most
  Span normal_uu, normal_uv, normal_vv;  // of the second derivatives along axis[2]
  double side_uu[2] = {}, side_uv[2] = {}, side_vv[2] = {};  // at most, along axis[0] and axis[1]
};
HessianBound bound_hessian(const NetBound& bound, const dvec3 (&axis)[3]);
// Is half the squared distance from q strictly convex, if S - q lies in e along the axes?
bool convex_for(const HessianBound& h, const Span (&e)[3]);

// What half the squared distance from the origin is like, certainly, over the whole domain.
struct Shape {
  bool convex = false;                      // strictly: at most one minimum, Newton's method finds it
  bool regular = false;                     // the Hessian is nowhere singular: at most one critical point
  bool convex_u = false, convex_v = false;  // strictly, along u and along v alone
  int slope_u = 0, slope_v = 0;             // the sign of the derivative, 0 where it may change
};
Shape shape_of(const NetBound& bound, bool curve);

// What the Bernstein coefficients of |P|^2 - distance^2 w^2 say; they are exact for circles and spheres about
// the origin. bend_u, bend_v: their largest second differences; halving the net where it is larger wins more.
struct SquareForm {
  bool keeps_away = false;  // no point of the net is nearer to the origin than `distance`; may fail to see it
  double bend_u = 0.0, bend_v = 0.0;
};
SquareForm square_form(const dvec4* net, int du, int dv, double distance, std::vector<double>& coefficients);

// A lower bound of the net's distance from the origin: from the half-space behind its nearest control point,
// seen towards `towards`.
double plane_bound(const dvec4* net, int count, const dvec3& towards);

}  // namespace trimray::distance
