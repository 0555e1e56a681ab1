// The triangles of mesh faces, cut into blocks of neighbours: the leaves of the hierarchy.
#pragma once

#include <vector>

#include "core/base/box.h"
#include "core/nurbs/store.h"
#include "core/trace/triangle.h"

namespace trimray::trace {

struct TriangleBlocks {
  std::vector<TriangleBlock> blocks;
  std::vector<Box3> boxes;          // as blocks
  std::vector<std::int32_t> faces;  // as blocks: a block belongs to one face
  std::int64_t bytes() const { return static_cast<std::int64_t>(blocks.size() * sizeof(TriangleBlock)); }
};

// Of one prototype's mesh faces, in the order of the faces. Triangles with two corners at the same place,
// which no ray meets, are left out. The same blocks for any number of threads.
TriangleBlocks triangle_blocks(const nurbs::NurbsStore& store, std::int32_t prototype, int threads);

}  // namespace trimray::trace
