// The hybrid tracer's pictures against those of Scene::cast, bit by bit.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "core/hybrid/hybrid.h"
#include "core/view/sampling.h"
#include "tests/core/hybrid/scenes.h"

namespace trimray::testing {

// Hits by ((y * width + x) * places + place); what a ray without a hit holds is
// Hit{}.
using Picture = std::vector<trace::Hit>;

inline Picture standard_picture(const trace::Scene& scene, const view::Camera& camera,
                                std::span<const dvec2> places) {
  std::vector<trace::Ray> rays;
  for (int y = 0; y < camera.height_px; ++y)
    for (int x = 0; x < camera.width_px; ++x)
      for (const dvec2& place : places) {
        const view::CameraRay ray = camera.ray(x + place.x, y + place.y);
        rays.push_back({ray.org, ray.dir, 0.0, kInf});
      }
  Picture picture(rays.size());
  scene.cast(rays, picture, 2);
  return picture;
}

// Tile by tile; checks what TileHits promise.
inline Picture hybrid_picture(const hybrid::HybridView& view, const view::Camera& camera,
                              std::span<const dvec2> places, int tile_width, int tile_height,
                              hybrid::HybridStats& stats) {
  Picture picture(static_cast<std::size_t>(camera.width_px) * camera.height_px * places.size());
  trace::TileHits hits{{5, 4}, {trace::Hit{}}};  // whatever was there goes
  for (int y = 0; y < camera.height_px; y += tile_height)
    for (int x = 0; x < camera.width_px; x += tile_width) {
      const trace::Tile tile{x, y, std::min(x + tile_width, camera.width_px),
                             std::min(y + tile_height, camera.height_px), places};
      view.trace(tile, hits, &stats);
      EXPECT_EQ(hits.ray.size(), hits.hit.size());
      for (std::size_t i = 0; i < hits.ray.size(); ++i) {
        const std::int32_t ray = hits.ray[i];
        if (ray < 0 || static_cast<std::size_t>(ray) >= tile.rays() || (i > 0 && ray <= hits.ray[i - 1])) {
          ADD_FAILURE() << "ray " << ray << " of " << tile.rays() << " after "
                        << (i > 0 ? hits.ray[i - 1] : -1);
          return picture;
        }
        EXPECT_NE(hits.hit[i].face, kNoFace);
        const std::size_t count = places.size(), pixel = ray / count;
        const std::size_t px = x + pixel % tile.width(), py = y + pixel / tile.width();
        picture[(py * camera.width_px + px) * count + ray % count] = hits.hit[i];
      }
    }
  return picture;
}

inline bool same_bits(const trace::Hit& a, const trace::Hit& b) {
  return a.face == b.face && a.instance == b.instance && std::memcmp(&a.t, &b.t, sizeof a.t) == 0 &&
         std::memcmp(&a.uv_face, &b.uv_face, sizeof a.uv_face) == 0 &&
         std::memcmp(&a.normal, &b.normal, sizeof a.normal) == 0;
}

inline std::size_t hits_of(const Picture& picture) {
  return std::count_if(picture.begin(), picture.end(), [](const trace::Hit& h) { return h.face != kNoFace; });
}

// Returns whether they are the same.
inline bool expect_same(const Picture& expected, const Picture& got, const std::string& what) {
  if (expected.size() != got.size()) {
    ADD_FAILURE() << what << ": sizes";
    return false;
  }
  int wrong = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    const trace::Hit &a = expected[i], &b = got[i];
    if (same_bits(a, b)) continue;
    if (++wrong == 1)
      ADD_FAILURE() << what << ": ray " << i << " meets face " << b.face << " of instance " << b.instance
                    << " at t " << b.t << ", not " << a.face << " of " << a.instance << " at " << a.t
                    << ", a difference of " << b.t - a.t << "; uv apart by "
                    << glm::length(b.uv_face - a.uv_face) << ", normals by "
                    << glm::length(b.normal - a.normal);
  }
  if (wrong > 1) ADD_FAILURE() << what << ": " << wrong << " rays of " << got.size();
  return wrong == 0;
}

// Traces with tiles of one size and compares; the stats must add up too.
inline bool expect_hybrid(const trace::Scene& scene, const view::Camera& camera,
                          const raster::SeedBuffers* seeds, std::span<const dvec2> places, int tile_width,
                          int tile_height, const Picture& expected, const std::string& what,
                          hybrid::HybridStats* sums = nullptr) {
  const hybrid::HybridView view(scene, camera, seeds, kInf);
  hybrid::HybridStats stats;
  const Picture got = hybrid_picture(view, camera, places, tile_width, tile_height, stats);
  EXPECT_EQ(stats.rays, expected.size()) << what;
  EXPECT_EQ(stats.hits, hits_of(got)) << what;
  EXPECT_TRUE(seeds != nullptr || stats.seeded == 0) << what;
  EXPECT_LE(stats.open, stats.newton_roots) << what;
  EXPECT_LE(stats.newton_roots, stats.solves) << what;
  EXPECT_LE(stats.edge_rays, stats.rays) << what;
  if (sums) {
    sums->rays += stats.rays, sums->hits += stats.hits, sums->seeded += stats.seeded;
    sums->solves += stats.solves, sums->edge_rays += stats.edge_rays;
  }
  return expect_same(expected, got,
                     what + ", tiles of " + std::to_string(tile_width) + " x " + std::to_string(tile_height));
}

}  // namespace trimray::testing
