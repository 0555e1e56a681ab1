// The fast way: packets of up to 64 rays to their nearest hits by the trim loops alone.
#include <algorithm>
#include <bit>

#include "core/trace/closed_form_lanes.h"
#include "core/trace/scene_impl.h"

namespace trimray::trace {
namespace {

// The lanes of `which` that lie in the box, ends included.
std::uint32_t contained(const Box2& box, const double* u, const double* v, std::uint32_t which) {
  std::uint32_t result = 0;
  for (std::uint32_t rest = which; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    if (box.contains(dvec2(u[i], v[i]))) result |= 1u << i;
  }
  return result;
}

// One packet on its way through the world.
struct WorldPacket {
  const Scene::Impl& scene;
  TraceStats& stats;
  bool unit = true;  // every direction has unit length: identity instances use `rays` as they are
  std::uint64_t near_edge = 0;
  RayBlock rays;  // tmax: the nearest hit so far
  RayPacket boxes;
  HitPlace place[kPacketSize];  // of that hit
  dvec3 normal[kPacketSize];    // but on triangles; outward, in the prototype

  WorldPacket(const Scene::Impl& s, TraceStats& counters) : scene(s), stats(counters) {}

  // The next packet. What the kernels load beyond its end is the last ray once more.
  void start(std::span<const Ray> next) {
    constexpr std::size_t kLoad = 16;
    unit = true, near_edge = 0;
    for (std::size_t i = 0; i < (next.size() + kLoad - 1) / kLoad * kLoad; ++i) {
      const Ray& ray = next[std::min(i, next.size() - 1)];
      rays.set(static_cast<int>(i), ray.org, ray.dir, ray.tmin, ray.tmax);
      unit &= is_unit(glm::dot(ray.dir, ray.dir));
      place[i] = {};
    }
  }
};

// The packet inside one instance, in the prototype's coordinates.
struct InstancePacket {
  WorldPacket& world;
  const PrototypeScene& prototype;
  std::int32_t instance;
  RayBlock& rays;       // the world's own for an identity instance
  const double* scale;  // t here = t in the world * scale; null: all 1
  RayPacket boxes;
  std::uint64_t sheared = 0;  // rays whose shear is known
  RayShear shears[kPacketSize];

  InstancePacket(WorldPacket& w, const PrototypeScene& p, std::int32_t i, RayBlock& r, const double* s)
      : world(w), prototype(p), instance(i), rays(r), scale(s) {}

  Ray ray(int i) const { return {rays.origin(i), rays.direction(i), rays.tmin[i], rays.tmax[i]}; }

  void consider(int i, double t_local, std::int32_t face, dvec2 uv, const dvec3* normal,
                std::int32_t triangle = -1) {
    const double t = scale ? t_local / scale[i] : t_local;
    const double best = world.rays.tmax[i];
    if (!(t >= world.rays.tmin[i] && t <= best)) return;
    const HitPlace place{instance, face, uv, triangle};
    if (t == best && !comes_before(place, world.place[i])) return;
    world.place[i] = place;
    if (normal) world.normal[i] = *normal;
    world.rays.tmax[i] = t;
    rays.tmax[i] = t_local;
    boxes.set_tmax(i, t_local);
  }

  // Of up to kLanes rays of `active`, which loses them; their numbers go to `index`. The other lanes repeat
  // the first ray. Returns how many.
  int next_lanes(std::uint64_t& active, RayLanes& lanes, int (&index)[kLanes]) const {
    int count = 0;
    for (; active != 0 && count < kLanes; active &= active - 1) index[count++] = std::countr_zero(active);
    for (int k = 0; k < kLanes; ++k) {
      const int i = index[k < count ? k : 0];
      lanes.org_x[k] = rays.org[0][i], lanes.org_y[k] = rays.org[1][i], lanes.org_z[k] = rays.org[2][i];
      lanes.dir_x[k] = rays.dir[0][i], lanes.dir_y[k] = rays.dir[1][i], lanes.dir_z[k] = rays.dir[2][i];
    }
    lanes.active = (1u << count) - 1u;
    return count;
  }

