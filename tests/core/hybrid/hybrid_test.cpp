// HybridView without seeds: bit by bit the hits of Scene::cast, whatever the
// scene, the camera and the tiles.
#include "core/hybrid/hybrid.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <thread>

#include "core/base/error.h"
#include "core/hybrid/footprint.h"
#include "tests/core/hybrid/picture.h"

namespace trimray::hybrid {
namespace {

using testing::all_cameras;
using testing::all_scenes;
using testing::expect_hybrid;
using testing::expect_same;
using testing::hits_of;
using testing::hybrid_picture;
using testing::NamedScene;
using testing::Picture;
using testing::standard_picture;

const std::vector<NamedScene>& scenes() {
  static const std::vector<NamedScene> all = all_scenes();
  return all;
}

TEST(Hybrid, GivesTheBitsOfTheStandardTracer) {
  HybridStats sums;
  for (const NamedScene& s : scenes()) {
    std::size_t met = 0;
    for (const auto& [name, camera] : all_cameras(s.bounds, 71, 66))
      for (const int samples : {1, 4}) {
        const std::vector<dvec2> places = view::sample_pattern(samples);
        const Picture expected = standard_picture(s.scene, camera, places);
        met += hits_of(expected);
        const std::string what = s.name + ", " + name + ", " + std::to_string(samples) + " samples";
        expect_hybrid(s.scene, camera, nullptr, places, 32, 32, expected, what, &sums);
        if (samples == 1) expect_hybrid(s.scene, camera, nullptr, places, 64, 64, expected, what);
      }
    EXPECT_EQ(met > 10000, s.name != "empty") << s.name << ": " << met;
  }
  EXPECT_GT(sums.edge_rays, 1000u);
  EXPECT_LT(sums.edge_rays, sums.rays / 4);
}

TEST(Hybrid, TilesOfAnySizeGiveTheSameHits) {
  const int sizes[][2] = {{2, 1}, {8, 8}, {5, 64}, {64, 3}, {33, 17}, {63, 64}, {16, 16}};
  for (const NamedScene& s : scenes())
    for (const auto& [name, camera] : all_cameras(s.bounds, 47, 65)) {
      if (name.find("whole") == name.npos && name.find("50") == name.npos) continue;
      const std::vector<dvec2> places = view::sample_pattern(2);
      const Picture expected = standard_picture(s.scene, camera, places);
      for (const auto& [width, height] : sizes)
        expect_hybrid(s.scene, camera, nullptr, places, width, height, expected, s.name + ", " + name);
    }
}

TEST(Hybrid, PlacesMayLieAnywhereInThePixel) {
  const std::vector<dvec2> places{{0, 0}, {1, 1}, {1, 0}, {0.5, 0.5}, {0, 0.999}, {0.25, 0.25}, {0.25, 0.25}};
  for (const NamedScene& s : scenes())
    for (const auto& [name, camera] : all_cameras(s.bounds, 40, 40)) {
      if (name.find("front") == name.npos && name.find("within") == name.npos) continue;
      expect_hybrid(s.scene, camera, nullptr, places, 32, 32, standard_picture(s.scene, camera, places),
                    s.name + ", " + name);
    }
}

// Rays that pass a vertex, an edge or the eye's own plane as nearly as numbers
// go: the eye stands next to places on the edges, before and behind them.
TEST(Hybrid, TheEyeMayStandOnAnEdge) {
  testing::Random random(21);
  const dvec2 centre(0.5, 0.5);
  std::size_t met = 0;
  for (const NamedScene& s : scenes()) {
    const nurbs::NurbsStore& store = s.scene.store();
    if (store.edges.empty()) continue;
    for (int i = 0; i < 40; ++i) {
      const nurbs::Edge& edge = store.edges[random.below(store.edges.size())];
      const nurbs::Instance& instance = store.instances[random.below(store.instances.size())];
      if (edge.pieces.size() == 0) continue;
      const nurbs::Range& r = store.edge_pieces[edge.pieces.begin].ctrl;
      const dvec4 h = random.chance(0.5) ? store.edge_ctrl_h[r.begin]
                                         : 0.5 * (store.edge_ctrl_h[r.begin] + store.edge_ctrl_h[r.end - 1]);
      const dvec3 target = instance.placement.point(dvec3(h) / h.w);
      const dmat3 axes = random.rotation();
      view::Camera camera;
      camera.right = axes[0], camera.up = axes[1], camera.forward = -axes[2];
      camera.width_px = camera.height_px = 12;
      camera.perspective = random.chance(0.5);
      camera.pixel =
          camera.perspective ? random.log_between(1e-3, 1e-1) : edge.band * random.log_between(1e-2, 1e3);
      camera.eye = target + edge.band * random.between(-8.0, 8.0) * camera.forward +
                   edge.band * random.between(-1.0, 1.0) * camera.right;
      const Picture expected = standard_picture(s.scene, camera, {&centre, 1});
      met += hits_of(expected);
      expect_hybrid(s.scene, camera, nullptr, {&centre, 1}, 12, 12, expected,
                    s.name + ", eye " + std::to_string(i));
    }
  }
  EXPECT_GT(met, 5000u);
}

TEST(Hybrid, AnswersDoNotDependOnTheMachine) {
  const std::vector<dvec2> places = view::sample_pattern(2);
  for (const NamedScene& s : scenes()) {
    const view::Camera camera = all_cameras(s.bounds, 50, 40)[s.name.size() % 2 ? 0 : 6].camera;
    const Picture expected = standard_picture(s.scene, camera, places);
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      expect_hybrid(s.scene, camera, nullptr, places, 32, 32, expected, s.name + hwy::TargetName(target));
    }
    hwy::SetSupportedTargetsForTest(0);
  }
}

TEST(Hybrid, ManyThreadsMayShareAView) {
  const NamedScene& s = scenes().back().name == "empty" ? scenes()[scenes().size() - 4] : scenes().back();
  const view::Camera camera = all_cameras(s.bounds, 90, 80)[6].camera;
  const std::vector<dvec2> places = view::sample_pattern(4);
  const Picture expected = standard_picture(s.scene, camera, places);
  const HybridView view(s.scene, camera, nullptr, kInf);
  Picture got[4];
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&, i] {
      HybridStats stats;
      got[i] = hybrid_picture(view, camera, places, 64 - 15 * i, 40 + 8 * i, stats);
    });
  for (std::thread& t : threads) t.join();
  for (int i = 0; i < 4; ++i) expect_same(expected, got[i], "thread " + std::to_string(i));
  EXPECT_GT(hits_of(expected), 1000u);
}

