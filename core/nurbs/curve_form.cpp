#include "core/nurbs/curve_form.h"

#include <cmath>
#include <numbers>

#include "core/nurbs/surface_form.h"

namespace trimray::nurbs {
namespace {

using brep::CurveKind;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kMaxTurns = 64.0;      // periods that a range may span
constexpr double kMaxHyperbola = 60.0;  // cosh stays far below kMaxCoordinate's square
constexpr int kFitDepth = 10;

template <int D>
using Vec = glm::vec<D, double>;
template <int D>
using Hom = glm::vec<D + 1, double>;
template <int D>
using Curves = std::vector<brep::Curve<Vec<D>>>;

template <int D>
bool usable(const SplineCurve<Hom<D>>& c) {
  for (const double k : c.knots)
    if (!(std::abs(k) < kMaxCoordinate)) return false;
  for (const Hom<D>& h : c.ctrl) {
    if (!(h[D] > 0.0) || !std::isfinite(h[D])) return false;
    for (int i = 0; i < D; ++i)
      if (!(std::abs(h[i]) <= kMaxCoordinate * h[D])) return false;
  }
  return !c.ctrl.empty();
}

// origin + f.x * x + f.y * y for a conic's basis f.
template <int D>
SplineCurve<Hom<D>> conic(const SplineCurve<dvec3>& basis, Vec<D> origin, Vec<D> x, Vec<D> y) {
  SplineCurve<Hom<D>> r;
  r.degree = basis.degree, r.knots = basis.knots, r.map = basis.map;
  for (const dvec3& f : basis.ctrl) r.ctrl.emplace_back(f.x * x + f.y * y + f.z * origin, f.z);
  return r;
}

// Moves an end that misses a knot by rounding alone onto the knot.
double snap(double t, std::span<const double> knots, double eps) {
  for (const double k : knots)
    if (std::abs(t - k) <= eps) return k;
  return t;
}

template <int D>
std::optional<SplineCurve<Hom<D>>> spline_form(const brep::Curve<Vec<D>>& c, double a, double b) {
  SplineCurve<Hom<D>> r;
  r.degree = c.degree;
  std::vector<int> wrap;
  if (c.kind == CurveKind::kBezier) {
    r.degree = static_cast<int>(c.poles.size()) - 1;
    if (r.degree < 1 || r.degree > kMaxDegree) return {};
    r.knots.assign(r.degree + 1, 0.0);
    r.knots.insert(r.knots.end(), r.degree + 1, 1.0);
    for (int i = 0; i <= r.degree; ++i) wrap.push_back(i);
  } else {
    if (!knots_valid(c.knots, c.multiplicities, c.degree, c.poles.size(), c.periodic)) return {};
    const double period = c.knots.back() - c.knots.front();
    if (c.periodic && (b - a) > kMaxTurns * period) return {};
    if (c.periodic && !(std::abs(a - c.knots.front()) <= kMaxTurnsAway * period)) return {};
    FlatKnots flat = flatten_knots(c.knots, c.multiplicities, c.degree, static_cast<int>(c.poles.size()),
                                   c.periodic, a, b);
    r.knots = std::move(flat.knots), wrap = std::move(flat.wrap);
  }
  if (!c.weights.empty() && c.weights.size() != c.poles.size()) return {};
  for (const int i : wrap) {
    const double w = c.weights.empty() ? 1.0 : c.weights[i];
    if (!(w > 0.0)) return {};
    r.ctrl.emplace_back(w * c.poles[i], w);
  }
  const double width = r.end() - r.begin();
  a = snap(a, r.knots, 1e-13 * width), b = snap(b, r.knots, 1e-13 * width);
  // Slightly outside is a file's rounding; far outside is nonsense.
  if (!(b > a) || a < r.begin() - 0.5 * width || b > r.end() + 0.5 * width) return {};
  if (a >= r.end() || b <= r.begin()) return {};
  return respan_curve(r, a, b);
}

}  // namespace

bool knots_valid(std::span<const double> knots, std::span<const std::int32_t> multiplicities, int degree,
                 std::size_t poles, bool periodic) {
  if (degree < 1 || degree > kMaxDegree || knots.size() < 2 || knots.size() != multiplicities.size())
    return false;
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (!(std::abs(knots[i]) < kMaxCoordinate) || (i > 0 && !(knots[i] > knots[i - 1]))) return false;
    const bool end = i == 0 || i + 1 == knots.size();
    if (multiplicities[i] < 1 || multiplicities[i] > degree + (end && !periodic ? 1 : 0)) return false;
    sum += multiplicities[i];
  }
  if (periodic)
    return multiplicities.front() == multiplicities.back() &&
           static_cast<std::int64_t>(poles) == sum - multiplicities.back();
  if (poles <= static_cast<std::size_t>(degree) || sum != static_cast<std::int64_t>(poles) + degree + 1)
    return false;
  // An unclamped spline is fine as long as its domain is not empty.
  double lo = 0.0, hi = 0.0;
  std::int64_t at = 0;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const std::int64_t next = at + multiplicities[i];
    if (at <= degree && degree < next) lo = knots[i];
    if (at <= static_cast<std::int64_t>(poles) && static_cast<std::int64_t>(poles) < next) hi = knots[i];
    at = next;
  }
  return hi > lo;
}

