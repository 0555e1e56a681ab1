// Every root of lines that graze a leaf, a line a lane: what PatchSet::solve leaves open.
//
// The leaf's control net is projected along each lane's line, and halved until each part is certain: its hull
// lies on one side of a line through the origin (no root), or no tangents of the part are parallel across the
// line (at most one root, which Newton finds). A part that stays uncertain goes to clip_roots.
#pragma once

#include <vector>

#include "core/trace/newton.h"
#include "core/trace/patch_data.h"

namespace trimray::trace {

struct LanePatchRoot {
  int lane = 0;
  PatchRoot root;
};

// Counters of one call.
struct OpenStats {
  int parts = 0;      // examined, all lanes of one part together
  int searched = 0;   // parts that went to clip_roots
  int exhausted = 0;  // lanes whose search was given up: roots may be missing
  std::uint32_t steps = 0;
};

// Appends the roots of the active lanes on the leaf, as clip_roots finds them, a lane's roots in no
// particular order. What a lane gets does not depend on the others. Not for offset patches.
OpenStats open_lane_roots(const Patch& patch, const PatchPool& pool, const LeafBound& leaf,
                          const RayLanes& rays, std::vector<LanePatchRoot>& roots);

}  // namespace trimray::trace