// Where leaves crowd, packets take over: on some tiles, on all, or on none.
TEST(Hybrid, CrowdedTilesGiveTheSameBits) {
  const std::vector<dvec2> places = view::sample_pattern(4);
  for (const NamedScene& s : scenes())
    for (const auto& [name, camera] : all_cameras(s.bounds, 67, 45)) {
      if (name.find("whole") == name.npos) continue;
      const Picture expected = standard_picture(s.scene, camera, places);
      std::uint64_t last = 0;
      for (const double leaves : {kInf, 1.0, 0.1, 0.0}) {
        HybridStats stats;
        const HybridView view(s.scene, camera, nullptr, leaves);
        expect_same(expected, hybrid_picture(view, camera, places, 16, 16, stats), s.name + ", " + name);
        EXPECT_GE(stats.crowded, last);
        EXPECT_EQ(stats.rays, places.size() * 67 * 45);
        last = stats.crowded;
        EXPECT_TRUE(leaves < kInf || stats.crowded == 0);
      }
      EXPECT_GE(last, hits_of(expected));
    }
}

TEST(Hybrid, TilesAboveTheLargestAreRefused) {
  const NamedScene& s = scenes()[0];
  view::Camera camera = all_cameras(s.bounds, 200, 200)[0].camera;
  const HybridView view(s.scene, camera, nullptr);
  const dvec2 centre(0.5, 0.5);
  trace::TileHits hits;
  EXPECT_THROW(view.trace({0, 0, kMaxTile + 1, 8, {&centre, 1}}, hits), ArgumentError);
  EXPECT_THROW(view.trace({0, 0, 8, kMaxTile + 1, {&centre, 1}}, hits), ArgumentError);
  EXPECT_THROW(view.trace({-1, 0, 8, 8, {&centre, 1}}, hits), ArgumentError);
  EXPECT_THROW(view.trace({0, 1 << 20, 8, (1 << 20) + 8, {&centre, 1}}, hits), ArgumentError);
  EXPECT_NO_THROW(view.trace({7, 9, 7 + kMaxTile, 9 + kMaxTile, {&centre, 1}}, hits));
}

TEST(Hybrid, StatsAreAddedToThoseGiven) {
  const NamedScene& s = scenes()[0];
  const view::Camera camera = all_cameras(s.bounds, 64, 64)[0].camera;
  const HybridView view(s.scene, camera, nullptr, kInf);
  const std::vector<dvec2> places = view::sample_pattern(4);
  trace::TileHits hits, again;
  HybridStats stats;
  view.trace({0, 0, 64, 64, places}, hits, &stats);
  const HybridStats once = stats;
  EXPECT_EQ(once.rays, 64u * 64u * 4u);
  EXPECT_EQ(once.hits, hits.ray.size());
  EXPECT_GT(once.hits, 1000u);
  EXPECT_GT(once.candidates, 0u);
  EXPECT_GE(once.solves, once.hits);
  view.trace({0, 0, 64, 64, places}, again, &stats);
  EXPECT_EQ(again.ray, hits.ray);
  EXPECT_EQ(stats.rays, 2 * once.rays);
  EXPECT_EQ(stats.hits, 2 * once.hits);
  EXPECT_EQ(stats.solves, 2 * once.solves);
  EXPECT_EQ(stats.candidates, 2 * once.candidates);
  EXPECT_EQ(stats.edge_rays, 2 * once.edge_rays);
  view.trace({0, 0, 64, 64, places}, again);  // nobody counts
  EXPECT_EQ(again.ray, hits.ray);
}

}  // namespace
}  // namespace trimray::hybrid
