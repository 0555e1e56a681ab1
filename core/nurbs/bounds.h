// Boxes around surfaces and faces.
#pragma once

#include "core/nurbs/surface_form.h"
#include "core/nurbs/trim.h"

namespace trimray::nurbs {

// Conservative box of the surface over a uv box: control hull of the part, the offset included. uv_face must
// be inside the domain or close to it.
Box3 hull_bounds(const SurfaceView& view, const Box2& uv_face);

// Box of a face after a placement, tight to kBoundsTol of its size: every bound is reached by a point of the
// face or of its edges up to that. Empty for a face that cannot be drawn. Offset surfaces: from samples,
// tight to about 1e-3.
inline constexpr double kBoundsTol = 1e-7;
Box3 face_bounds(const NurbsStore& store, const TrimIndex& trims, std::int32_t face,
                 const Transform& placement = {});

// All instances of the model in the world; in parallel.
Box3 model_bounds(const NurbsStore& store, const TrimIndex& trims, int threads = 0);

}  // namespace trimray::nurbs
