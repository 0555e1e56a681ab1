#include "core/nurbs/project_curve.h"

#include <cmath>

#include "core/base/box.h"

namespace trimray::nurbs {
namespace {

constexpr int kSamples = 16;  // a piece
constexpr int kGrid = 24;     // starts a direction

std::size_t piece_at(const Pieces3& path, double t) {
  std::size_t lo = 0, hi = path.list.size();
  while (hi - lo > 1) {
    const std::size_t middle = (lo + hi) / 2;
    (t < path.list[middle].t0 ? hi : lo) = middle;
  }
  return lo;
}

// Closest point of one piece by Gauss-Newton from x in [0, 1]; returns the squared distance, moves x. Stops
// early below enough (squared), and where a step gains less than a hundredth.
double closest_on_piece(const dvec4* ctrl, int degree, dvec3 point, double enough, double& x) {
  double best = kInf;
  for (int step = 0; step < 8; ++step) {
    // Value and derivative from the last two points of de Casteljau.
    dvec4 d[kMaxDegree + 1];
    for (int i = 0; i <= degree; ++i) d[i] = ctrl[i];
    for (int r = 1; r < degree; ++r)
      for (int i = 0; i + r <= degree; ++i) d[i] = (1.0 - x) * d[i] + x * d[i + 1];
    const dvec4 h = (1.0 - x) * d[0] + x * d[1], dh = static_cast<double>(degree) * (d[1] - d[0]);
    const dvec3 p = dvec3(h) / h.w, dp = (dvec3(dh) - dh.w * p) / h.w;
    const dvec3 to = point - p;
    const double square = glm::dot(to, to);
    if (!(square < best * 0.98)) return std::min(best, square);
    best = square;
    if (best <= enough) return best;
    const double speed = glm::dot(dp, dp);
    if (!(speed > 0.0)) break;
    const double next = std::clamp(x + glm::dot(to, dp) / speed, 0.0, 1.0);
    if (std::abs(next - x) < 1e-12) break;
    x = next;
  }
  return best;
}

dvec2 closed_form_uv(const Surface& f, dvec3 p) {
  const dvec3 d = p - f.location;
  const double x = glm::dot(d, f.x_axis), y = glm::dot(d, f.y_axis), z = glm::dot(d, f.z_axis);
  const double u = std::atan2(y, x), r = std::hypot(x, y);
  switch (f.kind) {
    case SurfaceKind::kPlane:
      return {x, y};
    case SurfaceKind::kCylinder:
      return {u, z};
    case SurfaceKind::kCone: {
      const double s = std::sin(f.semi_angle), c = std::cos(f.semi_angle);
      const double v = (r - f.r1) * s + z * c, w = (-r - f.r1) * s + z * c;  // this nappe, the other one
      return f.r1 + v * s >= 0.0 || f.r1 + w * s > 0.0 ? dvec2(u, v) : dvec2(std::atan2(-y, -x), w);
    }
    case SurfaceKind::kSphere:
      return {u, std::atan2(z, r)};
    default:
      return {u, std::atan2(z, r - f.r1)};
  }
}

dvec2 first_uv(const SurfaceView& s, dvec3 point) {
  if (has_closed_form(s.surface->kind)) return closed_form_uv(*s.surface, point);
  dvec2 best(0.0);
  double best_distance = kInf;
  const std::vector<double> us = distinct_knots(s.knots_u, s.surface->degree_u),
                            vs = distinct_knots(s.knots_v, s.surface->degree_v);
  const auto samples = [](const std::vector<double>& knots) {
    std::vector<double> out;
    const int inner = std::max(2, kGrid / static_cast<int>(knots.size()));
    for (std::size_t i = 0; i + 1 < knots.size(); ++i)
      for (int k = 0; k < inner; ++k) out.push_back(knots[i] + (knots[i + 1] - knots[i]) * (k + 0.5) / inner);
    return out;
  };
  const std::vector<double> su = samples(us), sv = samples(vs);
  for (const double u : su)
    for (const double v : sv) {
      const double distance = glm::distance(point, evaluate(s, {u, v}).p);
      if (distance < best_distance) best = {u, v}, best_distance = distance;
    }
  return best;
}

}  // namespace

Pieces2 project_on_plane(const Pieces3& path, const Surface& plane) {
  // The axes need not be unit or orthogonal: solve with their Gram matrix.
  const double a = glm::dot(plane.x_axis, plane.x_axis), b = glm::dot(plane.x_axis, plane.y_axis),
               c = glm::dot(plane.y_axis, plane.y_axis), det = a * c - b * b;
  Pieces2 r;
  r.list = path.list;
  r.ctrl.reserve(path.ctrl.size());
  for (const dvec4& h : path.ctrl) {
    const dvec3 d = dvec3(h) - h.w * plane.location;
    const double x = glm::dot(d, plane.x_axis), y = glm::dot(d, plane.y_axis);
    r.ctrl.emplace_back((c * x - b * y) / det, (a * y - b * x) / det, h.w);
  }
  return r;
}

dvec2 closest_uv(const SurfaceView& surface, dvec3 point, dvec2 guess) {
  dvec2 uv = guess;
  double last = kInf;
  for (int step = 0; step < 30; ++step) {
    const SurfacePoint s = evaluate(surface, uv);
    const dvec3 to = point - s.p;
    const double a = glm::dot(s.du, s.du), b = glm::dot(s.du, s.dv), c = glm::dot(s.dv, s.dv);
    const double x = glm::dot(to, s.du), y = glm::dot(to, s.dv), det = a * c - b * b;
    if (!(det > 1e-20 * a * c)) {  // a pole: only the direction that still moves
      if (c > a)
        uv.y += y / c;
      else if (a > 0.0)
        uv.x += x / a;
      break;
    }
    const dvec2 move((c * x - b * y) / det, (a * y - b * x) / det);
    const double length = std::sqrt(move.x * move.x * a + move.y * move.y * c);
    uv += length > last ? 0.5 * move : move;
    if (length <= 1e-15 * (glm::length(point) + 1.0)) break;
    last = std::min(last, length);
  }
  return uv;
}

std::optional<Pieces2> project_on_surface(const Pieces3& path, const SurfaceView& surface, double reach) {
  if (path.empty()) return {};
  const Surface& f = *surface.surface;
  Pieces2 r;
  dvec2 guess(0.0);
  bool have_guess = false;
  for (const CurvePiece& piece : path.list) {
    const dvec4* ctrl = &path.ctrl[piece.ctrl.begin];
    const int degree = piece.ctrl.size() - 1;
    // A table of uv along the piece, continuous over periods; where u has no meaning (a pole) the
    // neighbour's.
    dvec2 table[kSamples + 1];
    for (int i = 0; i <= kSamples; ++i) {
      const dvec3 p = project(bezier_point(ctrl, degree, double(i) / kSamples));
      const bool closed = has_closed_form(f.kind);
      dvec2 uv = closest_uv(surface, p, closed || !have_guess ? first_uv(surface, p) : guess);
      if (!closed && have_guess && glm::distance(evaluate(surface, uv).p, p) > reach)
        uv = closest_uv(surface, p, first_uv(surface, p));
      const SurfacePoint at = evaluate(surface, uv);
      if (!(glm::distance(at.p, p) <= reach)) return {};
      if (have_guess) uv = {wrap_near(uv.x, guess.x, f.period_u), wrap_near(uv.y, guess.y, f.period_v)};
      const double pole = 1e-9 * (glm::length(at.du) + glm::length(at.dv));
      if (have_guess && glm::length(at.du) <= pole) uv.x = guess.x;
      if (have_guess && glm::length(at.dv) <= pole) uv.y = guess.y;
      table[i] = guess = uv;
      have_guess = true;
    }
    const SurfacePoint start = evaluate(surface, table[0]);
    const double pole = 1e-9 * (glm::length(start.du) + glm::length(start.dv));
    if (glm::length(start.du) <= pole) table[0].x = table[1].x;
    if (glm::length(start.dv) <= pole) table[0].y = table[1].y;

    const auto uv_at = [&](double x) {
      const int i = std::clamp(static_cast<int>(x * kSamples), 0, kSamples - 1);
      if (x == double(i) / kSamples) return table[i];
      if (x == double(i + 1) / kSamples) return table[i + 1];
      const double part = x * kSamples - i;
      const dvec2 about = (1.0 - part) * table[i] + part * table[i + 1];
      return closest_uv(surface, project(bezier_point(ctrl, degree, x)), about);
    };
    const double size = glm::length(table[kSamples] - table[0]) + glm::length(table[kSamples / 2] - table[0]);
    const Pieces2 fit = fit_cubics<2>(uv_at, 0.0, 1.0, 1e-9 * size);
    for (CurvePiece p : fit.list) {
      const std::int32_t offset = static_cast<std::int32_t>(r.ctrl.size());
      r.list.push_back({{offset, offset + p.ctrl.size()},
                        piece.t0 + p.t0 * (piece.t1 - piece.t0),
                        piece.t0 + p.t1 * (piece.t1 - piece.t0)});
      r.ctrl.insert(r.ctrl.end(), fit.ctrl.begin() + p.ctrl.begin, fit.ctrl.begin() + p.ctrl.end);
    }
  }
  return r;
}

double path_distance(const Pieces3& path, dvec3 point, double t, double good_enough) {
  const double enough = good_enough * good_enough;
  double best = kInf;
  const auto attempt = [&](std::size_t k, double x) {
    const CurvePiece& p = path.list[k];
    best = std::min(best, closest_on_piece(&path.ctrl[p.ctrl.begin], p.ctrl.size() - 1, point, enough, x));
    return x;
  };
  const std::size_t k = piece_at(path, t);
  const CurvePiece& p = path.list[k];
  const double x = attempt(k, std::clamp((t - p.t0) / (p.t1 - p.t0), 0.0, 1.0));
  if (best <= enough) return std::sqrt(best);
  if (x <= 0.0 && k > 0) attempt(k - 1, 1.0);
  if (x >= 1.0 && k + 1 < path.list.size()) attempt(k + 1, 0.0);
  if (best <= enough) return std::sqrt(best);
  for (std::size_t i = 0; i < path.list.size(); ++i) {
    // A piece whose control hull is farther than the best so far cannot help.
    Box3 hull;
    for (std::int32_t c = path.list[i].ctrl.begin; c < path.list[i].ctrl.end; ++c)
      hull.add(project(path.ctrl[c]));
    const dvec3 off = glm::max(glm::max(hull.lower - point, point - hull.upper), dvec3(0.0));
    if (glm::dot(off, off) >= best) continue;
    for (const double start : {0.1, 0.5, 0.9}) attempt(i, start);
  }
  return std::sqrt(best);
}

dvec3 path_point(const Pieces3& path, double t) {
  const CurvePiece& p = path.list[piece_at(path, t)];
  return project(bezier_point(&path.ctrl[p.ctrl.begin], p.ctrl.size() - 1, (t - p.t0) / (p.t1 - p.t0)));
}

}  // namespace trimray::nurbs
