// The casters that a picture's mode names.
#pragma once

#include <string>

#include "core/trace/caster.h"
#include "raster/seed_buffers.h"

namespace trimray::bind {

// mode: "hybrid", "standard" or "reference"; throws ArgumentError for any other. scene and seeds must outlive
// the caster. seeds: null, or of this camera; only hybrid looks at them.
trace::Caster make_caster(const std::string& mode, const trace::Scene& scene, const view::Camera& camera,
                          const raster::SeedBuffers* seeds);

}  // namespace trimray::bind
