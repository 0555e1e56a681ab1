// The exact NURBS form of as much of a surface as a face needs.
#pragma once

#include "core/nurbs/surface_source.h"

namespace trimray::nurbs {

// The source with its exact NURBS form over (about) uv_box plus a margin. False when there is none: a uv_box
// that is empty, not finite or off the surface, or a curve without exact form. Does not change the source's
// status.
bool surface_over(const brep::Model& model, const SurfaceSource& source, const Box2& uv_box,
                  SurfaceForm& out);

}  // namespace trimray::nurbs
