// The trim loops of a face as curves that are monotone in u and in v and stay within a cell.
#pragma once

#include <vector>

#include "core/mass/surface_row.h"
#include "core/nurbs/store.h"

namespace trimray::mass {

// A stretch of a loop, in the loop's direction. Neighbours share their ends, bit for bit; an end on a line of
// the cells is exactly on it.
struct LoopPiece {
  dvec2 from{0.0}, to{0.0};
  std::int32_t ctrl = 0;  // LoopPieces::ctrl_h; lines have none
  std::int32_t degree = 1;
  std::int32_t loop = 0;
};

struct LoopPieces {
  std::vector<LoopPiece> pieces;  // loop by loop, but those of constant v
  std::vector<dvec3> ctrl_h;      // (w u, w v, w)
  int loops = 0;
};

// The box of a face's loops, or its uv_box where there are none.
Box2 loops_box(const nurbs::NurbsStore& store, const nurbs::Face& face);

// All of it, and the cells, from `origin`: where coordinates are large, their differences would lose digits.
LoopPieces cut_loops(const nurbs::NurbsStore& store, const nurbs::Face& face, const SmoothCells& cells,
                     dvec2 origin);

// By loop: 1 or -1, so that the signed regions times these, added up, count every point inside once: as the
// loops run where one runs against all the others, else by the even-odd rule for loops that do not cross.
std::vector<double> loop_signs(const LoopPieces& loops);

}  // namespace trimray::mass
