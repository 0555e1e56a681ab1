#include "core/hybrid/tile_tracer.h"

#include <algorithm>
#include <bit>

#include "core/hybrid/edge_mask.h"
#include "core/hybrid/tile_walk.h"
#include "core/trace/closed_form_lanes.h"

namespace trimray::hybrid {

using trace::Hit;
using trace::HitPlace;
using trace::Ray;

TileTracer::TileTracer(const ViewContext& view, const trace::Tile& tile, TileState& state, HybridStats& stats)
    : view_(view),
      tile_(tile),
      state_(state),
      stats_(stats),
      width_(tile.width()),
      height_(tile.y1 - tile.y0) {
  const dvec2 middle = 0.5 * dvec2(view.camera.width_px, view.camera.height_px);
  rect_ = {tile.x0 - middle.x, tile.y0 - middle.y, tile.x1 - middle.x, tile.y1 - middle.y};
  state.reset(tile);
}

float TileTracer::far() const {
  float far = -kFarDepth;
  for (std::size_t p = 0; p < tile_.places.size(); ++p)
    for (int y = 0; y < height_; ++y) {
      const float* row = state_.best.data() + p * kTileSlots + static_cast<std::size_t>(y) * kMaxTile;
      float most = row[0];
      for (int x = 1; x < width_; ++x) most = row[x] > most ? row[x] : most;
      if (most == kFarDepth) return most;
      far = std::max(far, most);
    }
  return far;
}

bool TileTracer::crowded() const {
  const trace::Scene::Impl& scene = *view_.scene;
  if (!(view_.crowded_leaves < kInf)) return false;
  const auto most = static_cast<std::int64_t>(view_.crowded_leaves * width_ * height_);
  std::int64_t sum = 0;
  walk_tile(
      scene.bvh, TileSpace(view_.world, scene.bvh, rect_, view_.reference), [&] { return kFarDepth; },
      [&](std::int32_t index, float) {
        if (sum > most) return;
        const InstanceView& instance = view_.instances[index];
        const trace::Bvh& bvh = instance.prototype->bvh;
        sum += estimate_tile(bvh, TileSpace(instance.frame, bvh, rect_, view_.reference), most - sum);
      });
  return sum > most;
}

void TileTracer::leaves() {
  far_ = far();
  const auto limit = [&] { return far_; };
  const trace::Scene::Impl& scene = *view_.scene;
  walk_tile(scene.bvh, TileSpace(view_.world, scene.bvh, rect_, view_.reference), limit,
            [&](std::int32_t index, float) {
              const InstanceView& instance = view_.instances[index];
              const trace::Bvh& bvh = instance.prototype->bvh;
              const TileFrame frame(instance.frame, bvh.center, bvh.radius, rect_, view_.reference);
              std::int32_t batch[kBatch];
              std::size_t count = 0;
              walk_tile(bvh, TileSpace(instance.frame, bvh, rect_, view_.reference), limit,
                        [&](std::int32_t primitive, float) {
                          batch[count++] = primitive;
                          if (count == kBatch) leaf_batch(instance, frame, {batch, count}), count = 0;
                        });
              if (count > 0) leaf_batch(instance, frame, {batch, count});
            });
}

void TileTracer::leaf_batch(const InstanceView& view, const TileFrame& frame,
                            std::span<const std::int32_t> primitives) {
  stats_.candidates += primitives.size();
  Footprints footprints;
  make_footprints(frame, view.prototype->hulls, primitives, width_, height_, footprints);
  for (std::size_t i = 0; i < primitives.size(); ++i)
    if (footprints.x0[i] < footprints.x1[i] && footprints.y0[i] < footprints.y1[i])
      leaf(view, primitives[i], footprints, static_cast<int>(i));
}

void TileTracer::leaf(const InstanceView& view, std::int32_t primitive, const Footprints& footprints, int i) {
  const ScenePrimitive& about = view.prototype->primitives[primitive];
  const std::int32_t closed_face = about.kind == trace::PrimitiveKind::kClosedForm ? about.face : -2;
  std::int32_t slots[trace::kPacketSize];
  std::size_t count = 0;
  bool met = false;
  for (std::size_t p = 0; p < tile_.places.size(); ++p) {
    std::uint64_t rows[kMaxTile];
    if (!cover(footprints, i, state_.best.data() + p * kTileSlots,
               static_cast<float>(tile_.places[p].x - 0.5), static_cast<float>(tile_.places[p].y - 0.5),
               width_, height_, rows))
      continue;
    for (int y = footprints.y0[i]; y < footprints.y1[i]; ++y)
      for (std::uint64_t rest = rows[y]; rest != 0; rest &= rest - 1) {
        const std::int32_t slot =
            static_cast<std::int32_t>(p * kTileSlots) + y * kMaxTile + std::countr_zero(rest);
        const KnownRoot& known = state_.known[slot];
        if (TileState::has(state_.has_known, slot) && known.instance == view.index &&
            (known.primitive == primitive || known.face == closed_face))
          continue;
        slots[count++] = slot;
        if (count < trace::kPacketSize) continue;
        solve(view, primitive, {slots, count});
        count = 0, met = true;
      }
  }
  if (count > 0) solve(view, primitive, {slots, count}), met = true;
  if (met && --leaves_until_far_ <= 0) far_ = far(), leaves_until_far_ = 8;
}

int TileTracer::rays(const InstanceView& view, std::span<const std::int32_t> slots, trace::RayLanes& rays,
                     LaneScales& scales) const {
  const int count = static_cast<int>(std::min<std::size_t>(trace::kLanes, slots.size()));
  double x[trace::kLanes], y[trace::kLanes];
  for (int k = 0; k < count; ++k) {
    const std::int32_t slot = slots[k];
    const dvec2& place = tile_.places[slot / kTileSlots];
    x[k] = tile_.x0 + slot % kMaxTile + place.x, y[k] = tile_.y0 + slot % kTileSlots / kMaxTile + place.y;
  }
  lane_rays(view_.camera, view, x, y, count, rays, scales);
  return count;
}

void TileTracer::solve(const InstanceView& view, std::int32_t primitive,
                       std::span<const std::int32_t> slots) {
  const ScenePrimitive& p = view.prototype->primitives[primitive];
  switch (p.kind) {
    case trace::PrimitiveKind::kClosedForm:
      stats_.solves += slots.size();
      return closed_leaf(view, p, slots);
    case trace::PrimitiveKind::kPatch:
      return patch_leaf(view, p, slots);
    case trace::PrimitiveKind::kTriangles:
      stats_.solves += slots.size();
      return triangle_block(view, p, slots);
  }
}

void TileTracer::closed_leaf(const InstanceView& view, const ScenePrimitive& p,
                             std::span<const std::int32_t> slots) {
  const trace::ClosedLeaf& leaf = view.prototype->closed_leaves[p.leaf];
  const trace::ClosedForm& form = view.prototype->form(p.face);
  const bool reversed = p.reversed;
  // True where the root counts: the next one of the ray lies behind it.
  const auto root = [&](std::int32_t slot, double t, const LaneScales& scales, int lane, dvec2 raw,
                        const dvec3& normal) {
    if (scales.world(t, lane) > state_.t(slot)) return true;
    dvec2 uv;
    if (!view.prototype->inside(p, leaf.core, raw, uv)) return false;
    consider(view, slot, t, scales, lane, p.face, uv, reversed ? -normal : normal);
    return true;
  };
  for (std::size_t begin = 0; begin < slots.size(); begin += trace::kLanes) {
    trace::RayLanes lanes;
    LaneScales scales;
    const int count = rays(view, slots.subspan(begin), lanes, scales);
    if (!trace::solves_closed_form_lanes(form.kind)) {
      for (int k = 0; k < count; ++k) {
        trace::ClosedRoot roots[trace::kMaxClosedRoots];
        const int found =
            closed_form_roots(form, {lanes.org_x[k], lanes.org_y[k], lanes.org_z[k]},
                              {lanes.dir_x[k], lanes.dir_y[k], lanes.dir_z[k]}, leaf.uv, 0.0, kInf, roots);
        for (int r = 0; r < found; ++r)
          if (root(slots[begin + k], roots[r].t, scales, k, roots[r].uv, roots[r].normal)) break;
      }
      continue;
    }
    trace::ClosedRootLanes roots;
    closed_form_lanes(form, lanes, leaf.uv, kZeros, kInfinities, roots);
    // A ray whose first root counts is done; so is one whose next root lies behind its hit.
    std::uint32_t left = lanes.active;
    for (int r = 0; r < trace::kLaneRoots; ++r) {
      for (std::uint32_t rest = roots.found[r] & left; rest != 0; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        if (scales.world(roots.t[r][k], k) > state_.t(slots[begin + k])) left &= ~(1u << k);
      }
      const std::uint32_t found = roots.found[r] & left;
      if (found == 0) continue;
      std::uint64_t tests = 0;
      const std::uint32_t in = view.prototype->inside(p, leaf.core, roots.u[r], roots.v[r], found, &tests);
      for (std::uint32_t rest = in; rest != 0; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        const dvec3 n{roots.normal_x[r][k], roots.normal_y[r][k], roots.normal_z[r][k]};
        consider(view, slots[begin + k], roots.t[r][k], scales, k, p.face, {roots.u[r][k], roots.v[r][k]},
                 reversed ? -n : n);
      }
      left &= ~in;
    }
  }
}

std::uint32_t TileTracer::ruled_out(const InstanceView& view, std::int32_t leaf, std::int32_t patch,
                                    std::span<const std::int32_t> slots, const trace::RayLanes& lanes) const {
  alignas(64) double u[trace::kLanes] = {}, v[trace::kLanes] = {};
  std::uint32_t known_lanes = 0;
  for (std::uint32_t rest = lanes.active; rest != 0; rest &= rest - 1) {
    const int k = std::countr_zero(rest);
    const KnownRoot& known = state_.known[slots[k]];
    if (!TileState::has(state_.has_known, slots[k]) || known.instance != view.index || known.patch != patch)
      continue;
    u[k] = known.u, v[k] = known.v;
    known_lanes |= 1u << k;
  }
  return known_lanes == 0 ? 0 : known_lanes & view.prototype->patches.rules_out(leaf, lanes, u, v);
}

void TileTracer::patch_leaf(const InstanceView& view, const ScenePrimitive& p,
                            std::span<const std::int32_t> slots) {
  const trace::PatchSet& patches = view.prototype->patches;
  const trace::PatchLeaf& leaf = patches.leaves()[p.leaf];
  const bool reversed = p.reversed;
  const auto root = [&](std::int32_t slot, double t, const LaneScales& scales, int lane, dvec2 raw,
                        const dvec3& normal) {
    if (!(t >= 0.0 && scales.world(t, lane) <= state_.t(slot))) return;
    dvec2 uv;
    if (view.prototype->inside(p, leaf.uv_face, raw, uv))
      consider(view, slot, t, scales, lane, p.face, uv, normal);
  };
  trace::OpenLanes waiting;
  LaneScales open_scales;
  const auto open_lanes = [&] {
    thread_local std::vector<trace::LaneRoot> found;
    found.clear();
    patches.open_roots(p.leaf, waiting.rays, found);
    for (const auto& [k, r] : found) root(waiting.index[k], r.t, open_scales, k, r.uv_face, r.normal);
    waiting.count = 0;
  };
  for (std::size_t begin = 0; begin < slots.size(); begin += trace::kLanes) {
    trace::RayLanes lanes;
    LaneScales scales;
    rays(view, slots.subspan(begin), lanes, scales);
    lanes.active &= ~ruled_out(view, p.leaf, leaf.patch, slots.subspan(begin), lanes);
    if (lanes.active == 0) continue;
    trace::RootLanes roots;
    patches.solve(p.leaf, lanes, roots);
    stats_.solves += std::popcount(lanes.active), stats_.newton_roots += std::popcount(lanes.active);
    stats_.newton_steps += roots.steps;
    const std::uint32_t one = roots.one & lanes.active, open = lanes.active & ~(roots.one | roots.none);
    stats_.open += std::popcount(open);
    std::uint32_t in = 0;
    for (std::uint32_t rest = one; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const std::int32_t slot = slots[begin + k];
      state_.know(slot, {view.index, kNoFace, -1, leaf.patch, roots.param_u[k], roots.param_v[k]});
      if (roots.t[k] >= 0.0 && scales.world(roots.t[k], k) <= state_.t(slot)) in |= 1u << k;
    }
    std::uint64_t tests = 0;
    in = view.prototype->inside(p, leaf.uv_face, roots.u, roots.v, in, &tests);
    for (std::uint32_t rest = in; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const dvec3 n{roots.normal_x[k], roots.normal_y[k], roots.normal_z[k]};
      consider(view, slots[begin + k], roots.t[k], scales, k, p.face, {roots.u[k], roots.v[k]},
               reversed ? -n : n);
    }
    for (std::uint32_t rest = open; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      open_scales.scale[waiting.count] = scales.scale[k], open_scales.depth[waiting.count] = scales.depth[k];
      open_scales.unit = scales.unit && (waiting.count == 0 || open_scales.unit);
      waiting.add(lanes, k, slots[begin + k]);
      if (waiting.count == trace::kLanes) open_lanes();
    }
  }
  if (waiting.count > 0) open_lanes();
}

void TileTracer::triangle_block(const InstanceView& view, const ScenePrimitive& p,
                                std::span<const std::int32_t> slots) {
  const trace::TriangleBlock& block = view.prototype->triangles.blocks[p.leaf];
  for (std::size_t begin = 0; begin < slots.size(); begin += trace::kLanes) {
    trace::RayLanes lanes;
    LaneScales scales;
    const int lane_count = rays(view, slots.subspan(begin), lanes, scales);
    trace::RayShear shears[trace::kLanes];
    for (int k = 0; k < lane_count; ++k)
      shears[k] = trace::RayShear({lanes.org_x[k], lanes.org_y[k], lanes.org_z[k]},
                                  {lanes.dir_x[k], lanes.dir_y[k], lanes.dir_z[k]});
    trace::TriangleCrossing crossings[trace::kLanes * trace::kTrianglesPerBlock];
    const int count =
        cross_triangles(block, {shears, static_cast<std::size_t>(lane_count)}, lanes.active, crossings);
    for (int i = 0; i < count; ++i) {
      const trace::TriangleCrossing& c = crossings[i];
      consider(view, slots[begin + c.ray], c.t, scales, c.ray, p.face, c.weights, dvec3(0.0),
               block.triangle[c.lane]);
    }
  }
}

void TileTracer::edges() {
  far_ = far();
  const trace::Scene::Impl& scene = *view_.scene;
  const double reach = scene.edge_reach;
  walk_tile(
      scene.bvh, TileSpace(view_.world, scene.bvh, rect_, view_.reference),
      [&] { return far_ + static_cast<float>(reach * 1.000001); },
      [&](std::int32_t index, float) {
        mark_edges(view_.instances[index], tile_, rect_, view_.reference, reach, far_, state_);
      });
}

void TileTracer::finish(trace::TileHits& out) {
  trace::TraceStats counters;
  const std::size_t places = tile_.places.size();
  out.ray.clear(), out.hit.clear();
  const bool parallel = !view_.camera.perspective;
  for (int y = 0; y < height_; ++y) {
    std::uint64_t pixels = 0;
    for (std::size_t p = 0; p < places; ++p)
      pixels |= state_.has_hit[p * kMaxTile + y] | state_.near_edge[p * kMaxTile + y];
    for (; pixels != 0; pixels &= pixels - 1) {
      const int x = std::countr_zero(pixels);
      for (std::size_t p = 0; p < places; ++p) {
        const auto slot = static_cast<std::int32_t>(p * kTileSlots) + y * kMaxTile + x;
        const bool found = TileState::has(state_.has_hit, slot);
        bool ask = TileState::has(state_.near_edge, slot);
        if (!found && !ask) continue;
        const auto ray = [&] {
          const dvec2& place = tile_.places[p];
          const view::CameraRay r = view_.camera.ray(tile_.x0 + x + place.x, tile_.y0 + y + place.y);
          return trace::Ray{r.org, r.dir, 0.0, kInf};
        };
        Hit& hit = out.hit.emplace_back();
        if (found) {
          const SlotHit& best = state_.hits[slot];
          view_.scene->set_hit(hit, best.place, best.t, best.normal);
          ask |= view_.scene->grazes(hit, best.place, parallel ? view_.camera.forward : ray().dir);
        }
        if (ask) hit = view_.scene->decide(ray(), hit, counters);
        if (hit.face == kNoFace)
          out.hit.pop_back();
        else
          out.ray.push_back(static_cast<std::int32_t>((y * width_ + x) * places + p));
      }
    }
  }
  stats_.rays += tile_.rays();
  stats_.hits += out.hit.size();
  stats_.edge_rays += counters.edge_rays;
}

}  // namespace trimray::hybrid
