// Faces that the B-rep gives as triangles.
#pragma once

#include "core/nurbs/build_face.h"

namespace trimray::nurbs {

// Has the face a triangulation and no surface?
bool is_mesh_face(const brep::Model& model, const WalkFace& face);

// Its triangles in their place, counter-clockwise seen from outside. kBadSurface when a node is not finite.
FaceWork build_mesh_face(const brep::Model& model, const Walk& walk, const WalkFace& face);

// Throws FormatError when the mesh faces together have more triangles or nodes than any real model: a
// triangulation that is used over and over again.
void check_mesh_size(const brep::Model& model, std::span<const PrototypeWork> prototypes);

}  // namespace trimray::nurbs
