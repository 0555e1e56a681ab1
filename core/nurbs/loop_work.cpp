#include "core/nurbs/loop_work.h"

namespace trimray::nurbs {

void shift(CoEdgeWork& c, dvec2 by) {
  for (dvec3& h : c.pieces.ctrl) h += dvec3(h.z * by, 0.0);
  if (c.conic) c.conic->location += dvec3(by, 0.0);
}

void shift(LoopWork& loop, dvec2 by) {
  if (by != dvec2(0.0))
    for (CoEdgeWork& c : loop.coedges) shift(c, by);
}

dvec2 start_uv(const CoEdgeWork& c) { return project(c.pieces.first()); }
dvec2 end_uv(const CoEdgeWork& c) { return project(c.pieces.last()); }

Box2 pieces_box(const Pieces2& pieces) {
  Box2 box;
  for (const CurvePiece& p : pieces.list) {
    box.add(project(pieces.ctrl[p.ctrl.begin]));
    box.add(project(pieces.ctrl[p.ctrl.end - 1]));
  }
  // Halve whatever may still reach out of the box of the points met so far.
  const auto grow = [&](const auto& self, const dvec3* ctrl, int degree, int depth) -> void {
    Box2 hull;
    for (int i = 0; i <= degree; ++i) hull.add(project(ctrl[i]));
    if (box.contains(hull.lower) && box.contains(hull.upper)) return;
    if (depth == 0) return box.add(hull);
    dvec3 left[kMaxDegree + 1], right[kMaxDegree + 1];
    for (int i = 0; i <= degree; ++i) right[i] = ctrl[i];
    for (int i = 0; i <= degree; ++i) {
      left[i] = right[0];
      for (int k = 0; k + i < degree; ++k) right[k] = 0.5 * (right[k] + right[k + 1]);
    }
    box.add(project(right[0]));
    self(self, left, degree, depth - 1);
    self(self, right, degree, depth - 1);
  };
  for (const CurvePiece& p : pieces.list) grow(grow, &pieces.ctrl[p.ctrl.begin], p.ctrl.size() - 1, 10);
  return box;
}

Box2 loop_box(const LoopWork& loop) {
  Box2 box;
  for (const CoEdgeWork& c : loop.coedges) box.add(pieces_box(c.pieces));
  return box;
}

double signed_area(const LoopWork& loop) {
  double area = 0.0;
  if (loop.coedges.empty()) return area;
  const dvec2 origin = start_uv(loop.coedges.front());
  dvec2 last(0.0);
  const auto add = [&](dvec2 p) {
    p -= origin;
    area += 0.5 * (last.x * p.y - last.y * p.x);
    last = p;
  };
  for (const CoEdgeWork& c : loop.coedges)
    for (const CurvePiece& p : c.pieces.list) {
      const int degree = p.ctrl.size() - 1, points = degree == 1 ? 1 : 8;
      add(project(c.pieces.ctrl[p.ctrl.begin]));
      for (int i = 1; i <= points; ++i)
        add(project(bezier_point(&c.pieces.ctrl[p.ctrl.begin], degree, double(i) / points)));
    }
  add(origin);
  return area;
}

}  // namespace trimray::nurbs
