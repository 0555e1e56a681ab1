// Evaluation of a store's surfaces, each from its definition: the closed form for plane ... torus, the NURBS
// form through the parameter map for the others, the offset on top. This is the slow general evaluator;
// the tracer's kernels are in core/trace.
#pragma once

#include "core/nurbs/store.h"

namespace trimray::nurbs {

struct SurfacePoint {
  dvec3 p{0.0}, du{0.0}, dv{0.0};  // with respect to uv_face
};

// uv may lie outside the domain: periodic directions wrap, others continue the last polynomial span.
SurfacePoint evaluate(const NurbsStore& store, const Surface& surface, dvec2 uv_face);

// The same through the NURBS form even where a closed form exists (no offset): the tests compare the two.
SurfacePoint evaluate_nurbs(const NurbsStore& store, const Surface& surface, dvec2 uv_face);

// Parameter of the NURBS form for a uv_face coordinate, and back. Both keep every knot fixed.
double nurbs_from_face(const NurbsStore& store, const Range& knots, ParamMap map, double u);
double face_from_nurbs(const NurbsStore& store, const Range& knots, ParamMap map, double s);

}  // namespace trimray::nurbs
