// The parts of build_store that work on one edge or one face alone, so that they can run on all cores.
#pragma once

#include "core/nurbs/face_loops.h"
#include "core/nurbs/shape_walk.h"

namespace trimray::nurbs {

struct EdgeWork {
  Pieces3 path;  // in the edge's own direction; empty when degenerate or not yet known
  bool degenerate = false, smooth = false;
  double tolerance = 0.0, first = 0.0, last = 0.0;
  std::optional<Conic> conic;  // the path's formula, where it has one
};

struct FaceWork {
  FaceStatus status = FaceStatus::kOk;
  bool reversed = false;      // the located surface's Su x Sv points inward
  bool closed_alone = false;  // no loops, and the natural domain closes up (sphere, torus)
  SurfaceForm form;
  FaceLoops loops;
  std::vector<dvec3> mesh_vertices;      // mesh faces only ...
  std::vector<Triangle> mesh_triangles;  // ... into mesh_vertices
  Box3 bounds;
  // Per co-edge, in loop order: how far its p-curve and the link to the next one stray from the edge's path.
  std::vector<double> deviation;
};

struct PrototypeWork {
  Walk walk;
  std::vector<EdgeWork> edges;  // as walk.edges
  std::vector<FaceWork> faces;  // as walk.faces
};

Transform operator*(const Transform& a, const Transform& b);

// The exact path in space, from the edge's 3D curve.
EdgeWork build_edge(const brep::Model& model, const Walk& walk, const WalkEdge& edge);

// Surface, loops, uv box and bounds. Faces never throw; they have a status.
FaceWork build_face(const brep::Model& model, const PrototypeWork& prototype, const WalkFace& face);

// For an edge without 3D curve: its p-curve's image on the face's surface.
Pieces3 path_from_face(const FaceWork& face, const CoEdgeWork& coedge, double tolerance);

// Takes from a face all that would be drawn.
void refuse(FaceWork& face, FaceStatus status);

// Fills face.deviation. tiny: a distance (mm) that needs no closer look.
void measure_deviation(const PrototypeWork& prototype, FaceWork& face, double tiny);

}  // namespace trimray::nurbs
