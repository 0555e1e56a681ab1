// How far a mesh is from its exact surfaces, measured at many points: the judge of the proven bounds, with
// which it shares nothing but the evaluation of surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "core/nurbs/store.h"
#include "core/tess/tri_mesh.h"

namespace trimray::tess {

struct MeasureOptions {
  int subdivisions = 6;             // of a triangle's sides: (n + 1)(n + 2) / 2 points a triangle
  std::int64_t most_triangles = 0;  // a random choice of about so many; 0: all
  std::uint64_t seed = 1;
  int threads = 0;  // 0: all cores; the same numbers for any
};

// By triangle, mm. Never more than the true distances by more than rounding. NaN: not chosen, a mesh face, or
// a face that cannot be evaluated.
struct DeviationMeasure {
  // Largest distance found of a point of the triangle from the face's (untrimmed) surface.
  std::vector<double> to_surface;
  // Largest distance found of the surface's point at the same place in uv from the face's triangles: from
  // this one where that is within mesh.deviation[i], else from the nearest of all.
  std::vector<double> from_surface;
};

// mesh.deviation may be empty: every distance is then looked at closely. Throws ArgumentError for a mesh that
// does not fit the store.
DeviationMeasure measure_deviation(const nurbs::NurbsStore& store, const TriMesh& mesh,
                                   const MeasureOptions& options = {});

// By face of the store: signed area of its triangles in uv_face, and how many are turned over there (against
// the face's orientation) or without area.
struct FaceCover {
  double uv_area = 0.0;
  std::int64_t triangles = 0, turned_over = 0;
};
std::vector<FaceCover> measure_cover(const nurbs::NurbsStore& store, const TriMesh& mesh);

// Throws ArgumentError unless every array has one entry a triangle and every index exists.
void check_mesh_fits(const nurbs::NurbsStore& store, const TriMesh& mesh);

}  // namespace trimray::tess
