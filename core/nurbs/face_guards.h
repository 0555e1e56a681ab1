// Guards against single damaged faces: one that is drawn as nonsense, or dwarfs all others, is refused
// instead.
#pragma once

#include "core/nurbs/build_face.h"

namespace trimray::nurbs {

// A surface farther from the prototype's edges than this many times their extent is damaged.
inline constexpr double kMaxFar = 1e6;
// Edges that lie off a face's surface by more than this part of the face's own edges' extent do not bound the
// face
// ... unless it is a tiny face of a coarse model: off by no more than kMinLoose of the prototype's extent.
// The worst of real models: 0.002 of a face.
inline constexpr double kMaxLoose = 0.1;
inline constexpr double kMinLoose = 0.005;

// Box of all edges and vertices of a prototype (their control points); empty when there are none.
Box3 edge_extent(const PrototypeWork& prototype);

// kBadSurface for a face whose surface, over its uv box, reaches kMaxFar beyond the extent. An extent without
// size judges nothing.
void refuse_far(FaceWork& face, const Box3& extent);

// kBadTrim for a face whose p-curves stray from its edges by more than kMaxLoose and kMinLoose allow. Needs
// deviation.
void refuse_loose(const PrototypeWork& prototype, FaceWork& face, const Box3& extent);

}  // namespace trimray::nurbs
