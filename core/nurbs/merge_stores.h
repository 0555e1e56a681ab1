// Several models in one scene.
#pragma once

#include <span>
#include <string>

#include "core/nurbs/store.h"

namespace trimray::nurbs {

// Every prototype, instance and face of the first store, then those of the second, and so on; coordinates
// stay as they are. The stores' own meta is dropped for the one given. Throws ArgumentError when an array
// would be longer than its indices can count.
NurbsStore merge_stores(std::span<const NurbsStore* const> stores, std::string meta);

}  // namespace trimray::nurbs
