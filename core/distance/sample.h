// Points spread evenly over the faces and edges of a model, the same ones for the same seed.
#pragma once

#include <cstdint>
#include <vector>

#include "core/nurbs/store.h"

namespace trimray::distance {

struct SampleOptions {
  int count = 16;  // points a face or edge, of every instance
  std::uint64_t seed = 0;
  int threads = 0;  // the points do not depend on it
};

// In the world, by instance, then by face; all arrays have one length.
struct FaceSamples {
  std::vector<dvec3> point, normal;  // mm; outward, unit
  std::vector<dvec2> uv_face;
  std::vector<std::int32_t> face, instance;
};

// Points inside of each face's loops, independent of one another and distributed evenly by area. Faces that
// cannot be drawn, or whose inside is not found in a bounded number of attempts (it is empty, or nearly),
// have fewer or none.
FaceSamples sample_faces(const nurbs::NurbsStore& store, const SampleOptions& options);

struct EdgeSamples {
  std::vector<dvec3> point;
  std::vector<std::int32_t> edge, instance;
};

// Points of the paths of all edges that a face which can be drawn uses: one in each of `count` stretches of
// equal length (to about 1 %), anywhere in it. An edge without length has one point.
EdgeSamples sample_edges(const nurbs::NurbsStore& store, const SampleOptions& options);

}  // namespace trimray::distance