template <int D>
CurveDomain curve_domain(const Curves<D>& curves, std::int32_t index) {
  while (curves[index].kind == CurveKind::kOffset) index = curves[index].basis;
  const brep::Curve<Vec<D>>& c = curves[index];
  CurveDomain d;
  switch (c.kind) {
    case CurveKind::kCircle:
    case CurveKind::kEllipse:
      d.period = kTurn;
      break;
    case CurveKind::kBezier:
      d.lower = 0.0, d.upper = 1.0;
      break;
    case CurveKind::kBspline:
      if (!c.knots.empty()) {
        d.lower = c.knots.front(), d.upper = c.knots.back();
        if (c.periodic) d.period = d.upper - d.lower;
      }
      break;
    case CurveKind::kTrimmed:
      d.lower = c.first, d.upper = c.last;
      break;
    default:
      break;
  }
  return d;
}

template <int D>
std::optional<SplineCurve<Hom<D>>> curve_form(const Curves<D>& curves, std::int32_t index, double a,
                                              double b) {
  if (index < 0 || !(b > a) || !(std::abs(a) < kMaxCoordinate) || !(std::abs(b) < kMaxCoordinate)) return {};
  while (curves[index].kind == CurveKind::kTrimmed) index = curves[index].basis;
  const brep::Curve<Vec<D>>& c = curves[index];
  std::optional<SplineCurve<Hom<D>>> r;
  switch (c.kind) {
    case CurveKind::kLine:
      r.emplace();
      r->degree = 1, r->knots = {a, a, b, b};
      r->ctrl = {Hom<D>(c.location + a * c.x_axis, 1.0), Hom<D>(c.location + b * c.x_axis, 1.0)};
      break;
    case CurveKind::kCircle:
    case CurveKind::kEllipse:
      if (b - a > kMaxTurns * kTurn) return {};
      r = conic<D>(circle_basis(a, b), c.location, c.r1 * c.x_axis,
                   (c.kind == CurveKind::kCircle ? c.r1 : c.r2) * c.y_axis);
      break;
    case CurveKind::kHyperbola:
      if (std::abs(a) > kMaxHyperbola || std::abs(b) > kMaxHyperbola) return {};
      r = conic<D>(hyperbola_basis(a, b), c.location, c.r1 * c.x_axis, c.r2 * c.y_axis);
      break;
    case CurveKind::kParabola: {
      const auto bloom = [&](double s, double t) {
        return Hom<D>(c.location + s * t / (4.0 * c.r1) * c.x_axis + 0.5 * (s + t) * c.y_axis, 1.0);
      };
      r.emplace();
      r->degree = 2, r->knots = {a, a, a, b, b, b}, r->ctrl = {bloom(a, a), bloom(a, b), bloom(b, b)};
      break;
    }
    case CurveKind::kBezier:
    case CurveKind::kBspline:
      r = spline_form<D>(c, a, b);
      break;
    case CurveKind::kTrimmed:
    case CurveKind::kOffset:
      return {};
  }
  if (r && !usable<D>(*r)) r.reset();
  return r;
}

template <int D>
void curve_point(const SplineCurve<Hom<D>>& curve, double t, Vec<D>& point, Vec<D>& derivative) {
  const int span = find_span(curve.knots, curve.degree, t);
  const MappedParameter m = map_parameter(curve.map, curve.knots[span], curve.knots[span + 1], t);
  Basis basis;
  basis_functions(curve.knots, curve.degree, span, m.s, 1, basis);
  Hom<D> h(0.0), d(0.0);
  for (int i = 0; i <= curve.degree; ++i) {
    h += basis.value[0][i] * curve.ctrl[span - curve.degree + i];
    d += basis.value[1][i] * curve.ctrl[span - curve.degree + i];
  }
  point = Vec<D>(h) / h[D];
  derivative = (Vec<D>(d) - d[D] * point) / h[D] * m.ds;
}

