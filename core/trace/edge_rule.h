// Trimming without cracks: near an edge, both of its faces decide by the one shared 3D edge path.
//
// The theory. Project everything along the ray onto a plane; the ray becomes a point. The signed number of
// times the ray crosses a face (leaving minus entering) equals the winding number of the face's projected
// boundary about that point. The boundary that counts is made of the shared edge paths (store.h), not of
// the p-curves: each path is crossed by a fixed half-line from the point k times, k computed once from the
// path and the ray alone, and a face's winding number is the sum of +-k over its co-edges. A closed shell
// uses every path once in each direction, so the sum over its faces is zero whatever the rounding: the number
// of hits on a closed solid is even by construction.
// A ray that keeps farther than an edge's band from its path sees the p-curves and the paths alike, so the
// cheap uv test decides. Only a ray within the band of some edge pays for the winding numbers of that
// edge's faces, and its roots on these faces are made to agree with them.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/nurbs/store.h"
#include "core/trace/ray.h"

namespace trimray::trace {

// A place where a ray passes an edge's path within the edge's band.
struct NearEdge {
  std::int32_t edge = -1;
  double t = 0.0;         // of the closest approach, along the ray
  double distance = 0.0;  // from the ray to the path there
  double edge_t = 0.0;    // the edge's own parameter there
  // Seen with dir towards the eye, the ray passes to the left (+1) or right (-1) of the path; 0 where that
  // cannot be said (at the path's ends, or along the ray). Agrees with winding() to the last bit.
  std::int8_t side = 0;
};

// Keeps a reference to the store, which must outlive it. Throws ArgumentError for an edge of degree above 63.
class EdgeRule {
 public:
  EdgeRule(const nurbs::NurbsStore& store, std::int32_t prototype);
  EdgeRule(EdgeRule&&) noexcept;
  EdgeRule& operator=(EdgeRule&&) noexcept;
  ~EdgeRule();

  // All places where the ray's line, for t in [tmin, tmax], comes within the band of an edge path.
  // Appends to out. The ray is in the prototype's coordinates, dir of unit length.
  void near_edges(const Ray& ray, std::vector<NearEdge>& out) const;

  // False only if near_edges would find nothing. Cheaper, and it stores nothing.
  bool may_be_near(const Ray& ray) const;

  // Signed crossings of the face's boundary winding about the ray's whole line: leaving minus entering.
  int winding(const Ray& ray, std::int32_t face) const;

  // Makes the roots of one face, all those on the whole line, agree with its winding number: drops roots that
  // the p-curves let in by mistake, admits roots just outside, or, where the surface gives none, puts
  // a hit on the edge path itself. near: this ray's near edges (of any face). On return every kept root has
  // inside = true and they are sorted by t.
  void resolve(const Ray& ray, std::int32_t face, std::span<const NearEdge> near,
               std::vector<Root>& roots) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trimray::trace