  // False where the root lies outside of the loops.
  bool closed_root(const ScenePrimitive& p, const ClosedLeaf& leaf, int i, double t, dvec2 raw,
                   const dvec3& normal, bool reversed) {
    dvec2 uv;
    world.stats.trim_tests += !p.inside;
    if (!prototype.inside(p, leaf.core, raw, uv)) return false;
    const dvec3 outward = reversed ? -normal : normal;
    consider(i, t, p.face, uv, &outward);
    return true;
  }

  void closed_leaf(const ScenePrimitive& p, std::uint64_t active) {
    const ClosedLeaf& leaf = prototype.closed_leaves[p.leaf];
    const ClosedForm& form = prototype.form(p.face);
    const bool reversed = prototype.store.faces[p.face].reversed;
    if (!solves_closed_form_lanes(form.kind)) {
      for (; active != 0; active &= active - 1) {
        const int i = std::countr_zero(active);
        ClosedRoot roots[kMaxClosedRoots];
        const int count = closed_form_roots(form, rays.origin(i), rays.direction(i), leaf.uv, rays.tmin[i],
                                            rays.tmax[i], roots);
        for (int k = 0; k < count; ++k)
          if (closed_root(p, leaf, i, roots[k].t, roots[k].uv, roots[k].normal, reversed)) break;
      }
      return;
    }
    while (active != 0) {
      RayLanes lanes;
      int index[kLanes];
      const int count = next_lanes(active, lanes, index);
      alignas(64) double tmin[kLanes], tmax[kLanes];
      for (int k = 0; k < kLanes; ++k) {
        const int i = index[k < count ? k : 0];
        tmin[k] = rays.tmin[i], tmax[k] = rays.tmax[i];
      }
      ClosedRootLanes roots;
      closed_form_lanes(form, lanes, leaf.uv, tmin, tmax, roots);
      // A lane whose first root counts is done.
      std::uint32_t open = lanes.active;
      for (int k = 0; k < kLaneRoots; ++k) {
        const std::uint32_t found = roots.found[k] & open;
        if (found == 0) continue;
        const std::uint32_t in =
            prototype.inside(p, leaf.core, roots.u[k], roots.v[k], found, &world.stats.trim_tests);
        for (std::uint32_t rest = in; rest != 0; rest &= rest - 1) {
          const int i = std::countr_zero(rest);
          const dvec3 n{roots.normal_x[k][i], roots.normal_y[k][i], roots.normal_z[k][i]},
              outward = reversed ? -n : n;
          consider(index[i], roots.t[k][i], p.face, {roots.u[k][i], roots.v[k][i]}, &outward);
        }
        open &= ~in;
      }
    }
  }

  void patch_root(const ScenePrimitive& p, const Box2& core, int i, double t, dvec2 raw,
                  const dvec3& normal) {
    if (!(t >= rays.tmin[i] && t <= rays.tmax[i])) return;
    dvec2 uv;
    world.stats.trim_tests += !p.inside;
    if (prototype.inside(p, core, raw, uv)) consider(i, t, p.face, uv, &normal);
  }

