// Loops of p-curves while a face is built: what they hold, and how to move and measure them.
#pragma once

#include <optional>
#include <vector>

#include "core/nurbs/curve_form.h"

namespace trimray::nurbs {

struct CoEdgeWork {
  std::int32_t edge = -1;  // WalkEdge; -1 - i: synthetic edge i of this face
  bool reversed = false, seam = false;
  Pieces2 pieces;              // in loop direction
  std::optional<Conic> conic;  // the p-curve's formula, where it has one
};

struct LoopWork {
  std::vector<CoEdgeWork> coedges;
};

// Ends of a p-curve.
dvec2 start_uv(const CoEdgeWork& c);
dvec2 end_uv(const CoEdgeWork& c);
// Moves a loop in uv_face.
void shift(CoEdgeWork& c, dvec2 by);
void shift(LoopWork& loop, dvec2 by);
// Box of the pieces: their control hulls after a few halvings.
Box2 pieces_box(const Pieces2& pieces);
Box2 loop_box(const LoopWork& loop);
// Area to the left of the closed polyline through the loop, 8 points a curved piece.
double signed_area(const LoopWork& loop);

}  // namespace trimray::nurbs
