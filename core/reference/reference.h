// The slow and simple tracer that judges the fast one. It shares nothing with core/trace but the store's
// arrays and the definitions of Ray and Hit: it evaluates surfaces by itself (de Boor in double), finds
// all roots by recursive subdivision of control hulls, with no hierarchy over faces, and decides trims
// by its own winding computation. About a thousand times slower.
#pragma once

#include <span>
#include <vector>

#include "core/nurbs/store.h"
#include "core/trace/ray.h"

namespace trimray::reference {

void cast(const nurbs::NurbsStore& store, std::span<const trace::Ray> rays, std::span<trace::Hit> out,
          int threads = 0);
void cast_all(const nurbs::NurbsStore& store, const trace::Ray& ray, std::vector<trace::Hit>& out);

}  // namespace trimray::reference
