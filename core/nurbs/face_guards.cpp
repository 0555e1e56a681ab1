#include "core/nurbs/face_guards.h"

#include <algorithm>

namespace trimray::nurbs {
namespace {

void add_path(Box3& box, const Pieces3& path) {
  for (const dvec4& h : path.ctrl) box.add(project(h));
}

}  // namespace

Box3 edge_extent(const PrototypeWork& prototype) {
  Box3 box;
  for (const EdgeWork& e : prototype.edges)
    if (pieces_sound(e.path)) add_path(box, e.path);
  for (const WalkVertex& v : prototype.walk.vertices)
    if (glm::length(v.point) < kMaxCoordinate) box.add(v.point);
  return box;
}

void refuse_far(FaceWork& face, const Box3& extent) {
  if (face.status != FaceStatus::kOk) return;
  const double size = face.bounds.diagonal();
  if (!(size < kMaxCoordinate)) return refuse(face, FaceStatus::kBadSurface);
  if (extent.empty() || !(extent.diagonal() > 0.0)) return;
  Box3 both = extent;
  both.add(face.bounds);
  if (!(both.diagonal() <= kMaxFar * extent.diagonal())) refuse(face, FaceStatus::kBadSurface);
}

void refuse_loose(const PrototypeWork& prototype, FaceWork& face, const Box3& extent) {
  if (face.status != FaceStatus::kOk || extent.empty()) return;
  Box3 own;
  for (const LoopWork& loop : face.loops.loops)
    for (const CoEdgeWork& c : loop.coedges)
      add_path(own, c.edge >= 0 ? prototype.edges[c.edge].path : face.loops.synthetic[-1 - c.edge].path);
  if (own.empty()) return;
  const double worst =
      face.deviation.empty() ? 0.0 : *std::max_element(face.deviation.begin(), face.deviation.end());
  if (worst > kMaxLoose * own.diagonal() && worst > kMinLoose * extent.diagonal())
    refuse(face, FaceStatus::kBadTrim);
}

}  // namespace trimray::nurbs
