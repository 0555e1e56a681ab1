// Trimmed patches of the faces that have no closed form, cut into leaves, and the nearest point on a leaf.
#pragma once

#include <vector>

#include "core/base/box.h"
#include "core/distance/search.h"
#include "core/nurbs/trim.h"
#include "core/trace/patch_data.h"

namespace trimray::distance {

// A rectangle of one Bezier patch. Lengths relative to the patch's origin.
struct SurfaceLeaf {
  std::int32_t patch = -1, face = kNoFace;
  bool inside = false;  // the whole of it is within the trim loops
  Domain domain;
  dvec3 middle{0.0}, axis[3];    // an orthonormal frame, the last axis along the normal
  dvec3 lower{0.0}, upper{0.0};  // the leaf in it, about the middle; an offset's base
  dvec3 to_u{0.0}, to_v{0.0};    // patch parameters along the tangent plane, about the middle of the domain
  double radius = 0.0;
  HessianBound hessian;  // in the frame; of an offset's base
};

struct SurfaceFoot {
  double distance = kInf;
  dvec3 p{0.0};
  dvec2 uv_face{0.0};
};

// The leaves of one prototype. The store and the trims must outlive it.
class SurfaceLeaves {
 public:
  SurfaceLeaves(const nurbs::NurbsStore& store, const nurbs::TrimIndex& trims)
      : store_(store), trims_(trims) {}

  // Appends the leaves of a face that are not certainly outside of its loops, and their boxes. False where a
  // part of the face has weights or numbers that cannot be searched.
  bool append(std::int32_t face, std::vector<Box3>& boxes);

  std::size_t size() const { return leaves_.size(); }
  const SurfaceLeaf& operator[](std::size_t i) const { return leaves_[i]; }

  // Replaces best by a nearer point of the leaf, where there is one inside of the loops. True when it did.
  // slack: mm, what is nearer by less need not be found.
  bool nearest(std::size_t leaf, const dvec3& q, double slack, SurfaceFoot& best, Workspace& work) const;

  // A point of a face, its loops left aside, at uv_face.
  bool inside(std::int32_t face, dvec2& uv_face) const;

  std::int64_t bytes() const;

 private:
  struct Query;
  bool cut(std::int32_t patch, const Domain& domain, int depth, std::vector<Box3>& boxes);
  bool offer(const SurfaceLeaf& leaf, const trace::Patch& patch, const Foot& foot, bool known_inside,
             const dvec3& q, SurfaceFoot& best) const;
  bool subdivide(const SurfaceLeaf& leaf, const dvec3& q, double slack, SurfaceFoot& best,
                 Workspace& work) const;
  bool examine(const Query& query, const Domain& domain, bool inside, SurfaceFoot& best,
               Workspace& work) const;

  const nurbs::NurbsStore& store_;
  const nurbs::TrimIndex& trims_;
  trace::PatchPool pool_;
  std::vector<Domain> rims_;  // by patch: its part within the face's uv box
  std::vector<SurfaceLeaf> leaves_;
};

}  // namespace trimray::distance