  void patch_leaf(const ScenePrimitive& p, std::uint64_t active) {
    const PatchLeaf& leaf = prototype.patches.leaves()[p.leaf];
    const bool reversed = prototype.store.faces[p.face].reversed;
    OpenLanes waiting;
    while (active != 0) {
      RayLanes lanes;
      int index[kLanes];
      next_lanes(active, lanes, index);
      RootLanes roots;
      prototype.patches.solve(p.leaf, lanes, roots);
      world.stats.newton_steps += roots.steps;
      const std::uint32_t one = roots.one & lanes.active, open = lanes.active & ~(roots.one | roots.none);
      world.stats.certified += std::popcount(lanes.active & ~open);
      world.stats.fallbacks += std::popcount(open);
      std::uint32_t in = 0;
      for (std::uint32_t rest = one; rest != 0; rest &= rest - 1) {
        const int k = std::countr_zero(rest), i = index[k];
        if (roots.t[k] >= rays.tmin[i] && roots.t[k] <= rays.tmax[i]) in |= 1u << k;
      }
      in = prototype.inside(p, leaf.uv_face, roots.u, roots.v, in, &world.stats.trim_tests);
      for (std::uint32_t rest = in; rest != 0; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        const dvec3 n{roots.normal_x[k], roots.normal_y[k], roots.normal_z[k]}, outward = reversed ? -n : n;
        consider(index[k], roots.t[k], p.face, {roots.u[k], roots.v[k]}, &outward);
      }
      for (std::uint32_t rest = open; rest != 0; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        waiting.add(lanes, k, index[k]);
        if (waiting.count == kLanes) open_lanes(p, leaf.uv_face, waiting);
      }
    }
    if (waiting.count > 0) open_lanes(p, leaf.uv_face, waiting);
  }

  void open_lanes(const ScenePrimitive& p, const Box2& core, OpenLanes& waiting) {
    thread_local std::vector<LaneRoot> found;
    found.clear();
    prototype.patches.open_roots(p.leaf, waiting.rays, found);
    for (const auto& [lane, root] : found)
      patch_root(p, core, waiting.index[lane], root.t, root.uv_face, root.normal);
    waiting.count = 0;
  }

