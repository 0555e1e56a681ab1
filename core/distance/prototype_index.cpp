#include "core/distance/prototype_index.h"

#include <algorithm>
#include <cmath>

#include "core/base/closest.h"
#include "core/nurbs/project_curve.h"
#include "core/nurbs/surface.h"

namespace trimray::distance {

using nurbs::FaceStatus;
using nurbs::SurfaceKind;

namespace {

double largest(const dvec3& d) { return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}); }

bool finite(const Box3& b) {
  return !b.empty() && std::isfinite(b.lower.x + b.lower.y + b.lower.z) &&
         std::isfinite(b.upper.x + b.upper.y + b.upper.z);
}

// Empties the boxes that are not finite, and those so large or so far out, a billion times the size of the
// median one, that the tolerance of all would suffer: damage, not design.
void drop_absurd(std::initializer_list<std::vector<Box3>*> lists) {
  constexpr double kAbsurd = 1e9;
  std::vector<Box3> sound;
  for (std::vector<Box3>* list : lists)
    for (Box3& b : *list) {
      if (!finite(b)) b = {};
      if (!b.empty()) sound.push_back(b);
    }
  if (sound.empty()) return;
  const auto median = [&](const auto& value) {
    std::vector<double> values;
    for (const Box3& b : sound) values.push_back(value(b));
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  const double limit = kAbsurd * median([](const Box3& b) { return largest(b.extent()); });
  const dvec3 middle(median([](const Box3& b) { return b.center().x; }),
                     median([](const Box3& b) { return b.center().y; }),
                     median([](const Box3& b) { return b.center().z; }));
  if (!(limit > 0.0)) return;
  for (std::vector<Box3>* list : lists)
    for (Box3& b : *list)
      if (!b.empty() && !(largest(b.center() - middle) + largest(b.extent()) <= limit)) b = {};
}

bool orthonormal(const nurbs::Surface& s) {
  constexpr double kNear = 1e-12;
  const auto unit = [](const dvec3& a) { return std::abs(glm::dot(a, a) - 1.0) <= kNear; };
  return unit(s.x_axis) && unit(s.y_axis) && unit(s.z_axis) &&
         std::abs(glm::dot(s.x_axis, s.y_axis)) <= kNear && std::abs(glm::dot(s.y_axis, s.z_axis)) <= kNear &&
         std::abs(glm::dot(s.z_axis, s.x_axis)) <= kNear;
}

// Foot points of the whole surface say all about the face: where it ends, it has edges, or it is closed.
bool has_feet(const nurbs::Face& face, const nurbs::Surface& surface) {
  if (!trace::solves_closed_form(surface.kind) || !orthonormal(surface)) return false;
  if (face.loops.size() > 0) return true;
  constexpr double kAlmost = 1.0 - 1e-9, kTurn = 6.283185307179586;
  const dvec2 extent = face.uv_box.extent();
  if (surface.kind == SurfaceKind::kSphere)
    return extent.x >= kAlmost * kTurn && extent.y >= kAlmost * 0.5 * kTurn;
  return surface.kind == SurfaceKind::kTorus && extent.x >= kAlmost * kTurn && extent.y >= kAlmost * kTurn;
}

}  // namespace

