// From the store's surfaces to Bezier patches and leaves.
#pragma once

#include <span>

#include "core/trace/patch_data.h"

namespace trimray::trace {

// Appends the patches and leaves of one face, those of its uv_box and margin_mm beyond it.
void append_face(const nurbs::NurbsStore& store, std::int32_t face, double margin_mm,
                 const LeafDetail& detail, PatchPool& pool);

// Appends one patch from its Bernstein control points net[iu * (dv + 1) + iv] in the prototype's coordinates,
// and its leaves. False, and nothing appended, where a weight is not positive.
struct PatchInput {
  std::int32_t face = kNoFace;
  int degree_u = 1, degree_v = 1;
  const dvec4* net = nullptr;
  double offset = 0.0;
  bool reversed = false;
  ParamCurve u, v;
  int parts_u = 1, parts_v = 1;     // leaves in a row, at least
  double flat_mm = kInf;            // leaves are no farther than this from flat
  double sine = LeafDetail{}.sine;  // LeafDetail's
};
bool append_patch(const PatchInput& input, PatchPool& pool);

// a's patches and leaves, then b's.
void append_pool(const PatchPool& b, PatchPool& a);

}  // namespace trimray::trace
