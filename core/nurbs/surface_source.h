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

}  // namespace trimray::nurbs
