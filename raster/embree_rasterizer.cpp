#include "core/base/error.h"
#include "raster/backends.h"
namespace trimray::raster {
std::unique_ptr<Rasterizer> make_embree_rasterizer() { throw Error("not built"); }
std::string embree_version() { return {}; }
}  // namespace trimray::raster
