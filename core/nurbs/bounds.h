// Boxes around surfaces and faces.
#pragma once

#include "core/nurbs/surface_form.h"

namespace trimray::nurbs {

// Conservative box of the surface over a uv box: control hull of the part, the offset included. uv_face must be
// inside the domain or close to it.
Box3 hull_bounds(const SurfaceView& view, const Box2& uv_face);

}  // namespace trimray::nurbs
