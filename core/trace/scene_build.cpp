#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/tolerance.h"
#include "core/trace/scene_impl.h"

namespace trimray::trace {

using nurbs::Coverage;
using nurbs::FaceStatus;
using nurbs::NurbsStore;

namespace {

// LeafBoxes::kPaper. The paper's Cornell box of 18 surfaces, all but flat, has 445 boxes, its teapot of 32
// has 13,018; about so many these give.
constexpr LeafDetail kPaperDetail{5, 7.2e-4};

// LeafBoxes::kTuned, of patches. Flatter leaves than one root wants: long bent ones have wide boxes. The rays
// that graze them cost little in full lanes; proofs for them would cost more leaves.
constexpr LeafDetail kTunedDetail{1, 1.5e-3, 0.5};

// Twice the widest band among the face's edges: what the edge rule may still want to admit.
std::vector<double> face_margins(const NurbsStore& store, const nurbs::Prototype& p) {
  const double least = 4.0 * kMinBand * (p.bounds.empty() ? 1.0 : p.bounds.diagonal());
  std::vector<double> margins(p.faces.size(), least);
  for (std::int32_t f = p.faces.begin; f < p.faces.end; ++f) {
    const nurbs::Range& loops = store.faces[f].loops;
    for (std::int32_t l = loops.begin; l < loops.end; ++l)
      for (std::int32_t c = store.loops[l].coedges.begin; c < store.loops[l].coedges.end; ++c) {
        double& margin = margins[f - p.faces.begin];
        margin = std::max(margin, 2.0 * store.edges[store.coedges[c].edge].band);
      }
  }
  return margins;
}

Box3 transformed(const Transform& placement, const Box3& box) {
  Box3 out;
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p{(corner & 1 ? box.upper : box.lower).x, (corner & 2 ? box.upper : box.lower).y,
                  (corner & 4 ? box.upper : box.lower).z};
    out.add(placement.point(p));
  }
  const dvec3 largest = glm::max(glm::abs(out.lower), glm::abs(out.upper));
  out.dilate(1e-14 * std::max({largest.x, largest.y, largest.z}));
  return out;
}

bool finite(const Box3& box) {
  return !box.empty() && !glm::any(glm::isinf(box.lower)) && !glm::any(glm::isinf(box.upper)) &&
         !glm::any(glm::isnan(box.lower)) && !glm::any(glm::isnan(box.upper));
}

}  // namespace

PrototypeScene::PrototypeScene(const NurbsStore& s, std::int32_t prototype, const nurbs::TrimIndex& t,
                               LeafBoxes leaf_boxes, int threads)
    : store(s),
      trim(t),
      first_face(s.prototypes[prototype].faces.begin),
      margin_mm(face_margins(s, s.prototypes[prototype])),
      patches(s, prototype, margin_mm, threads,
              leaf_boxes == LeafBoxes::kPaper ? kPaperDetail : kTunedDetail),
      rule(s, prototype) {
  const nurbs::Prototype& p = store.prototypes[prototype];
  diagonal = p.bounds.diagonal();
  for (const double tolerance : kChordTolerances) sieves.emplace_back(s, prototype, tolerance);
  forms.resize(p.faces.size());
  for (std::int32_t f = p.faces.begin; f < p.faces.end; ++f) {
    const nurbs::Face& face = store.faces[f];
    if (face.status != FaceStatus::kOk || face.surface < 0) continue;
    const nurbs::Surface& surface = store.surfaces[face.surface];
    if (!solves_closed_form(surface.kind)) continue;
    forms[f - first_face] = make_closed_form(surface, face.uv_box, margin_mm[f - first_face]);
    append_closed_leaves(store, trim, f, form(f), diagonal,
                         leaf_boxes == LeafBoxes::kPaper ? kPaperDetail : LeafDetail{}, closed_leaves);
  }

  // Patch leaves that lie outside of the trim loops stay out of the hierarchy; the exact way knows them by
  // face.
  std::vector<Box3> boxes;
  for (std::size_t i = 0; i < closed_leaves.size(); ++i) {
    const ClosedLeaf& leaf = closed_leaves[i];
    primitives.push_back({leaf.face, static_cast<std::int32_t>(i), PrimitiveKind::kClosedForm, leaf.inside});
    boxes.push_back(leaf.box);
  }
  const std::span<const PatchLeaf> leaves = patches.leaves();
  std::vector<Coverage> coverage(leaves.size());
  parallel_ranges(leaves.size(), 256, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) coverage[i] = trim.coverage(leaves[i].face, leaves[i].uv_face);
  });
  leaf_begin.assign(p.faces.size() + 1, 0);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    ++leaf_begin[leaves[i].face - first_face + 1];
    if (coverage[i] == Coverage::kOutside) continue;
    primitives.push_back({leaves[i].face, static_cast<std::int32_t>(i), PrimitiveKind::kPatch,
                          coverage[i] == Coverage::kInside});
    boxes.push_back(leaves[i].box);
  }
  std::partial_sum(leaf_begin.begin(), leaf_begin.end(), leaf_begin.begin());
  leaf_order.resize(leaves.size());
  std::vector<std::int32_t> next = leaf_begin;
  for (std::size_t i = 0; i < leaves.size(); ++i)
    leaf_order[next[leaves[i].face - first_face]++] = static_cast<std::int32_t>(i);

  triangles = triangle_blocks(store, prototype, threads);
  for (std::size_t i = 0; i < triangles.blocks.size(); ++i) {
    primitives.push_back({triangles.faces[i], static_cast<std::int32_t>(i), PrimitiveKind::kTriangles, true});
    boxes.push_back(triangles.boxes[i]);
  }

  for (ScenePrimitive& primitive : primitives) {
    primitive.wraps = trim.wraps(primitive.face);
    primitive.reversed = store.faces[primitive.face].reversed;
  }
  for (Box3& b : boxes) {
    if (!finite(b)) b = {};
    box.add(b);
  }
  bvh = build_bvh(boxes);
  const std::vector<std::int32_t> order = renumber_primitives(bvh);
  std::vector<ScenePrimitive> ordered;
  ordered.reserve(order.size());
  for (const std::int32_t index : order) ordered.push_back(primitives[index]);
  primitives = std::move(ordered);
  leaf_primitive.assign(leaves.size(), -1);
  for (std::size_t i = 0; i < primitives.size(); ++i)
    if (primitives[i].kind == PrimitiveKind::kPatch)
      leaf_primitive[primitives[i].leaf] = static_cast<std::int32_t>(i);
  hulls.reserve(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) hulls.push_back(hull_of(i, boxes[order[i]]));
  if (finite(sieves[0].box())) box.add(sieves[0].box());
}

