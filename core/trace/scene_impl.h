// Internal to scene*: what a Scene holds, and the two ways through it.
//
// The fast way (scene_packet.cpp) takes 64 rays at a time to their nearest hits by the trim loops alone and
// flags the rays that come near an edge on their way there. The exact way (scene_exact.cpp) takes one ray
// to all of its hits, with the edge rule on the faces of every near edge.
#pragma once

#include <cmath>

#include "core/nurbs/trim.h"
#include "core/trace/closed_form_leaves.h"
#include "core/trace/edge_rule.h"
#include "core/trace/leaf_hull.h"
#include "core/trace/patch.h"
#include "core/trace/scene.h"
#include "core/trace/scene_edges.h"
#include "core/trace/triangle_blocks.h"

namespace trimray::trace {

enum class PrimitiveKind : std::uint8_t { kClosedForm, kPatch, kTriangles };

// A leaf of a prototype's hierarchy.
struct ScenePrimitive {
  std::int32_t face = kNoFace;
  std::int32_t leaf = -1;  // into closed_leaves, patches.leaves() or triangles.blocks
  PrimitiveKind kind = PrimitiveKind::kPatch;
  bool inside = false;  // its uv part lies inside the trim loops
  // Of the face: uv has periods; its outward normal is -(Su x Sv).
  bool wraps = false, reversed = false;
};

struct PrototypeScene {
  PrototypeScene(const nurbs::NurbsStore& store, std::int32_t prototype, const nurbs::TrimIndex& trim,
                 LeafBoxes leaf_boxes, int threads);

  const nurbs::NurbsStore& store;
  const nurbs::TrimIndex& trim;
  std::int32_t first_face;
  std::vector<double> margin_mm;  // per face: how far outside of the loops roots matter
  PatchSet patches;
  std::vector<ClosedForm> forms;  // per face; kind kNone where there is none
  std::vector<ClosedLeaf> closed_leaves;
  TriangleBlocks triangles;
  std::vector<ScenePrimitive> primitives;
  std::vector<LeafHull> hulls;  // as primitives, widened by kHullSlack
  Bvh bvh;
  std::vector<std::int32_t> leaf_order,
      leaf_begin;                 // patch leaves by face: leaf_order[leaf_begin[f] .. leaf_begin[f + 1])
  std::vector<EdgeSieve> sieves;  // as kChordTolerances; packets ask the finest
  std::vector<std::int32_t> leaf_primitive;  // by patch leaf; -1: outside the trim loops
  EdgeRule rule;
  Box3 box;  // of everything a ray can meet
  double diagonal = 0.0;

  std::int32_t face_count() const { return static_cast<std::int32_t>(forms.size()); }
  const ClosedForm& form(std::int32_t face) const { return forms[face - first_face]; }
  // The face's own side of uv; uv already wrapped.
  bool inside(std::int32_t face, dvec2 uv) const {
    const nurbs::Face& f = store.faces[face];
    return f.iso_rectangle ? f.uv_box.contains(uv) : trim.inside(face, uv);
  }
  // The same for the lanes of `which`.
  std::uint32_t inside(std::int32_t face, const double* u, const double* v, std::uint32_t which) const;
  // The lanes of `which` whose roots, on one primitive, lie inside of the loops. core: the part of uv of
  // which the primitive's own flag speaks. Wraps u and v; adds to *tests how often the loops were asked.
  std::uint32_t inside(const ScenePrimitive& p, const Box2& core, double* u, double* v, std::uint32_t which,
                       std::uint64_t* tests) const;
  // The same for a root on a leaf; core: the part of uv of which the leaf's own flag speaks. Sets wrapped.
  bool inside(const ScenePrimitive& p, const Box2& core, dvec2 raw, dvec2& wrapped) const {
    wrapped = p.wraps ? trim.wrap(p.face, raw) : raw;
    return (p.inside && (core.contains(raw) || (p.wraps && core.contains(wrapped)))) ||
           inside(p.face, wrapped);
  }
  // How far behind a root on the face an edge may be that still decides about it. Along a face that the ray
  // grazes a band is a long way: EdgeRule admits 8 bands = 4 margins, measured across the surface.
  double edge_reach(std::int32_t face, double grazing) const {
    return 4.0 * margin_mm[face - first_face] / grazing;
  }
  LeafHull hull_of(std::size_t primitive, const Box3& box) const;
  // A finished root: outward normal, sign, wrapped uv; `inside` is set too.
  Root make_root(std::int32_t face, double t, dvec2 uv, dvec3 normal, dvec3 dir) const;
  Root closed_root(std::int32_t face, const ClosedRoot& root, dvec3 dir) const;

