// The render loop against one ray after another: tiles lose no ray, and no choice of tiles shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>

#include "core/trace/render.h"
#include "core/view/sampling.h"
#include "tests/core/nurbs/meshes.h"

namespace trimray::trace {
namespace {

using testing::ball_mesh;
using testing::store_in_groups;

// A ball of many faces, some of them translucent.
Scene ball() {
  nurbs::NurbsStore store = store_in_groups(ball_mesh({1, 2, 3}, 2.0, 2), 5);
  for (std::size_t i = 0; i < store.faces.size(); i += 3) {
    const float color[4] = {0.9f, 0.1f * static_cast<float>(i % 7), 0.2f, i % 2 ? 0.4f : 1.0f};
    std::copy_n(color, 4, store.faces[i].color);
  }
  return Scene(std::make_shared<nurbs::NurbsStore>(std::move(store)), 1);
}

view::Camera camera_at(bool perspective) {
  const dvec3 points[2] = {{-1, 0, 1}, {3, 4, 5}};
  return view::fit(view::look(30, 20, view::UpAxis::kZ), points,
                   {.width_px = 53, .height_px = 71, .perspective = perspective});
}

RenderOptions options_for(const view::Camera& camera, int samples) {
  RenderOptions options;
  options.camera = camera;
  options.planes = {true, true, true, true, true, true, true};
  options.background = {{0.1f, 0.2f, 0.3f, 1.0f}, {0.9f, 0.8f, 0.1f, 0.25f}};
  options.samples = samples;
  return options;
}

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

bool same_bytes(const view::Frame& a, const view::Frame& b) {
  return same_bytes(a.color, b.color) && same_bytes(a.depth, b.depth) && same_bytes(a.position, b.position) &&
         same_bytes(a.normal, b.normal) && same_bytes(a.uv, b.uv) && same_bytes(a.face, b.face) &&
         same_bytes(a.instance, b.instance);
}

TEST(Tiles, HoldEveryHitOfTheirRaysInOrder) {
  const Scene scene = ball();
  for (const bool perspective : {false, true}) {
    const view::Camera camera = camera_at(perspective);
    const Caster caster = standard_caster(scene, camera);
    for (const int samples : {1, 3, 4, 700}) {
      const std::vector<dvec2> places = view::sample_pattern(samples);
      const Tile tiles[] = {{10, 20, 42, 52, places}, {3, 60, 53, 71, places}, {26, 35, 27, 36, places}};
      for (const Tile& tile : tiles) {
        if (tile.rays() > 20000) continue;
        TileHits hits;
        caster.tile(tile, hits);
        ASSERT_EQ(hits.ray.size(), hits.hit.size());
        std::size_t next = 0;
        for (std::size_t r = 0; r < tile.rays(); ++r) {
          const int pixel = static_cast<int>(r) / samples;
          const dvec2 place = places[r % samples];
          const view::CameraRay c =
              camera.ray(tile.x0 + pixel % tile.width() + place.x, tile.y0 + pixel / tile.width() + place.y);
          const Ray ray{c.org, c.dir, 0.0, kInf};
          Hit hit;
          scene.cast({&ray, 1}, {&hit, 1}, 1);
          if (hit.face == kNoFace) continue;
          ASSERT_LT(next, hits.ray.size());
          ASSERT_EQ(hits.ray[next], static_cast<std::int32_t>(r));
          ASSERT_EQ(hits.hit[next].t, hit.t);
          ASSERT_EQ(hits.hit[next].face, hit.face);
          ++next;
        }
        EXPECT_EQ(next, hits.ray.size());
      }
    }
  }
}

TEST(Tiles, EmptyTheRecordTheyAreGiven) {
  const Scene scene = ball();
  const view::Camera camera = camera_at(false);
  const dvec2 centre{0.5, 0.5};
  TileHits hits{{7}, {Hit{}}};
  standard_caster(scene, camera).tile({0, 0, 2, 2, {&centre, 1}}, hits);  // a corner of the picture
  EXPECT_TRUE(hits.ray.empty());
  EXPECT_TRUE(hits.hit.empty());
}

TEST(Render, IsTheSameForEverySizeOfTileAndNumberOfThreads) {
  const Scene scene = ball();
  for (const int samples : {1, 5}) {
    const view::Camera camera = camera_at(true);
    RenderOptions options = options_for(camera, samples);
    options.threads = 1;
    const Caster caster = standard_caster(scene, camera);
    const view::Frame frame = render(scene.store(), caster, options);
    EXPECT_GT(std::count_if(frame.face.begin(), frame.face.end(), [](int f) { return f >= 0; }), 900);
    for (const int tile : {1, 7, 64, 1000}) {
      options.tile = tile, options.threads = 2;
      EXPECT_TRUE(same_bytes(render(scene.store(), caster, options), frame)) << tile;
    }
  }
}

TEST(Render, AsksForFewerPixelsAtOnceWhereTheyHaveManySamples) {
  const Scene scene = ball();
  const view::Camera camera = camera_at(false);
  RenderOptions options = options_for(camera, 500);
  Caster caster = standard_caster(scene, camera);
  std::atomic<std::size_t> most{0}, rays{0};
  caster.tile = [&, tile = caster.tile](const Tile& t, TileHits& hits) {
    for (std::size_t seen = most; seen < t.rays() && !most.compare_exchange_weak(seen, t.rays());) {
    }
    rays += t.rays();
    hits = {};
  };
  render(scene.store(), caster, options);
  EXPECT_LE(most, 1u << 14);
  EXPECT_EQ(rays, 53u * 71u * 501u);  // the colour's, and one through each centre
}

TEST(Render, StopsWhenItIsCancelled) {
  const Scene scene = ball();
  const view::Camera camera = camera_at(false);
  const RenderOptions options = options_for(camera, 1);
  Progress progress;
  progress.cancelled = true;
  const view::Frame frame = render(scene.store(), standard_caster(scene, camera), options, &progress);
  EXPECT_EQ(progress.done, 0);
  EXPECT_EQ(*std::max_element(frame.face.begin(), frame.face.end()), kNoFace);
}

}  // namespace
}  // namespace trimray::trace