  void triangle_block(const ScenePrimitive& p, std::uint64_t active) {
    for (std::uint64_t rest = active & ~sheared; rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      shears[i] = RayShear(rays.origin(i), rays.direction(i));
    }
    sheared |= active;
    const TriangleBlock& block = prototype.triangles.blocks[p.leaf];
    TriangleCrossing crossings[kPacketSize * kTrianglesPerBlock];
    const int count = cross_triangles(block, shears, active, crossings);
    for (int k = 0; k < count; ++k) {
      const TriangleCrossing& c = crossings[k];
      if (c.t >= rays.tmin[c.ray] && c.t <= rays.tmax[c.ray])
        consider(c.ray, c.t, p.face, c.weights, nullptr, block.triangle[c.lane]);
    }
  }
};

void visit_primitive(void* context, std::int32_t index, std::uint64_t active) {
  auto& packet = *static_cast<InstancePacket*>(context);
  const ScenePrimitive& p = packet.prototype.primitives[index];
  packet.world.stats.leaves += std::popcount(active);
  switch (p.kind) {
    case PrimitiveKind::kClosedForm:
      return packet.closed_leaf(p, active);
    case PrimitiveKind::kPatch:
      return packet.patch_leaf(p, active);
    case PrimitiveKind::kTriangles:
      return packet.triangle_block(p, active);
  }
}

// Ray by ray, by the very steps of the exact way.
void into_instance(const WorldPacket& world, const InstanceScene& instance, std::uint64_t active,
                   RayBlock& out, double* scale) {
  for (std::uint64_t rest = active; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    const Ray ray = instance.local(
        {world.rays.origin(i), world.rays.direction(i), world.rays.tmin[i], world.rays.tmax[i]}, scale[i]);
    out.set(i, ray.org, ray.dir, ray.tmin, ray.tmax);
  }
}

void trace_instance(InstancePacket& packet, std::uint64_t active) {
  WorldPacket& world = packet.world;
  packet.boxes.set(packet.prototype.bvh, packet.rays, active);
  traverse(packet.prototype.bvh, packet.boxes, visit_primitive, &packet, &world.stats.nodes);
  // Edges in front of the nearest hit so far, at it, or behind it within the reach of any face's bands: the
  // hit to come may lie on another face or instance.
  const EdgeSieve& sieve = packet.prototype.sieves[0];
  packet.boxes.set(sieve.bvh(), packet.rays, active & ~world.near_edge);
  for (std::uint64_t rest = packet.boxes.live; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    const double reach = packet.scale ? world.scene.edge_reach * packet.scale[i] : world.scene.edge_reach;
    packet.boxes.set_tmax(i, packet.rays.tmax[i] + reach);
  }
  if (packet.boxes.live != 0) world.near_edge |= sieve.near(packet.boxes, &world.stats.nodes);
}

void visit_instance(void* context, std::int32_t index, std::uint64_t active) {
  auto& world = *static_cast<WorldPacket*>(context);
  const InstanceScene& instance = world.scene.instances[index];
  const PrototypeScene& prototype = *world.scene.prototypes[instance.prototype];
  if (instance.identity && world.unit) {
    InstancePacket packet(world, prototype, index, world.rays, nullptr);
    trace_instance(packet, active);
  } else {
    RayBlock local;
    double scale[kPacketSize];
    into_instance(world, instance, active, local, scale);
    InstancePacket packet(world, prototype, index, local, scale);
    trace_instance(packet, active);
  }
  for (std::uint64_t rest = active; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    world.boxes.set_tmax(i, world.rays.tmax[i]);
  }
}

}  // namespace

std::uint32_t PrototypeScene::inside(std::int32_t face, const double* u, const double* v,
                                     std::uint32_t which) const {
  const nurbs::Face& f = store.faces[face];
  return f.iso_rectangle ? contained(f.uv_box, u, v, which) : trim.inside(face, u, v, which);
}

std::uint32_t PrototypeScene::inside(const ScenePrimitive& p, const Box2& core, double* u, double* v,
                                     std::uint32_t which, std::uint64_t* tests) const {
  std::uint32_t certain = p.inside ? contained(core, u, v, which) : 0;
  if (p.wraps) trim.wrap(p.face, u, v, which);
  if (p.inside && p.wraps) certain |= contained(core, u, v, which & ~certain);
  const std::uint32_t asked = which & ~certain;
  if (asked == 0) return certain;
  *tests += std::popcount(asked);
  return certain | inside(p.face, u, v, asked);
}

void Scene::Impl::nearest(std::span<const Ray> all_rays, std::span<Hit> all_out, TraceStats& counters) const {
  WorldPacket packet(*this, counters);
  counters.rays += all_rays.size();
  const auto most = static_cast<std::size_t>(options.packet);
  for (std::size_t first = 0; first < all_rays.size(); first += most) {
    const std::size_t count = std::min(most, all_rays.size() - first);
    const std::span<const Ray> rays = all_rays.subspan(first, count);
    const std::span<Hit> out = all_out.subspan(first, count);
    packet.start(rays);
    packet.boxes.set(bvh, packet.rays,
                     count == kPacketSize ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1);
    traverse(bvh, packet.boxes, visit_instance, &packet, &counters.nodes);
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = Hit{};
      const HitPlace& place = packet.place[i];
      bool ask = (packet.near_edge >> i) & 1;
      if (place.face != kNoFace) {
        set_hit(out[i], place, packet.rays.tmax[i], packet.normal[i]);
        ask |= grazes(out[i], place, rays[i].dir);
      }
      if (ask) out[i] = decide(rays[i], out[i], counters);
    }
  }
}

Hit Scene::Impl::decide(const Ray& ray, const Hit& hit, TraceStats& counters) const {
  double limit = hit.t;
  if (hit.face != kNoFace) {
    const InstanceScene& instance = instances[hit.instance];
    const double grazing = std::max(std::abs(glm::dot(hit.normal, ray.dir)), 1e-12);
    limit += prototypes[instance.prototype]->edge_reach(hit.face, grazing) * instance.largest_stretch;
  } else {
    limit = ray.tmax;
  }
  if (!near_edge(ray, limit)) return hit;
  ++counters.edge_rays;
  std::vector<Hit> all;
  all_hits(ray, all);
  return all.empty() ? Hit{} : all.front();
}

}  // namespace trimray::trace
