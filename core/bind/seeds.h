// Seeds as Python holds them.
#pragma once

#include "raster/seed_buffers.h"

namespace trimray::bind {

struct Seeds {
  raster::SeedBuffers buffers;
};

}  // namespace trimray::bind