PrototypeIndex::PrototypeIndex(const nurbs::NurbsStore& s, std::int32_t prototype, const nurbs::TrimIndex& t,
                               int threads)
    : store(s),
      trims(t),
      surfaces(s, t),
      edges(s, prototype),
      first_face_(s.prototypes[prototype].faces.begin) {
  const nurbs::Prototype& p = store.prototypes[prototype];
  forms.resize(p.faces.size());
  std::vector<Box3> patch_boxes;
  for (std::int32_t f = p.faces.begin; f < p.faces.end; ++f) append_face(f, patch_boxes);
  triangles = trace::triangle_blocks(store, prototype, threads);

  std::vector<Box3> edge_boxes = edges.boxes();
  std::vector<Box3> closed_boxes;
  for (const trace::ClosedLeaf& leaf : closed_leaves) closed_boxes.push_back(leaf.box);
  drop_absurd({&closed_boxes, &patch_boxes, &triangles.boxes, &edge_boxes});
  std::vector<Primitive> all;
  std::vector<Box3> boxes;
  const auto add = [&](Kind kind, std::size_t index, const Box3& b, std::int32_t face) {
    if (b.empty()) {
      if (face != kNoFace) left_out.push_back(face);
      return;
    }
    all.push_back({kind, static_cast<std::int32_t>(index)}), boxes.push_back(b), box.add(b);
  };
  for (std::size_t i = 0; i < closed_leaves.size(); ++i)
    add(Kind::kClosed, i, closed_boxes[i], closed_leaves[i].face);
  for (std::size_t i = 0; i < surfaces.size(); ++i) add(Kind::kPatch, i, patch_boxes[i], surfaces[i].face);
  for (std::size_t i = 0; i < triangles.blocks.size(); ++i)
    add(Kind::kTriangles, i, triangles.boxes[i], triangles.faces[i]);
  for (std::size_t i = 0; i < edge_boxes.size(); ++i) add(Kind::kEdge, i, edge_boxes[i], kNoFace);
  bvh = trace::build_bvh(boxes);
  for (const std::int32_t old : trace::renumber_primitives(bvh)) primitives.push_back(all[old]);
  edge_bvh = trace::build_bvh(edge_boxes);
  std::sort(left_out.begin(), left_out.end());
  left_out.erase(std::unique(left_out.begin(), left_out.end()), left_out.end());
}

void PrototypeIndex::append_face(std::int32_t index, std::vector<Box3>& patch_boxes) {
  const nurbs::Face& face = store.faces[index];
  if (face.is_mesh() && face.status == FaceStatus::kOk) return;
  if (face.status != FaceStatus::kOk || face.surface < 0 || face.uv_box.empty() ||
      !std::isfinite(face.uv_box.diagonal())) {
    left_out.push_back(index);
    return;
  }
  const nurbs::Surface& surface = store.surfaces[face.surface];
  if (has_feet(face, surface)) {
    forms[index - first_face_] = trace::make_closed_form(surface, face.uv_box, 0.0);
    trace::append_closed_leaves(store, trims, index, forms[index - first_face_],
                                store.prototypes[face.prototype].bounds.diagonal(), {}, closed_leaves);
  } else if (!surfaces.append(index, patch_boxes)) {
    left_out.push_back(index);
  }
}

void PrototypeIndex::search(const dvec3& q, double slack, bool edges_only, LocalNearest& best,
                            Workspace& work) const {
  if (edges_only) {
    visit_nearest(
        edge_bvh, q, [&] { return best.edge.distance; },
        [&](std::int32_t leaf) { edges.nearest(leaf, q, slack, best.edge, work); });
    return;
  }
  visit_nearest(
      bvh, q, [&] { return best.distance() + slack; },
      [&](std::int32_t primitive) { visit(primitives[primitive], q, slack, best, work); });
}

void PrototypeIndex::visit(const Primitive& primitive, const dvec3& q, double slack, LocalNearest& best,
                           Workspace& work) const {
  switch (primitive.kind) {
    case Kind::kClosed:
      return visit_closed(closed_leaves[primitive.index], q, best);
    case Kind::kTriangles:
      return visit_triangles(primitive.index, q, best);
    case Kind::kEdge:
      return visit_edge(primitive.index, q, slack, best, work);
    case Kind::kPatch:
      SurfaceFoot foot = best.face;
      foot.distance = best.distance();
      if (surfaces.nearest(primitive.index, q, slack, foot, work))
        best.face = foot, best.face_index = surfaces[primitive.index].face;
  }
}