LeafHull PrototypeScene::hull_of(std::size_t primitive, const Box3& leaf_box) const {
  const ScenePrimitive& p = primitives[primitive];
  OrientedBox box;
  if (p.kind == PrimitiveKind::kPatch) {
    box = patches.oriented_box(p.leaf);
  } else if (p.kind == PrimitiveKind::kClosedForm) {
    box = closed_form_oriented_box(form(p.face), closed_leaves[p.leaf].uv);
  }
  dvec3(&axis)[3] = box.axis;
  double volume = std::abs(glm::dot(glm::cross(axis[0], axis[1]), axis[2]));
  if (!(volume > 0.0) && !leaf_box.empty()) {
    const dvec3 half = 0.5 * leaf_box.extent() + kHullSlack * diagonal;
    box = {leaf_box.center(), {{half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z}}};
    volume = half.x * half.y * half.z;
  }
  LeafHull hull{};
  // It grows by the slack on all sides where each axis grows by slack / height of itself.
  double grow[3] = {1.0, 1.0, 1.0};
  for (int i = 0; i < 3 && volume > 0.0; ++i)
    grow[i] += kHullSlack * diagonal * glm::length(glm::cross(axis[(i + 1) % 3], axis[(i + 2) % 3])) / volume;
  for (int i = 0; i < 3; ++i) {
    hull.center[i] = static_cast<float>(box.center[i] - bvh.center[i]);
    hull.a[i] = static_cast<float>(axis[0][i] * grow[0]),
    hull.b[i] = static_cast<float>(axis[1][i] * grow[1]);
    hull.k[i] = static_cast<float>(axis[2][i] * grow[2]);
  }
  return hull;
}

Scene::Impl::Impl(std::shared_ptr<const NurbsStore> s, int threads, const SceneOptions& o)
    : store(std::move(s)), trim(*store, threads), options(o) {
  if (options.packet < 1 || options.packet > kPacketSize)
    throw ArgumentError("a packet has from 1 to " + std::to_string(kPacketSize) + " rays, not " +
                        std::to_string(options.packet));
  const auto start = std::chrono::steady_clock::now();
  prototypes.resize(store->prototypes.size());
  const bool many = prototypes.size() > 4;
  parallel_ranges(prototypes.size(), 1, many ? threads : 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      prototypes[i] = std::make_unique<PrototypeScene>(*store, static_cast<std::int32_t>(i), trim,
                                                       options.boxes, many ? 1 : threads);
  });
  std::vector<Box3> boxes;
  for (const nurbs::Instance& placed : store->instances) {
    InstanceScene instance;
    instance.prototype = placed.prototype;
    const Transform& place = placed.placement;
    instance.identity = place.linear == dmat3(1.0) && place.translation == dvec3(0.0);
    const Box3& box = prototypes[placed.prototype]->box;
    boxes.push_back(box.empty() ? Box3{} : transformed(place, box));
    instance.translation = place.translation;
    instance.to_prototype = glm::inverse(place.linear);
    instance.normal_matrix = glm::transpose(instance.to_prototype);
    const dmat3& m = place.linear;  // the Frobenius norm bounds the largest singular value
    instance.largest_stretch = std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
    // A placement without an inverse (or with NaN in it) leaves nothing to hit.
    const double determinant = glm::determinant(place.linear);
    if (!(std::abs(determinant) > 1e-30) || !finite(boxes.back())) boxes.back() = {};
    instances.push_back(instance);
    const PrototypeScene& p = *prototypes[placed.prototype];
    for (std::size_t f = 0; f < p.margin_mm.size(); ++f)
      edge_reach = std::max(edge_reach, p.edge_reach(p.first_face + static_cast<std::int32_t>(f), kGrazing) *
                                            instance.largest_stretch);
  }
  bvh = build_bvh(boxes);
  stats.bytes = bvh.bytes();
  for (const auto& p : prototypes) {
    stats.bytes += p->bvh.bytes() + p->patches.bytes() + p->triangles.bytes() +
                   static_cast<std::int64_t>(p->closed_leaves.size() * sizeof(ClosedLeaf) +
                                             p->primitives.size() * sizeof(ScenePrimitive));
    for (const EdgeSieve& sieve : p->sieves) stats.bytes += sieve.bytes();
    stats.leaf_boxes += static_cast<std::int64_t>(p->primitives.size());
    stats.refused_patches += p->patches.refused();
  }
  stats.build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace trimray::trace
