// From the B-rep's surfaces to SurfaceForms: what a surface is, before it is known how much of it a face
// needs.
#pragma once

#include "core/brep/topology.h"
#include "core/nurbs/surface_form.h"

namespace trimray::nurbs {

// A surface of the stream, its trimmed and offset wrappings taken off, put in its place.
struct SurfaceSource {
  FaceStatus status = FaceStatus::kOk;
  SurfaceForm form;                             // kind, frame, periods, offset; no NURBS yet
  const brep::Surface* definition = nullptr;    // the basis surface in the stream
  SurfaceKind basis_kind = SurfaceKind::kNone;  // the kind whose NURBS form is built
  bool transformed = false;  // the NURBS form is built in the stream's place and then moved
  Transform placement;
  // Where the surface is defined; infinite along lines, a period's width where periodic.
  Box2 natural;
};

SurfaceSource read_surface(const brep::Model& model, std::int32_t index, const Transform& placement);

// The source with its exact NURBS form over (about) uv_box plus a margin. False when there is none: a uv_box
// that is empty, not finite or off the surface, or a curve without exact form. Does not change the source's
// status.
bool surface_over(const brep::Model& model, const SurfaceSource& source, const Box2& uv_box,
                  SurfaceForm& out);

}  // namespace trimray::nurbs
