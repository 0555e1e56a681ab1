#include "core/hybrid/hybrid.h"

#include <functional>

#include "core/base/error.h"
#include "core/hybrid/tile_tracer.h"
#include "core/trace/caster.h"

namespace trimray::hybrid {

struct HybridView::Impl : ViewContext {
  std::function<void(const trace::Tile&, trace::TileHits&)> standard;
};

namespace {
bool fits(const raster::SeedBuffers& seeds, const view::Camera& camera) {
  const std::size_t pixels =
      static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px);
  return seeds.width_px == camera.width_px && seeds.height_px == camera.height_px &&
         seeds.id.size() == pixels &&
         (seeds.process == raster::SeedProcess::kId || seeds.uv.size() == 2 * pixels);
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
  v.standard = trace::tiles_of(camera, [&scene](std::span<const trace::Ray> rays,
                                                std::span<trace::Hit> hits) { scene.cast(rays, hits, 1); });
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
  if (tracer.crowded()) {
    impl_->standard(tile, out);
    if (stats) stats->rays += tile.rays(), stats->hits += out.hit.size(), stats->crowded += tile.rays();
    return;
  }
  tracer.seeds();
  tracer.leaves();
  tracer.edges();
  tracer.finish(out);
}

}  // namespace trimray::hybrid
