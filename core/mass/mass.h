// Area, volume, centroid and inertia of a model, integrated over the surfaces and trim loops of its store.
#pragma once

#include <vector>

#include "core/mass/face_integrals.h"
#include "core/mass/moments.h"
#include "core/nurbs/store.h"

namespace trimray::mass {

// mm, of density 1. Every error is what the number may be off by: the integration's own, and rounding. What
// p-curves are off their edges is not in it: a face is what its p-curves say.
struct MassProperties {
  // Of all instances, in the world. Only closed shells have a volume; it is negative where a shell is inside
  // out or bounds a cavity.
  double area = 0.0, area_error = 0.0;
  Moments moments;
  // By face, in its prototype, about the prototype's origin; NaN for faces that cannot be drawn.
  std::vector<FaceIntegrals> faces;
  std::vector<dvec3> origins;  // by prototype
  // By shell, in its prototype; NaN for shells that are not closed.
  std::vector<double> shell_volume, shell_volume_error;
  // Faces without an area: they cannot be drawn. Their shells have no volume.
  std::vector<std::int32_t> left_out;
};

// threads: 0 for all cores; the same bits for any number.
MassProperties measure_mass(const nurbs::NurbsStore& store, int threads = 0);

}  // namespace trimray::mass
