#include "core/hybrid/hybrid.h"

#include "core/base/error.h"
#include "core/hybrid/tile_tracer.h"
#include "core/trace/caster.h"

namespace trimray::hybrid {

struct HybridView::Impl : ViewContext {};

namespace {
bool fits(const raster::SeedBuffers& seeds, const view::Camera& camera) {
  const std::size_t pixels =
      static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px);
  return seeds.width_px == camera.width_px && seeds.height_px == camera.height_px &&
         seeds.id.size() == pixels &&
         (seeds.process == raster::SeedProcess::kId || seeds.uv.size() == 2 * pixels);
}

void by_packets(const ViewContext& view, const trace::Tile& tile, trace::TileHits& out, HybridStats* stats) {
  trace::TraceStats counters;
  trace::tiles_of(view.camera, [&](std::span<const trace::Ray> rays, std::span<trace::Hit> hits) {
    view.scene->nearest(rays, hits, counters);
  })(tile, out);
  if (stats == nullptr) return;
  stats->rays += tile.rays(), stats->crowded += tile.rays(), stats->hits += out.hit.size();
  stats->solves += counters.leaves, stats->open += counters.fallbacks, stats->edge_rays += counters.edge_rays;
}

}  // namespace

HybridView::HybridView(const trace::Scene& scene, const view::Camera& camera,
                       const raster::SeedBuffers* seeds, double crowded_leaves)
    : impl_(std::make_unique<Impl>()) {
  Impl& v = *impl_;
  v.scene = &scene.impl();
  v.camera = camera;
  v.crowded_leaves = crowded_leaves;
  v.world = CameraFrame(camera, {});
  if (seeds != nullptr && !fits(*seeds, camera))
    throw ArgumentError("seeds are of another size than the picture");
  v.seeds = seeds;
  const trace::Bvh& bvh = v.scene->bvh;
  v.reference = bvh.nodes.empty() ? 0.0 : v.world.point(bvh.center).z;
  v.instances.reserve(v.scene->instances.size());
  for (std::size_t i = 0; i < v.scene->instances.size(); ++i)
    v.instances.emplace_back(*v.scene, camera, static_cast<std::int32_t>(i));
}

HybridView::HybridView(HybridView&&) noexcept = default;
HybridView::~HybridView() = default;

void HybridView::trace(const trace::Tile& tile, trace::TileHits& out, HybridStats* stats) const {
  if (tile.width() > kMaxTile || tile.y1 - tile.y0 > kMaxTile) throw ArgumentError("tile: too large");
  const view::Camera& camera = impl_->camera;
  if (tile.x0 < 0 || tile.y0 < 0 || tile.x1 > camera.width_px || tile.y1 > camera.height_px)
    throw ArgumentError("tile: outside of the picture");
  out.ray.clear(), out.hit.clear();
  thread_local TileState state;
  HybridStats unused;
  TileTracer tracer(*impl_, tile, state, stats ? *stats : unused);
  if (tracer.crowded()) return by_packets(*impl_, tile, out, stats);
  tracer.seeds();
  tracer.leaves();
  tracer.edges();
  tracer.finish(out);
}

}  // namespace trimray::hybrid
