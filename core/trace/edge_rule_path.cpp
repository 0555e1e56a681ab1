#include "core/trace/edge_rule_path.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/nurbs/trim_bezier.h"

namespace trimray::trace {
namespace {

using nurbs::kMaxPieceDegree;

Box3 box_of_edges(const nurbs::NurbsStore& store, nurbs::Range edges) {
  Box3 box;
  for (std::int32_t e = edges.begin; e < edges.end; ++e) {
    for (std::int32_t v : store.edges[e].vertex)
      if (v >= 0) box.add(store.vertices[v].point);
    for (std::int32_t p = store.edges[e].pieces.begin; p < store.edges[e].pieces.end; ++p)
      for (std::int32_t c = store.edge_pieces[p].ctrl.begin; c < store.edge_pieces[p].ctrl.end; ++c)
        box.add(dvec3(store.edge_ctrl_h[c]) / store.edge_ctrl_h[c].w);
  }
  return box;
}

// Coordinates below this part of the diagonal are rounding.
constexpr double kRounding = 1e-15;

bool upper(double y) { return y >= 0.0; }

// Crossings of the straight line from a to b.
int line_crossings(dvec2 a, dvec2 b) {
  const bool sa = upper(a.y), sb = upper(b.y);
  if (sa == sb) return 0;
  // x where y = 0 is cross / (b.y - a.y).
  const double cross = a.x * b.y - b.x * a.y;
  if (!(sb ? cross > 0.0 : cross < 0.0)) return 0;
  return sb ? 1 : -1;
}

// A projected piece: homogeneous x and y, whose signs are those of the point since weights are > 0.
struct Planar {
  double x[kMaxPieceDegree + 1], y[kMaxPieceDegree + 1];
};

void split(const Planar& c, int degree, double t, Planar& left, Planar& right) {
  for (int i = 0; i <= degree; ++i) right.x[i] = c.x[i], right.y[i] = c.y[i];
  for (int level = 0; level < degree; ++level) {
    left.x[level] = right.x[0], left.y[level] = right.y[0];
    for (int i = 0; i < degree - level; ++i) {
      right.x[i] = (1.0 - t) * right.x[i] + t * right.x[i + 1];
      right.y[i] = (1.0 - t) * right.y[i] + t * right.y[i + 1];
    }
  }
  left.x[degree] = right.x[0], left.y[degree] = right.y[0];
}

// Crossings of a piece whose ends lie above (or not) as s0 and s1 say: the ends are shared with other pieces
// and were judged once. size: below it, coordinates are rounding.
int curve_crossings(const Planar& c, int degree, bool s0, bool s1, double size, int depth) {
  constexpr int kMaxDepth = 50;
  bool any_upper = false, any_lower = false, any_right = false, any_left = false;
  double largest = 0.0;
  for (int i = 0; i <= degree; ++i) {
    (upper(c.y[i]) ? any_upper : any_lower) = true;
    (c.x[i] > 0.0 ? any_right : any_left) = true;
    largest = std::max({largest, std::abs(c.x[i]), std::abs(c.y[i])});
  }
  const int whole = static_cast<int>(s1) - static_cast<int>(s0);
  if (!any_left) return whole;
  if (!any_right) return 0;
  if (!any_upper || !any_lower) {
    // All on one side of the half-line's line. The ends may yet differ by rounding: then the crossing is at
    // the end next to it.
    if (whole == 0) return 0;
    const int end = std::abs(c.y[0]) < std::abs(c.y[degree]) ? 0 : degree;
    return c.x[end] > 0.0 ? whole : 0;
  }
  if (depth == kMaxDepth || !(largest > size)) return c.x[0] + c.x[degree] > 0.0 ? whole : 0;

  Planar left, right;
  split(c, degree, 0.5, left, right);
  const bool middle = upper(right.y[0]);
  return curve_crossings(left, degree, s0, middle, size, depth + 1) +
         curve_crossings(right, degree, middle, s1, size, depth + 1);
}

Planar project_piece(const dvec4* ctrl_h, int degree, const RayFrame& f, double& weight) {
  Planar planar;
  weight = 0.0;
  for (int i = 0; i <= degree; ++i) {
    const dvec4& h = ctrl_h[i];
    const dvec3 d = dvec3(h) - h.w * f.org;
    planar.x[i] = glm::dot(f.e1, d), planar.y[i] = glm::dot(f.e2, d);
    weight = std::max(weight, h.w);
  }
  return planar;
}

// One definition for all callers: what side() compares must be what crossings() counts.
int piece_crossings(const EdgePaths& paths, const PathPiece& piece, dvec2 from, dvec2 to, const RayFrame& f) {
  if (piece.degree == 1) return line_crossings(from, to);
  double weight;
  const Planar planar = project_piece(&paths.ctrl_h[piece.ctrl], piece.degree, f, weight);
  return curve_crossings(planar, piece.degree, upper(from.y), upper(to.y),
                         kRounding * paths.diagonal * weight, 0);
}

}  // namespace

EdgePaths::EdgePaths(const nurbs::NurbsStore& store, std::int32_t prototype) {
  const nurbs::Range range = store.prototypes[prototype].edges;
  const Box3 all = box_of_edges(store, range);
  if (!all.empty()) middle = all.center(), diagonal = all.diagonal();
  first_edge = range.begin;
  for (std::int32_t e = range.begin; e < range.end; ++e) {
    const nurbs::Edge& edge = store.edges[e];
    PathEdge path;
    path.band = edge.band;
    path.joint = static_cast<std::int32_t>(joints.size());
    path.piece = static_cast<std::int32_t>(pieces.size());
    Box3 box;
    if (edge.vertex[0] >= 0) joints.push_back(store.vertices[edge.vertex[0]].point - middle);
    for (std::int32_t p = edge.pieces.begin; p < edge.pieces.end; ++p) {
      const nurbs::CurvePiece& piece = store.edge_pieces[p];
      PathPiece local;
      local.ctrl = static_cast<std::int32_t>(ctrl_h.size());
      local.degree = piece.ctrl.size() - 1;
      local.t0 = piece.t0, local.t1 = piece.t1;
      if (local.degree < 1 || local.degree > kMaxPieceDegree)
        throw ArgumentError("edge " + std::to_string(e) + ": curve of degree " +
                            std::to_string(local.degree));
      for (std::int32_t c = piece.ctrl.begin; c < piece.ctrl.end; ++c) {
        const dvec4 h = store.edge_ctrl_h[c];
        const dvec3 point = dvec3(h) / h.w - middle;
        box.add(point);
        ctrl_h.push_back(dvec4(point * h.w, h.w));
      }
      const dvec3 start = dvec3(ctrl_h[local.ctrl]) / ctrl_h[local.ctrl].w;
      if (edge.vertex[0] < 0 && p == edge.pieces.begin) joints.push_back(start);
      joints.push_back(start);
      pieces.push_back(local);
      if (p + 1 == edge.pieces.end) joints.push_back(dvec3(ctrl_h.back()) / ctrl_h.back().w);
    }
    // Without a last vertex the path returns to where it began.
    if (edge.vertex[1] >= 0)
      joints.push_back(store.vertices[edge.vertex[1]].point - middle);
    else if (static_cast<std::size_t>(path.joint) < joints.size())
      joints.push_back(dvec3(joints[path.joint]));
    path.joint_count = static_cast<std::int32_t>(joints.size()) - path.joint;
    path.piece_count = static_cast<std::int32_t>(pieces.size()) - path.piece;
    for (std::int32_t j = 0; j < path.joint_count; ++j) box.add(joints[path.joint + j]);
    if (!box.empty()) path.center = box.center(), path.half = 0.5 * box.extent() + dvec3(1e-14 * diagonal);
    edges.push_back(path);
  }
}

RayFrame EdgePaths::frame(const Ray& ray) const {
  RayFrame f;
  f.dir = ray.dir;
  const dvec3 to_middle = middle - ray.org;
  f.t_shift = glm::dot(to_middle, ray.dir);
  f.org = ray.dir * f.t_shift - to_middle;
  // Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
  const dvec3 n = ray.dir;
  const double sign = std::copysign(1.0, n.z), a = -1.0 / (sign + n.z), b = n.x * n.y * a;
  f.e1 = {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  f.e2 = {b, sign + n.y * n.y * a, -n.y};
  return f;
}

int EdgePaths::crossings(std::int32_t local_edge, const RayFrame& f) const {
  const PathEdge& edge = edges[local_edge];
  if (edge.joint_count < 2) return 0;

  // The box decides for nearly every edge.
  const dvec2 c = f.project(edge.center);
  const double slack = 1e-15 * (diagonal + std::abs(c.x) + std::abs(c.y));
  const double ry = glm::dot(glm::abs(f.e2), edge.half) + slack;
  if (c.y > ry || c.y < -ry) return 0;
  const double rx = glm::dot(glm::abs(f.e1), edge.half) + slack;
  if (c.x < -rx) return 0;
  const dvec3* joint = &joints[edge.joint];
  const auto side = [&](std::int32_t j) { return upper(f.project(joint[j]).y); };
  const std::int32_t last = edge.joint_count - 1;
  if (c.x > rx) return static_cast<int>(side(last)) - static_cast<int>(side(0));

  if (edge.piece_count == 0) return line_crossings(f.project(joint[0]), f.project(joint[1]));
  dvec2 from = f.project(joint[1]);
  int sum = line_crossings(f.project(joint[0]), from);
  for (std::int32_t p = 0; p < edge.piece_count; ++p) {
    const dvec2 to = f.project(joint[p + 2]);
    sum += piece_crossings(*this, pieces[edge.piece + p], from, to, f);
    from = to;
  }
  return sum + line_crossings(from, f.project(joint[last]));
}

int EdgePaths::side(std::int32_t local_edge, std::int32_t piece_index, double s, const RayFrame& f) const {
  const PathEdge& edge = edges[local_edge];
  const PathPiece& piece = pieces[piece_index];
  const std::span<const dvec4> ctrl(&ctrl_h[piece.ctrl], static_cast<std::size_t>(piece.degree) + 1);
  const auto at = [&](double t) {
    const dvec4 h = nurbs::evaluate_bezier<dvec4>(ctrl, t);
    return f.project(dvec3(h) / h.w);
  };
  // The direction of the path there, from a chord that is short but far above rounding.
  constexpr double kChord = 1e-5;
  const double s0 = std::max(s - kChord, 0.0), s1 = std::min(s + kChord, 1.0);
  const dvec2 chord = at(s1) - at(s0);
  const double length = glm::length(chord), step = length / (s1 - s0);  // per unit of s
  const double near = 1e-9 * diagonal;
  if (!(step > 1e-4 * diagonal)) return 0;
  const dvec2 left = dvec2(-chord.y, chord.x) / length;
  const double aside = -glm::dot(at(s), left);
  if (std::abs(aside) > near) return aside > 0.0 ? 1 : -1;

  // So close, rounding decides, and it must decide as crossings() does: does the piece cross the half-line as
  // often as one that makes a detour round the ray on the left?
  const double h = 1e3 * near / step;
  if (s - h <= 0.0 || s + h >= 1.0) return 0;
  const dvec3* joint = &joints[edge.joint];
  const std::int32_t p = piece_index - edge.piece;
  const dvec2 from = f.project(joint[p + 1]), to = f.project(joint[p + 2]);
  const dvec2 before = at(s - h), after = at(s + h), detour = 10.0 * near * left;
  int around = line_crossings(before, detour) + line_crossings(detour, after);
  if (piece.degree == 1) {
    around += line_crossings(from, before) + line_crossings(after, to);
  } else {
    double weight;
    const Planar whole = project_piece(ctrl.data(), piece.degree, f, weight);
    const double size = kRounding * diagonal * weight;
    Planar first, last, unused;
    split(whole, piece.degree, s - h, first, unused);
    split(whole, piece.degree, s + h, unused, last);
    around += curve_crossings(first, piece.degree, upper(from.y), upper(before.y), size, 0) +
              curve_crossings(last, piece.degree, upper(after.y), upper(to.y), size, 0);
  }
  // The detour leaves the ray on its right.
  return piece_crossings(*this, piece, from, to, f) == around ? -1 : 1;
}

}  // namespace trimray::trace
