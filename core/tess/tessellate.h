// From exact trimmed surfaces to a watertight mesh of them.
#pragma once

#include <string>
#include <vector>

#include "core/nurbs/store.h"
#include "core/tess/tolerance_field.h"
#include "core/tess/tri_mesh.h"

namespace trimray::tess {

struct TessOptions {
  double angle = kInf;  // rad: largest turn of the normal along a triangle's side; kInf: deviation alone
  int threads = 0;      // 0: all cores. The same bytes for any number.
};

// A face whose loops could not be triangulated as they are; the mesh covers it by other means, and its
// triangles' deviation is not proven.
struct TessIssue {
  std::int32_t face = kNoFace;
  std::string reason;
};

struct Tessellation {
  TriMesh mesh;  // of the prototype, in its coordinates
  std::vector<TessIssue> issues;
};

// The mesh of one prototype. Faces that cannot be drawn (FaceStatus) have no triangles and no issue; mesh
// faces give their own triangles. Every triangle's deviation is at most
// tolerance.at(its box); excepted are those of the faces in `issues`, and those whose corners stand on edges
// that the file itself puts farther from the face. Where the surfaces' shell is closed so is the mesh: every
// side of a triangle is the side of exactly one other, turned round.
Tessellation tessellate(const nurbs::NurbsStore& store, std::int32_t prototype,
                        const ToleranceField& tolerance, const TessOptions& options = {});

}  // namespace trimray::tess
