// The rays of one tile on their way to their first hits.
#pragma once

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
  // A root inside the loops; normal: outward, in the prototype.
  void consider(const InstanceView& view, std::int32_t slot, double t_local, const LaneScales& scales,
                int lane, std::int32_t face, dvec2 uv, const dvec3& normal, std::int32_t triangle = -1);
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

}  // namespace trimray::hybrid