void PrototypeIndex::visit_closed(const trace::ClosedLeaf& leaf, const dvec3& q, LocalNearest& best) const {
  const trace::ClosedForm& form = forms[leaf.face - first_face_];
  ClosedFoot feet[2];
  const int count = closed_feet(form, q, feet);
  for (int k = 0; k < count; ++k) {
    const double distance = glm::distance(feet[k].p, q);
    if (!(distance < best.distance())) continue;
    dvec2 uv = trims.wrap(leaf.face, feet[k].uv);
    // Every foot belongs to one leaf, or to two where they meet.
    if (!leaf.uv.contains(uv)) continue;
    if (!(leaf.inside && leaf.core.contains(uv)) && !surfaces.inside(leaf.face, uv)) continue;
    best.face = {distance, feet[k].p, uv}, best.face_index = leaf.face;
  }
}

void PrototypeIndex::visit_triangles(std::size_t index, const dvec3& q, LocalNearest& best) const {
  const trace::TriangleBlock& block = triangles.blocks[index];
  for (int i = 0; i < block.count; ++i) {
    dvec3 c[3];
    for (int k = 0; k < 3; ++k) c[k] = {block.corner[k][0][i], block.corner[k][1][i], block.corner[k][2][i]};
    const TrianglePoint t = closest_on_triangle(q, c[0], c[1], c[2]);
    const double distance = glm::distance(t.p, q);
    if (!(distance < best.distance())) continue;
    best.face = {distance, t.p, {t.weight_b, t.weight_c}}, best.face_index = triangles.faces[index];
  }
}

void PrototypeIndex::visit_edge(std::size_t leaf, const dvec3& q, double slack, LocalNearest& best,
                                Workspace& work) const {
  EdgeFoot foot = best.edge;
  foot.distance = std::min(foot.distance, best.face.distance + slack);
  if (edges.nearest(leaf, q, slack, foot, work)) best.edge = foot;
}

void PrototypeIndex::place_on_face(const EdgeFoot& foot, std::int32_t& face, dvec2& uv) const {
  const nurbs::Edge& edge = store.edges[foot.edge];
  const nurbs::CoEdge* use = nullptr;
  for (std::int32_t i = edge.coedges.begin; i < edge.coedges.end; ++i) {
    const nurbs::CoEdge& c = store.coedges[store.edge_coedges[i]];
    if (store.faces[c.face].status == FaceStatus::kOk && (use == nullptr || c.face < use->face)) use = &c;
  }
  if (use == nullptr) return;
  face = use->face;
  if (use->pieces.size() == 0) return;
  // The p-curve's piece that covers t; its pieces run as the loop does, so their t may fall.
  const nurbs::CurvePiece* piece = &store.trim_pieces[use->pieces.begin];
  double nearest = kInf;
  for (std::int32_t i = use->pieces.begin; i < use->pieces.end; ++i) {
    const nurbs::CurvePiece& c = store.trim_pieces[i];
    const double out = std::max({std::min(c.t0, c.t1) - foot.t, foot.t - std::max(c.t0, c.t1), 0.0});
    if (out < nearest) nearest = out, piece = &c;
  }
  const double length = piece->t1 - piece->t0;
  const double x = length != 0.0 ? std::clamp((foot.t - piece->t0) / length, 0.0, 1.0) : 0.0;
  uv = nurbs::project(
      nurbs::bezier_point(store.trim_ctrl_h.data() + piece->ctrl.begin, piece->ctrl.size() - 1, x));
  const nurbs::SurfaceView surface = nurbs::view(store, store.surfaces[store.faces[face].surface]);
  if (edge.degenerate) return;
  const dvec2 polished = nurbs::closest_uv(surface, foot.p, uv);
  if (glm::distance(nurbs::evaluate_point(surface, polished), foot.p) <
      glm::distance(nurbs::evaluate_point(surface, uv), foot.p))
    uv = polished;
}

}  // namespace trimray::distance
