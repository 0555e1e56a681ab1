// The faces that have a closed form, cut into cells of their uv box with tight boxes for the hierarchy.
#pragma once

#include <vector>

#include "core/nurbs/trim.h"
#include "core/trace/closed_form.h"
#include "core/trace/patch.h"

namespace trimray::trace {

struct ClosedLeaf {
  Box3 box;   // conservative, of `uv`
  Box2 uv;    // the cell, widened by rounding: roots outside of it belong to another leaf
  Box2 core;  // the cell itself
  std::int32_t face = kNoFace;
  bool inside = false;  // the whole core is inside the trim loops
};

// Appends the cells of one face that are not certainly outside of its loops. Cells shrink until an arc spans
// at most a right angle, and further while that drops empty area or makes the boxes hug the surface.
// model_diagonal: sets the size below which it is not worth it.
void append_closed_leaves(const nurbs::NurbsStore& store, const nurbs::TrimIndex& trim, std::int32_t face,
                          const ClosedForm& form, double model_diagonal, const LeafDetail& detail,
                          std::vector<ClosedLeaf>& out);

}  // namespace trimray::trace