template <typename H>
Pieces<H> pieces_of(const SplineCurve<H>& curve) {
  Pieces<H> r;
  append_bezier<H>(curve.knots, curve.degree, curve.ctrl.data(), 1, r.ctrl);
  const std::vector<double> t = distinct_knots(curve.knots, curve.degree);
  for (std::size_t k = 0; k + 1 < t.size(); ++k) {
    const std::int32_t begin = static_cast<std::int32_t>(k) * (curve.degree + 1);
    r.list.push_back({{begin, begin + curve.degree + 1}, t[k], t[k + 1]});
  }
  return r;
}

template <typename H>
void reverse_pieces(Pieces<H>& pieces) {
  std::reverse(pieces.list.begin(), pieces.list.end());
  for (CurvePiece& p : pieces.list) {
    std::swap(p.t0, p.t1);
    std::reverse(pieces.ctrl.begin() + p.ctrl.begin, pieces.ctrl.begin() + p.ctrl.end);
  }
}

template <typename H>
bool pieces_sound(const Pieces<H>& pieces) {
  for (const CurvePiece& p : pieces.list)
    if (!std::isfinite(p.t0) || !std::isfinite(p.t1)) return false;
  for (const H& h : pieces.ctrl) {
    for (int i = 0; i < H::length(); ++i)
      if (!std::isfinite(h[i])) return false;
    if (!(h[H::length() - 1] > 0.0)) return false;
  }
  return true;
}

template <int D>
Pieces<Hom<D>> fit_cubics(const std::function<Vec<D>(double)>& f, double a, double b, double tolerance) {
  Pieces<Hom<D>> r;
  const auto add = [&](const auto& self, double t0, double t1, Vec<D> p0, Vec<D> p3, int depth) -> void {
    const double h = (t1 - t0) / 3.0;
    const Vec<D> p1 = f(t0 + h), p2 = f(t1 - h);
    // The cubic through four points at thirds.
    const Vec<D> c1 = (-5.0 * p0 + 18.0 * p1 - 9.0 * p2 + 2.0 * p3) / 6.0;
    const Vec<D> c2 = (2.0 * p0 - 9.0 * p1 + 18.0 * p2 - 5.0 * p3) / 6.0;
    const Vec<D> ctrl[4] = {p0, c1, c2, p3};
    double worst = 0.0;
    for (const double x : {1.0 / 6.0, 0.5, 5.0 / 6.0})
      worst = std::max(worst, glm::distance(bezier_point(ctrl, 3, x), f(t0 + x * (t1 - t0))));
    if (!(worst <= tolerance) && depth < kFitDepth) {
      const double middle = 0.5 * (t0 + t1);
      const Vec<D> pm = f(middle);
      self(self, t0, middle, p0, pm, depth + 1);
      self(self, middle, t1, pm, p3, depth + 1);
      return;
    }
    const std::int32_t begin = static_cast<std::int32_t>(r.ctrl.size());
    for (const Vec<D>& p : ctrl) r.ctrl.emplace_back(p, 1.0);
    r.list.push_back({{begin, begin + 4}, t0, t1});
  };
  add(add, a, b, f(a), f(b), 0);
  return r;
}

namespace {

template <int D>
std::optional<Pieces<Hom<D>>> offset_pieces(const Curves<D>& curves, const brep::Curve<Vec<D>>& c, double a,
                                            double b, double fit_tolerance) {
  // Offsets of offsets along the same direction add up.
  double offset = c.offset;
  std::int32_t basis = c.basis;
  while (basis >= 0 &&
         (curves[basis].kind == CurveKind::kOffset || curves[basis].kind == CurveKind::kTrimmed)) {
    if (curves[basis].kind == CurveKind::kOffset) {
      if (D == 3 && glm::distance(curves[basis].offset_direction, c.offset_direction) > 1e-9) return {};
      offset += curves[basis].offset;
    }
    basis = curves[basis].basis;
  }
  const auto form = curve_form<D>(curves, basis, a, b);
  if (!form || !std::isfinite(offset)) return {};
  const auto f = [&](double t) {
    Vec<D> p, d;
    curve_point<D>(*form, t, p, d);
    Vec<D> side;
    if constexpr (D == 2)
      side = dvec2(d.y, -d.x);
    else
      side = glm::cross(d, c.offset_direction);
    const double length = glm::length(side);
    return length > 0.0 ? p + offset / length * side : p;
  };
  return fit_cubics<D>(f, a, b, fit_tolerance);
}

}  // namespace