  // Appends the roots of the whole line on one patch leaf.
  void leaf_roots(std::int32_t leaf, const Ray& ray, std::vector<Root>& out) const;
  // Appends the crossings of the whole line with the triangles of the primitives, which are of one mesh face,
  // in the order of the triangles.
  void mesh_roots(std::span<const std::int32_t> primitives, const Ray& ray, std::vector<Root>& out) const;
  dvec3 mesh_normal(std::int32_t triangle) const;
  // All roots of the whole line on one face, sorted by t, each once. Not for mesh faces.
  void face_roots(std::int32_t face, const Ray& ray, std::vector<Root>& out) const;
};

// Hulls reach this fraction of the prototype's diagonal beyond what they hold, so that rounding of a root
// cannot put it outside.
inline constexpr double kHullSlack = 1e-9;

// Rays flatter than this to the face they hit, |cos| of the angle to the normal, are asked one by one for
// edges behind the hit; for the others the packet's sieve reaches far enough.
inline constexpr double kGrazing = 1.0 / 128.0;

// Sorts by t and drops roots that two neighbouring leaves both found (same_root).
void merge_roots(std::vector<Root>& roots, std::size_t begin, double diagonal);

struct InstanceScene {
  std::int32_t prototype = -1;
  bool identity = false;
  dmat3 to_prototype{1.0};   // linear part's inverse
  dmat3 normal_matrix{1.0};  // its transpose: outward normals stay outward, mirrored or not
  dvec3 translation{0.0};
  double largest_stretch = 1.0;  // no length of the prototype grows by more

  // The ray in the prototype; dir of unit length. t there = t in the world * scale.
  Ray local(const Ray& world, double& scale) const;
  dvec3 normal(dvec3 n) const { return identity ? n : glm::normalize(normal_matrix * n); }
};

// Of two hits at one t, which counts? The order is total, so that the answer does not depend on the order
// in which hits are found. triangle: of mesh faces, else -1.
struct HitPlace {
  std::int32_t instance = -1, face = kNoFace;
  dvec2 uv{0.0};
  std::int32_t triangle = -1;
};
inline bool comes_before(const HitPlace& a, const HitPlace& b) {
  if (b.face == kNoFace) return true;
  if (a.instance != b.instance) return a.instance < b.instance;
  if (a.face != b.face) return a.face < b.face;
  if (a.uv.x != b.uv.x) return a.uv.x < b.uv.x;
  return a.uv.y != b.uv.y ? a.uv.y < b.uv.y : a.triangle < b.triangle;
}

struct Scene::Impl {
  std::shared_ptr<const nurbs::NurbsStore> store;
  nurbs::TrimIndex trim;
  std::vector<std::unique_ptr<PrototypeScene>> prototypes;
  std::vector<InstanceScene> instances;
  Bvh bvh;                  // of the instances
  double edge_reach = 0.0;  // mm, world: no hit's edges matter farther behind it (but those of grazing hits)
  SceneStats stats;
  SceneOptions options;

  Impl(std::shared_ptr<const nurbs::NurbsStore> s, int threads, const SceneOptions& options = {});

  // In packets of options.packet; adds to stats.
  void nearest(std::span<const Ray> rays, std::span<Hit> out, TraceStats& stats) const;
  // The hit at a place that the trim loops alone have found. outward: the normal in the prototype; not asked
  // of triangles.
  void set_hit(Hit& hit, const HitPlace& place, double t, const dvec3& outward) const {
    const InstanceScene& instance = instances[place.instance];
    hit.t = t, hit.face = place.face, hit.instance = place.instance, hit.uv_face = place.uv;
    hit.normal = place.triangle < 0 ? outward : prototypes[instance.prototype]->mesh_normal(place.triangle);
    if (!instance.identity) hit.normal = instance.normal(hit.normal);
  }
  // Such hits are asked for near edges whether they seem to be near one or not.
  static bool grazes(const Hit& hit, const HitPlace& place, const dvec3& dir) {
    return place.triangle < 0 && std::abs(glm::dot(hit.normal, dir)) < kGrazing;
  }
  // What the edge rule makes of a hit, or of none (kNoFace), that may be near an edge.
  Hit decide(const Ray& ray, const Hit& hit, TraceStats& counters) const;
  // Is the ray near an edge for a t up to best_t?
  bool near_edge(const Ray& ray, double best_t) const;
  void all_hits(const Ray& ray, std::vector<Hit>& out) const;
};

// Unit length up to rounding: t is then the same number in both frames.
inline constexpr double kUnitSlack = 4e-15;
inline bool is_unit(double length2) { return std::abs(length2 - 1.0) <= kUnitSlack; }

}  // namespace trimray::trace
