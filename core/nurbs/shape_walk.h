// The graph of shapes under a root, unfolded: every face, edge and vertex once per place where it stands.
#pragma once

#include <vector>

#include "core/brep/topology.h"
#include "core/nurbs/store.h"

namespace trimray::nurbs {

struct WalkVertex {
  std::int32_t shape = -1, transform = -1;
  dvec3 point{0.0};  // in the prototype's coordinates
  double tolerance = 0.0;
};

struct WalkEdge {
  std::int32_t shape = -1, transform = -1;
  std::int32_t vertex[2] = {-1, -1};  // at the curve's first and last parameter; -1 when the stream has none
};

struct EdgeUse {
  std::int32_t edge = -1;
  bool reversed = false;  // edge in wire and wire in face taken together
};

struct WalkFace {
  std::int32_t shape = -1, transform = -1;
  std::int32_t shell = -1;
  bool reversed = false;
  std::vector<std::vector<EdgeUse>> wires;  // without internal and external uses
};

struct WalkShell {
  Range faces;              // into Walk::faces
  std::int32_t solid = -1;  // number of its solid, -1: of none
  bool lone = false;        // made up for a face that is in no shell
};

struct Walk {
  std::vector<Transform> transforms;  // [0] is the identity
  std::vector<WalkFace> faces;        // in depth-first order; those of one shell stand together
  std::vector<WalkEdge> edges;
  std::vector<WalkVertex> vertices;
  std::vector<WalkShell> shells;
};

// Throws FormatError when the graph unfolds to more uses than any real model has, or nests too deep.
Walk walk_shape(const brep::Model& model, std::int32_t root);

}  // namespace trimray::nurbs
