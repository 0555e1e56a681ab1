#include "core/bind/casters.h"

#include <algorithm>
#include <memory>
#include <numeric>

#include "core/base/error.h"
#include "core/hybrid/hybrid.h"
#include "core/reference/reference.h"

namespace trimray::bind {
namespace {

using trace::Hit;
using trace::Ray;
using trace::Tile;
using trace::TileHits;

// The hybrid tracer holds a record for every ray of a tile.
constexpr std::size_t kPlacesAtOnce = 16;

void trace_tile(const hybrid::HybridView& view, const Tile& tile, TileHits& out) {
  if (tile.places.size() <= kPlacesAtOnce) return view.trace(tile, out);
  TileHits all, some;
  const auto places = static_cast<std::int32_t>(tile.places.size());
  for (std::size_t begin = 0; begin < tile.places.size(); begin += kPlacesAtOnce) {
    Tile part = tile;
    part.places = tile.places.subspan(begin, std::min(kPlacesAtOnce, tile.places.size() - begin));
    view.trace(part, some);
    const auto of_part = static_cast<std::int32_t>(part.places.size());
    for (const std::int32_t ray : some.ray)
      all.ray.push_back(ray / of_part * places + static_cast<std::int32_t>(begin) + ray % of_part);
    all.hit.insert(all.hit.end(), some.hit.begin(), some.hit.end());
  }
  std::vector<std::size_t> order(all.ray.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return all.ray[a] < all.ray[b]; });
  out.ray.clear(), out.hit.clear();
  for (const std::size_t i : order) out.ray.push_back(all.ray[i]), out.hit.push_back(all.hit[i]);
}

}  // namespace

trace::Caster make_caster(const std::string& mode, const trace::Scene& scene, const view::Camera& camera,
                          const raster::SeedBuffers* seeds) {
  trace::Caster caster = trace::standard_caster(scene, camera);
  if (mode == "standard") return caster;
  if (mode == "hybrid") {
    const auto view = std::make_shared<hybrid::HybridView>(scene, camera, seeds);
    caster.tile = [view](const Tile& tile, TileHits& hits) { trace_tile(*view, tile, hits); };
  } else if (mode == "reference") {
    const nurbs::NurbsStore& store = scene.store();
    caster.nearest = [&store](std::span<const Ray> rays, std::span<Hit> hits) {
      reference::cast(store, rays, hits, 1);
    };
    caster.tile = trace::tiles_of(camera, caster.nearest);
    caster.all = [&store](const Ray& ray, std::vector<Hit>& hits) { reference::cast_all(store, ray, hits); };
  } else {
    throw ArgumentError("unknown mode '" + mode + "'");
  }
  return caster;
}

}  // namespace trimray::bind
