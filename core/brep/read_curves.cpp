// The sections "Curve2ds" and "Curves": one template for both, since they differ only in the vectors'
// dimension, the axis of a conic and the direction of an offset.
#include "core/brep/sections.h"

namespace trimray::brep {

int read_degree(ByteReader& in) {
  const int degree = in.short_integer();
  if (degree < 1 || degree > kMaxDegree) in.fail("degree out of range");
  return degree;
}

void read_knots(ByteReader& in, std::int32_t knot_count, std::int32_t pole_count, int degree, bool periodic,
                std::vector<double>& knots, std::vector<std::int32_t>& multiplicities) {
  if (knot_count < 2) in.fail("fewer than two knots");
  in.checked_count(knot_count, 12);
  knots.reserve(knot_count);
  multiplicities.reserve(knot_count);
  std::int64_t sum = 0;
  for (std::int32_t i = 0; i < knot_count; ++i) {
    knots.push_back(in.real());
    const std::int32_t multiplicity = in.integer();
    if (multiplicity < 1 || multiplicity > degree + 1) in.fail("multiplicity out of range");
    multiplicities.push_back(multiplicity);
    sum += multiplicity;
  }
  // A periodic spline counts the last knot as the first one seen again.
  if (periodic && multiplicities.front() != multiplicities.back()) in.fail("end multiplicities differ");
  const std::int64_t poles = periodic ? sum - multiplicities.back() : sum - degree - 1;
  if (poles != pole_count) in.fail("multiplicities do not fit the number of poles");
}

namespace {

template <typename Vec>
Vec read_vec(ByteReader& in) {
  if constexpr (Vec::length() == 2) {
    return in.vec2();
  } else {
    return in.vec3();
  }
}

template <typename Vec>
void read_frame(ByteReader& in, Curve<Vec>& curve) {
  curve.location = read_vec<Vec>(in);
  if constexpr (Vec::length() == 3) in.vec3();  // the normal, which x_axis and y_axis already say
  curve.x_axis = read_vec<Vec>(in);
  curve.y_axis = read_vec<Vec>(in);
}

template <typename Vec>
void read_poles(ByteReader& in, std::int32_t count, Curve<Vec>& curve) {
  in.checked_count(count, sizeof(Vec) + (curve.rational ? 8 : 0));
  curve.poles.reserve(count);
  if (curve.rational) curve.weights.reserve(count);
  for (std::int32_t i = 0; i < count; ++i) {
    curve.poles.push_back(read_vec<Vec>(in));
    if (curve.rational) curve.weights.push_back(in.real());
  }
}

template <typename Vec>
void read_bezier(ByteReader& in, Curve<Vec>& curve) {
  curve.rational = in.flag();
  curve.degree = read_degree(in);
  read_poles(in, curve.degree + 1, curve);
  curve.knots = {0.0, 1.0};
  curve.multiplicities = {curve.degree + 1, curve.degree + 1};
}

template <typename Vec>
void read_bspline(ByteReader& in, Curve<Vec>& curve) {
  curve.rational = in.flag();
  curve.periodic = in.flag();
  curve.degree = read_degree(in);
  const std::int32_t pole_count = in.count(sizeof(Vec));
  const std::int32_t knot_count = in.count(12);
  if (pole_count < 2) in.fail("fewer than two poles");
  read_poles(in, pole_count, curve);
  read_knots(in, knot_count, pole_count, curve.degree, curve.periodic, curve.knots, curve.multiplicities);
}

// Appends a curve behind its basis; returns its index.
template <typename Vec>
std::int32_t read_curve(ByteReader& in, std::vector<Curve<Vec>>& out, int depth) {
  if (depth > kMaxBasisDepth) in.fail("basis curves nested too deeply");
  const std::uint8_t code = in.byte();
  if (code < 1 || code > 9) in.fail("unknown kind of curve");
  Curve<Vec> curve;
  curve.kind = static_cast<CurveKind>(code - 1);
  switch (curve.kind) {
    case CurveKind::kLine:
      curve.location = read_vec<Vec>(in);
      curve.x_axis = read_vec<Vec>(in);
      break;
    case CurveKind::kCircle:
    case CurveKind::kParabola:
      read_frame(in, curve);
      curve.r1 = in.real();
      break;
    case CurveKind::kEllipse:
    case CurveKind::kHyperbola:
      read_frame(in, curve);
      curve.r1 = in.real();
      curve.r2 = in.real();
      break;
    case CurveKind::kBezier:
      read_bezier(in, curve);
      break;
    case CurveKind::kBspline:
      read_bspline(in, curve);
      break;
    case CurveKind::kTrimmed:
      curve.first = in.real();
      curve.last = in.real();
      curve.basis = read_curve(in, out, depth + 1);
      break;
    case CurveKind::kOffset:
      curve.offset = in.real();
      if constexpr (Vec::length() == 3) curve.offset_direction = in.vec3();
      curve.basis = read_curve(in, out, depth + 1);
      break;
  }
  out.push_back(std::move(curve));
  return static_cast<std::int32_t>(out.size()) - 1;
}

}  // namespace

std::int32_t read_curve3(ByteReader& in, Model& model) { return read_curve(in, model.curves3, 0); }

void read_curves2(ByteReader& in, Model& model, StreamTables& tables) {
  const std::int32_t count = in.section("Curve2ds", 33);
  tables.curves2.reserve(count);
  model.curves2.reserve(count);
  for (std::int32_t i = 0; i < count; ++i) tables.curves2.push_back(read_curve(in, model.curves2, 0));
}

void read_curves3(ByteReader& in, Model& model, StreamTables& tables) {
  const std::int32_t count = in.section("Curves", 49);
  tables.curves3.reserve(count);
  model.curves3.reserve(count);
  for (std::int32_t i = 0; i < count; ++i) tables.curves3.push_back(read_curve(in, model.curves3, 0));
}

}  // namespace trimray::brep
