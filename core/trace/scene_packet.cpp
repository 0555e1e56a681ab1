// The fast way: packets of 64 rays to their nearest hits by the trim loops alone.
#include <algorithm>
#include <bit>

#include "core/trace/scene_impl.h"

namespace trimray::trace {
namespace {

// One packet on its way through the world.
struct WorldPacket {
  const Scene::Impl& scene;
  TraceStats& stats;
  std::span<const Ray> rays;
  RayPacket boxes;
  Hit best[kPacketSize];            // t starts at the ray's tmax
  dvec3 normal[kPacketSize];        // of patch roots, in the prototype, Su x Sv
  std::uint64_t near_edge = 0;
};

// The packet inside one instance, in the prototype's coordinates.
struct InstancePacket {
  WorldPacket& world;
  const PrototypeScene& prototype;
  std::int32_t instance;
  RayPacket boxes;
  Ray rays[kPacketSize];
  double scale[kPacketSize];

  void consider(int i, double t_local, std::int32_t face, dvec2 uv, const dvec3* normal) {
    const double t = t_local / scale[i];
    const Ray& ray = world.rays[i];
    Hit& best = world.best[i];
    if (!(t >= ray.tmin && t <= ray.tmax) || !comes_before(t, instance, face, best)) return;
    best.t = t, best.face = face, best.instance = instance, best.uv_face = uv;
    if (normal) world.normal[i] = *normal;
    rays[i].tmax = t_local;
    boxes.set_tmax(i, t_local);
  }

  // Is the root inside the loops? core: the part of uv of which the leaf's own flag speaks.
  bool inside(const ScenePrimitive& p, const Box2& core, dvec2 raw, dvec2& wrapped) {
    wrapped = prototype.trim.wrap(p.face, raw);
    if (p.inside && (core.contains(raw) || core.contains(wrapped))) return true;
    ++world.stats.trim_tests;
    return prototype.inside(p.face, wrapped);
  }

  void closed_leaf(const ScenePrimitive& p, std::uint64_t active) {
    const ClosedLeaf& leaf = prototype.closed_leaves[p.leaf];
    const ClosedForm& form = prototype.form(p.face);
    for (; active != 0; active &= active - 1) {
      const int i = std::countr_zero(active);
      ClosedRoot roots[kMaxClosedRoots];
      const int count = closed_form_roots(form, rays[i].org, rays[i].dir, leaf.uv, rays[i].tmin, rays[i].tmax, roots);
      for (int k = 0; k < count; ++k) {
        dvec2 uv;
        if (!inside(p, leaf.core, roots[k].uv, uv)) continue;
        consider(i, roots[k].t, p.face, uv, nullptr);
        break;
      }
    }
  }

  void patch_root(const ScenePrimitive& p, const Box2& core, int i, double t, dvec2 raw, const dvec3& normal) {
    if (!(t >= rays[i].tmin && t <= rays[i].tmax)) return;
    dvec2 uv;
    if (inside(p, core, raw, uv)) consider(i, t, p.face, uv, &normal);
  }

