// A line against the triangles of a mesh face, one after the other.
#pragma once

#include <vector>

#include "core/reference/line.h"

namespace trimray::reference {

// Appends every crossing of the whole line with the face's triangles, t in unit direction. A triangle is
// crossed when its boundary winds around the line; sides that two triangles share are judged alike, so that a
// line meets the triangles around an edge or a corner as if it passed beside it.
void mesh_roots(const nurbs::NurbsStore& store, std::int32_t face, const Line& line,
                std::vector<trace::Root>& out);

}  // namespace trimray::reference
