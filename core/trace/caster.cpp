#include "core/trace/caster.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/trace/scene_impl.h"

namespace trimray::trace {
namespace {

constexpr std::size_t kRaysAtOnce = 512;  // of a tile, so that they and their hits stay in cache

// Every second bit of a place on the Z-order curve.
int every_second_bit(std::uint32_t z) {
  z &= 0x55555555u;
  z = (z | (z >> 1)) & 0x33333333u;
  z = (z | (z >> 2)) & 0x0f0f0f0fu;
  z = (z | (z >> 4)) & 0x00ff00ffu;
  return static_cast<int>((z | (z >> 8)) & 0x0000ffffu);
}

// Collects the hits of rays that come in any order.
class Collector {
 public:
  Collector(TileHits& out, std::size_t rays) : out_(out), rays_(rays) { out.ray.clear(), out.hit.clear(); }

  void add(std::int32_t ray, const Hit& hit) { found_.push_back({ray, hit}); }

  void finish() {
    if (found_.empty()) return;
    std::vector<std::int32_t> place(rays_, -1);
    for (std::size_t i = 0; i < found_.size(); ++i) place[found_[i].ray] = static_cast<std::int32_t>(i);
    out_.ray.reserve(found_.size()), out_.hit.reserve(found_.size());
    for (std::size_t ray = 0; ray < rays_; ++ray) {
      if (place[ray] < 0) continue;
      out_.ray.push_back(static_cast<std::int32_t>(ray));
      out_.hit.push_back(found_[place[ray]].hit);
    }
  }

 private:
  struct Found {
    std::int32_t ray = 0;
    Hit hit;
  };
  TileHits& out_;
  std::size_t rays_;
  std::vector<Found> found_;
};

// The pixels of the tile along the Z-order curve: any 64 rays in a row, a packet, stay within a small square.
void cast_tile(const view::Camera& camera,
               const std::function<void(std::span<const Ray>, std::span<Hit>)>& nearest, const Tile& tile,
               TileHits& out) {
  Collector collector(out, tile.rays());
  std::array<Ray, kRaysAtOnce> rays;
  std::array<Hit, kRaysAtOnce> hits;
  std::array<std::int32_t, kRaysAtOnce> number;
  std::size_t count = 0;
  const auto cast = [&] {
    if (count == 0) return;
    nearest(std::span(rays).first(count), std::span(hits).first(count));
    for (std::size_t i = 0; i < count; ++i)
      if (hits[i].face != kNoFace) collector.add(number[i], hits[i]);
    count = 0;
  };
  const int width = tile.x1 - tile.x0, height = tile.y1 - tile.y0;
  const auto side = std::bit_ceil(static_cast<std::uint32_t>(std::max({width, height, 1})));
  const auto places = static_cast<std::int32_t>(tile.places.size());
  for (std::uint32_t z = 0; z < side * side; ++z) {
    const int x = every_second_bit(z), y = every_second_bit(z >> 1);
    if (x >= width || y >= height) continue;
    for (std::int32_t s = 0; s < places; ++s) {
      const view::CameraRay ray = camera.ray(tile.x0 + x + tile.places[s].x, tile.y0 + y + tile.places[s].y);
      rays[count] = {ray.org, ray.dir, 0.0, kInf};
      number[count] = (y * width + x) * places + s;
      if (++count == kRaysAtOnce) cast();
    }
  }
  cast();
  collector.finish();
}

}  // namespace

std::function<void(const Tile&, TileHits&)> tiles_of(
    const view::Camera& camera, std::function<void(std::span<const Ray>, std::span<Hit>)> nearest) {
  return [camera, nearest = std::move(nearest)](const Tile& tile, TileHits& out) {
    cast_tile(camera, nearest, tile, out);
  };
}

Caster standard_caster(const Scene& scene, const view::Camera& camera) {
  Caster caster;
  caster.nearest = [&scene](std::span<const Ray> rays, std::span<Hit> hits) { scene.cast(rays, hits, 1); };
  caster.tile = tiles_of(camera, caster.nearest);
  caster.all = [&scene](const Ray& ray, std::vector<Hit>& hits) { scene.cast_all(ray, hits); };
  caster.edge_band = scene.impl().edge_reach * kGrazing;
  return caster;
}

}  // namespace trimray::trace
