// What a query of core/distance answers, and how far it may look.
#pragma once

#include <cstdint>

#include "core/base/types.h"

namespace trimray::distance {

// The nearest point of a trimmed model. A face ends at its edges: what counts are the points of its surface
// inside of its trim loops and the points of its edges' shared paths (store.h), the same ones for all faces
// of an edge. The images of p-curves count for nothing; they are within the edge's band of the path.
struct Nearest {
  double distance = kInf;  // mm; kInf where there is nothing, or the query is not finite
  dvec3 point{0.0};        // world
  std::int32_t face = kNoFace, instance = -1;
  std::int32_t edge = -1;  // NurbsStore::edges where the point lies on an edge's path; face is then the first
                           // face with that edge
  dvec2 uv_face{0.0};      // on an edge: of its p-curve on the face, brought nearest to the point
  double band = 0.0;       // mm: Edge::band of the edge; how far off its faces may take their end to be
  double gap = 0.0;        // mm: no point of the model is nearer than distance - gap. 0 unless the search was
                           // given up, see kMaxParts
};

// Accuracy of Nearest::distance, as a fraction of the model's diagonal, where gap is 0.
inline constexpr double kDistanceTol = 1e-12;

// Parts of patches and curves that one query halves before it gives up; patches of high degrees count more.
// Only points that are equally far from a whole region of a surface come near it, as the axis of a nearly
// round tube is.
inline constexpr int kMaxParts = 20000;

}  // namespace trimray::distance
