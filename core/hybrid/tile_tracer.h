// The rays of one tile on their way to their first hits.
#pragma once

#include <cmath>
#include <span>

#include "core/hybrid/hybrid.h"
#include "core/hybrid/instance_view.h"
#include "core/hybrid/lane_rays.h"
#include "core/hybrid/tile_state.h"

namespace trimray::hybrid {

// What all tiles of a picture share.
struct ViewContext {
  const trace::Scene::Impl* scene = nullptr;
  view::Camera camera;
  CameraFrame world;       // of world coordinates
  double reference = 0.0;  // depths count from it
  double crowded_leaves = kCrowdedLeaves;
  std::vector<InstanceView> instances;
  const raster::SeedBuffers* seeds = nullptr;
};

using trace::ScenePrimitive;

// Limits of t that admit all roots in front of the eye, for the lanes of closed forms.
alignas(64) inline constexpr double kZeros[trace::kLanes] = {};
alignas(64) inline constexpr double kInfinities[trace::kLanes] = {kInf, kInf, kInf, kInf,
                                                                  kInf, kInf, kInf, kInf};

class TileTracer {
 public:
  TileTracer(const ViewContext& view, const trace::Tile& tile, TileState& state, HybridStats& stats);

  // Are there so many leaves for the pixels that rays by themselves, in packets, are the faster way?
  bool crowded() const;
  // First hits from the seeds of the view, if it has any.
  void seeds();
  // Every leaf that can cover a pixel in front of its hit so far.
  void leaves();
  // Which rays may pass near an edge, at their hits or in front of them.
  void edges();
  void finish(trace::TileHits& out);

 private:
  void seeded_patch(const InstanceView& view, std::int32_t patch, trace::SeedLanes& seeds,
                    std::span<const std::int32_t> slots);
  void seeded_closed(const InstanceView& view, std::int32_t face, std::span<const std::int32_t> slots);
  void leaf_batch(const InstanceView& view, const TileFrame& frame, std::span<const std::int32_t> primitives);
  void leaf(const InstanceView& view, std::int32_t primitive, const Footprints& footprints, int i);
  void solve(const InstanceView& view, std::int32_t primitive, std::span<const std::int32_t> slots);
  void closed_leaf(const InstanceView& view, const ScenePrimitive& p, std::span<const std::int32_t> slots);
  void patch_leaf(const InstanceView& view, const ScenePrimitive& p, std::span<const std::int32_t> slots);
  // Lanes that a known root of the leaf's patch proves to have none on the leaf.
  std::uint32_t ruled_out(const InstanceView& view, std::int32_t leaf, std::int32_t patch,
                          std::span<const std::int32_t> slots, const trace::RayLanes& lanes) const;
  void triangle_block(const InstanceView& view, const ScenePrimitive& p, std::span<const std::int32_t> slots);
  // Of the first slots, at most kLanes; returns their number.
  int rays(const InstanceView& view, std::span<const std::int32_t> slots, trace::RayLanes& rays,
           LaneScales& scales) const;
  // A root inside the loops; normal: outward, in the prototype. Inlined, since vectors that go through memory
  // number by number and come back as a whole stall the machine.
  [[gnu::always_inline]] inline void consider(const InstanceView& view, std::int32_t slot, double t_local,
                                              const LaneScales& scales, int lane, std::int32_t face, dvec2 uv,
                                              dvec3 normal, std::int32_t triangle = -1);
  float far() const;  // no ray's best is beyond

  const ViewContext& view_;
  const trace::Tile& tile_;
  TileState& state_;
  HybridStats& stats_;
  int width_, height_;
  FrameRect rect_;
  float far_ = kFarDepth;
  int leaves_until_far_ = 0;
};

inline void TileTracer::consider(const InstanceView& view, std::int32_t slot, double t_local,
                                 const LaneScales& scales, int lane, std::int32_t face, dvec2 uv,
                                 dvec3 normal, std::int32_t triangle) {
  const double t = scales.world(t_local, lane), best = state_.t(slot);
  if (!(t >= 0.0 && t <= best)) return;
  SlotHit& hit = state_.hits[slot];
  if (t == best && TileState::has(state_.has_hit, slot) &&
      !comes_before({view.index, face, uv, triangle}, hit.place))
    return;
  hit.t = t;
  hit.place.instance = view.index, hit.place.face = face, hit.place.triangle = triangle;
  hit.place.uv.x = uv.x, hit.place.uv.y = uv.y;
  hit.normal.x = normal.x, hit.normal.y = normal.y, hit.normal.z = normal.z;
  TileState::set(state_.has_hit, slot);
  // The middle ray's own length makes depth out of t, to some ulp. Not below, for comparisons.
  const double depth = t * scales.depth[lane] * (1.0 + 1e-14) - view_.reference;
  state_.best[slot] = static_cast<float>(depth + 1e-6 * std::abs(depth));
}

}  // namespace trimray::hybrid
