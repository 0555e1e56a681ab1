// B-rep curves as exact rational splines and as Bezier pieces.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "core/brep/topology.h"
#include "core/nurbs/spline.h"

namespace trimray::nurbs {

// Coordinates, radii and parameters beyond this are refused as damaged (mm).
inline constexpr double kMaxCoordinate = 1e12;
// Periods that a range may lie away from a periodic spline's first knot; counts of knots stay far below 2^31.
inline constexpr double kMaxTurnsAway = 1e3;

// Homogeneous control points of pieces of one curve; ranges refer to ctrl. Pieces follow each other.
template <typename H>
struct Pieces {
  std::vector<CurvePiece> list;
  std::vector<H> ctrl;
  bool empty() const { return list.empty(); }
  H& first() { return ctrl[list.front().ctrl.begin]; }
  H& last() { return ctrl[list.back().ctrl.end - 1]; }
  const H& first() const { return ctrl[list.front().ctrl.begin]; }
  const H& last() const { return ctrl[list.back().ctrl.end - 1]; }
};
using Pieces2 = Pieces<dvec3>;
using Pieces3 = Pieces<dvec4>;

// Where a curve is defined: all reals for lines and the other conics, the knots' ends for splines. period > 0
// for periodic curves (2 pi for circles and ellipses).
struct CurveDomain {
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  double period = 0.0;
};
template <int D>
CurveDomain curve_domain(const std::vector<brep::Curve<glm::vec<D, double>>>& curves, std::int32_t index);

// The curve over [a, b], a < b, as an exact spline whose knots are curve parameters. Empty for what has no
// exact form (offsets) and for damaged curves (not finite, weights <= 0, knots that do not add up).
template <int D>
std::optional<SplineCurve<glm::vec<D + 1, double>>> curve_form(
    const std::vector<brep::Curve<glm::vec<D, double>>>& curves, std::int32_t index, double a, double b);

// The same as Bezier pieces; offsets as piecewise cubics within fit_tolerance (in the curve's own units).
template <int D>
std::optional<Pieces<glm::vec<D + 1, double>>> curve_pieces(
    const std::vector<brep::Curve<glm::vec<D, double>>>& curves, std::int32_t index, double a, double b,
    double fit_tolerance);

template <typename H>
Pieces<H> pieces_of(const SplineCurve<H>& curve);

// Piecewise cubics through f at parameters of [a, b], halved until the middle of each third is within
// tolerance or the depth is spent.
template <int D>
Pieces<glm::vec<D + 1, double>> fit_cubics(const std::function<glm::vec<D, double>(double)>& f, double a,
                                           double b, double tolerance);

// The formula of a curve that is a conic, trimmed or not.
template <int D>
std::optional<Conic> conic_of(const std::vector<brep::Curve<glm::vec<D, double>>>& curves,
                              std::int32_t index);

// The conic in its place; none where the map is not rigid, up to a uniform scale.
std::optional<Conic> placed(const std::optional<Conic>& conic, const Transform& placement);

// Copies the conic to the store's end and returns its index, -1 for none.
std::int32_t append_conic(NurbsStore& store, const std::optional<Conic>& conic);

// Point and derivative of a spline curve at its parameter (through the map).
template <int D>
void curve_point(const SplineCurve<glm::vec<D + 1, double>>& curve, double t, glm::vec<D, double>& point,
                 glm::vec<D, double>& derivative);

// Are all parameters and control points finite and all weights positive?
template <typename H>
bool pieces_sound(const Pieces<H>& pieces);

// Turns the order and each piece round; t0 and t1 change places.
template <typename H>
void reverse_pieces(Pieces<H>& pieces);

// Do knots, multiplicities and poles of a spline direction agree?
bool knots_valid(std::span<const double> knots, std::span<const std::int32_t> multiplicities, int degree,
                 std::size_t poles, bool periodic);

void transform_ctrl(std::span<dvec4> ctrl_h, const Transform& placement);

}  // namespace trimray::nurbs