template <int D>
std::optional<Pieces<Hom<D>>> curve_pieces(const Curves<D>& curves, std::int32_t index, double a, double b,
                                           double fit_tolerance) {
  if (index < 0) return {};
  while (curves[index].kind == CurveKind::kTrimmed) index = curves[index].basis;
  if (curves[index].kind == CurveKind::kOffset) {
    if (!(b > a) || !std::isfinite(a) || !std::isfinite(b)) return {};
    auto r = offset_pieces<D>(curves, curves[index], a, b, fit_tolerance);
    if (r)
      for (const Hom<D>& h : r->ctrl)
        for (int i = 0; i < D; ++i)
          if (!(std::abs(h[i]) <= kMaxCoordinate)) return {};
    return r;
  }
  const auto form = curve_form<D>(curves, index, a, b);
  if (!form) return {};
  return pieces_of(*form);
}

template <int D>
std::optional<Conic> conic_of(const Curves<D>& curves, std::int32_t index) {
  if (index < 0) return {};
  while (curves[index].kind == CurveKind::kTrimmed) index = curves[index].basis;
  const brep::Curve<Vec<D>>& c = curves[index];
  if (c.kind < CurveKind::kCircle || c.kind > CurveKind::kHyperbola) return {};
  constexpr ConicKind kinds[] = {ConicKind::kCircle, ConicKind::kEllipse, ConicKind::kParabola,
                                 ConicKind::kHyperbola};
  Conic r;
  r.kind = kinds[static_cast<int>(c.kind) - static_cast<int>(CurveKind::kCircle)];
  for (int i = 0; i < D; ++i)
    r.location[i] = c.location[i], r.x_axis[i] = c.x_axis[i], r.y_axis[i] = c.y_axis[i];
  r.r1 = c.r1, r.r2 = c.r2;
  bool sound = std::isfinite(r.r1) && std::isfinite(r.r2);
  for (int i = 0; i < 3; ++i)
    sound = sound && std::isfinite(r.location[i]) && std::isfinite(r.x_axis[i]) && std::isfinite(r.y_axis[i]);
  if (!sound) return {};
  return r;
}

std::optional<Conic> placed(const std::optional<Conic>& conic, const Transform& t) {
  if (!conic || (t.linear == dmat3(1.0) && t.translation == dvec3(0.0))) return conic;
  const double scale = std::cbrt(std::abs(glm::determinant(t.linear)));
  const dmat3 gram = glm::transpose(t.linear) * t.linear;
  bool similar = scale > 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      similar = similar && std::abs(gram[i][j] - (i == j ? scale * scale : 0.0)) <= 1e-9 * scale * scale;
  // A parabola's parameter is a length.
  if (!similar || (conic->kind == ConicKind::kParabola && std::abs(scale - 1.0) > 1e-12)) return {};
  Conic r = *conic;
  r.location = t.point(r.location);
  r.x_axis = t.vector(r.x_axis) / scale, r.y_axis = t.vector(r.y_axis) / scale;
  r.r1 *= scale, r.r2 *= scale;
  return r;
}

std::int32_t append_conic(NurbsStore& store, const std::optional<Conic>& conic) {
  if (!conic) return -1;
  store.conics.push_back(*conic);
  return static_cast<std::int32_t>(store.conics.size()) - 1;
}

void transform_ctrl(std::span<dvec4> ctrl_h, const Transform& placement) {
  for (dvec4& h : ctrl_h)
    h = dvec4(placement.linear * dvec3(h.x, h.y, h.z) + h.w * placement.translation, h.w);
}

template CurveDomain curve_domain<2>(const Curves<2>&, std::int32_t);
template CurveDomain curve_domain<3>(const Curves<3>&, std::int32_t);
template std::optional<SplineCurve<dvec3>> curve_form<2>(const Curves<2>&, std::int32_t, double, double);
template std::optional<SplineCurve<dvec4>> curve_form<3>(const Curves<3>&, std::int32_t, double, double);
template std::optional<Pieces2> curve_pieces<2>(const Curves<2>&, std::int32_t, double, double, double);
template std::optional<Pieces3> curve_pieces<3>(const Curves<3>&, std::int32_t, double, double, double);
template Pieces2 pieces_of(const SplineCurve<dvec3>&);
template Pieces3 pieces_of(const SplineCurve<dvec4>&);
template Pieces2 fit_cubics<2>(const std::function<dvec2(double)>&, double, double, double);
template Pieces3 fit_cubics<3>(const std::function<dvec3(double)>&, double, double, double);
template std::optional<Conic> conic_of<2>(const Curves<2>&, std::int32_t);
template std::optional<Conic> conic_of<3>(const Curves<3>&, std::int32_t);
template void curve_point<2>(const SplineCurve<dvec3>&, double, dvec2&, dvec2&);
template void curve_point<3>(const SplineCurve<dvec4>&, double, dvec3&, dvec3&);
template bool pieces_sound(const Pieces2&);
template bool pieces_sound(const Pieces3&);
template void reverse_pieces(Pieces2&);
template void reverse_pieces(Pieces3&);

}  // namespace trimray::nurbs