  void patch_leaf(const ScenePrimitive& p, std::uint64_t active) {
    const PatchLeaf& leaf = prototype.patches.leaves()[p.leaf];
    const bool reversed = prototype.store.faces[p.face].reversed;
    while (active != 0) {
      RayLanes lanes;
      int index[kLanes];
      int count = 0;
      for (; active != 0 && count < kLanes; active &= active - 1, ++count) {
        const int i = index[count] = std::countr_zero(active);
        lanes.org_x[count] = rays[i].org.x, lanes.org_y[count] = rays[i].org.y, lanes.org_z[count] = rays[i].org.z;
        lanes.dir_x[count] = rays[i].dir.x, lanes.dir_y[count] = rays[i].dir.y, lanes.dir_z[count] = rays[i].dir.z;
      }
      for (int k = count; k < kLanes; ++k) {
        lanes.org_x[k] = lanes.org_x[0], lanes.org_y[k] = lanes.org_y[0], lanes.org_z[k] = lanes.org_z[0];
        lanes.dir_x[k] = lanes.dir_x[0], lanes.dir_y[k] = lanes.dir_y[0], lanes.dir_z[k] = lanes.dir_z[0];
      }
      lanes.active = (1u << count) - 1u;
      RootLanes roots;
      prototype.patches.solve(p.leaf, lanes, roots);
      world.stats.newton_steps += roots.steps;
      const std::uint32_t one = roots.one & lanes.active, open = lanes.active & ~(roots.one | roots.none);
      world.stats.certified += std::popcount(lanes.active & ~open);
      world.stats.fallbacks += std::popcount(open);
      for (std::uint32_t rest = one; rest != 0; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        const dvec3 n{roots.normal_x[k], roots.normal_y[k], roots.normal_z[k]};
        patch_root(p, leaf.uv_face, index[k], roots.t[k], {roots.u[k], roots.v[k]}, reversed ? -n : n);
      }
      for (std::uint32_t rest = open; rest != 0; rest &= rest - 1) {
        const int i = index[std::countr_zero(rest)];
        std::vector<Root> found;
        prototype.patches.all_roots(p.leaf, rays[i], found);
        for (const Root& root : found) patch_root(p, leaf.uv_face, i, root.t, root.uv_face, root.normal);
      }
    }
  }
};

void visit_primitive(void* context, std::int32_t index, std::uint64_t active) {
  auto& packet = *static_cast<InstancePacket*>(context);
  const ScenePrimitive& p = packet.prototype.primitives[index];
  packet.world.stats.leaves += std::popcount(active);
  if (p.closed) packet.closed_leaf(p, active); else packet.patch_leaf(p, active);
}

void visit_instance(void* context, std::int32_t index, std::uint64_t active) {
  auto& world = *static_cast<WorldPacket*>(context);
  const InstanceScene& instance = world.scene.instances[index];
  InstancePacket packet{world, *world.scene.prototypes[instance.prototype], index, {}, {}, {}};
  for (std::uint64_t rest = active; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    Ray ray = world.rays[i];
    ray.tmax = world.best[i].t;
    packet.rays[i] = instance.local(ray, packet.scale[i]);
    packet.boxes.set(i, packet.prototype.bvh, packet.rays[i].org, packet.rays[i].dir, packet.rays[i].tmin, packet.rays[i].tmax);
  }
  packet.boxes.finish();
  traverse(packet.prototype.bvh, packet.boxes, visit_primitive, &packet, &world.stats.nodes);

  // Edges in front of the nearest hit so far, or at it.
  const EdgeSieve& sieve = packet.prototype.sieve;
  packet.boxes.live = 0;
  for (std::uint64_t rest = active & ~world.near_edge; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    packet.boxes.set(i, sieve.bvh(), packet.rays[i].org, packet.rays[i].dir, packet.rays[i].tmin, packet.rays[i].tmax);
  }
  packet.boxes.finish();
  world.near_edge |= sieve.near(packet.boxes, &world.stats.nodes);
  for (std::uint64_t rest = active; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    world.boxes.set_tmax(i, world.best[i].t);
  }
}

}  // namespace

void Scene::Impl::nearest(std::span<const Ray> rays, std::span<Hit> out, TraceStats& counters) const {
  WorldPacket packet{*this, counters, rays, {}, {}, {}, 0};
  for (std::size_t i = 0; i < rays.size(); ++i) {
    packet.best[i].t = rays[i].tmax;
    packet.boxes.set(static_cast<int>(i), bvh, rays[i].org, rays[i].dir, rays[i].tmin, rays[i].tmax);
  }
  for (int i = static_cast<int>(rays.size()); i < kPacketSize; ++i)
    packet.boxes.set(i, bvh, dvec3(0.0), dvec3(0.0), 1.0, 0.0);
  packet.boxes.finish();
  traverse(bvh, packet.boxes, visit_instance, &packet, &counters.nodes);
  counters.rays += rays.size();

  std::vector<Hit> all;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Hit& best = packet.best[i];
    if ((packet.near_edge >> i) & 1 && near_edge(rays[i], best.t)) {
      ++counters.edge_rays;
      all.clear();
      all_hits(rays[i], all);
      out[i] = all.empty() ? Hit{} : all.front();
      continue;
    }
    if (best.face == kNoFace) {
      out[i] = Hit{};
      continue;
    }
    const PrototypeScene& prototype = *prototypes[instances[best.instance].prototype];
    const ClosedForm& form = prototype.form(best.face);
    dvec3 n = packet.normal[i];
    if (form.kind != nurbs::SurfaceKind::kNone) {
      n = closed_form_normal(form, best.uv_face);
      if (store->faces[best.face].reversed) n = -n;
    }
    best.normal = instances[best.instance].normal(n);
    out[i] = best;
  }
}

}  // namespace trimray::trace
