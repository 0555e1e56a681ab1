// The walk with a tile's rays against every box and every ray, one by one.
#include "core/hybrid/tile_walk.h"

#include <gtest/gtest.h>

#include "tests/core/hybrid/tile_rays.h"

namespace trimray::hybrid {
namespace {

using testing::Random;
using testing::random_tile;
using testing::TileView;

// Boxes in the prototype about where the picture looks: big ones, flat ones,
// points, some round the eye.
std::vector<Box3> random_boxes(Random& random, const TileView& view) {
  std::vector<Box3> boxes(random.below(3) == 0 ? random.below(4) : 1 + random.below(300));
  for (Box3& box : boxes) {
    const dvec2 at(random.between(view.rect.x0 - 40, view.rect.x1 + 40),
                   random.between(view.rect.y0 - 40, view.rect.y1 + 40));
    const double depth =
        random.chance(0.2) ? view.depth * random.between(-1.0, 0.2) : view.depth * random.between(0.5, 1.5);
    const dvec3 middle = random.chance(0.7) ? view.to_prototype(view.point(at, depth))
                                            : view.target + view.size * random.unit() * random.direction();
    dvec3 half;
    for (int a = 0; a < 3; ++a)
      half[a] = random.chance(0.2) ? 0.0 : view.size * random.log_between(1e-7, 0.3);
    box.add(middle - half), box.add(middle + half);
  }
  return boxes;
}

// Depth at which the ray through a place enters the box, before the eye;
// infinite where it does not.
double entry(const TileView& view, const dvec2& at, const Box3& box) {
  const dvec3 o = view.to_prototype(view.point(at, 0.0)), q = view.to_prototype(view.point(at, 1.0));
  const dvec3 d = q - o;
  double near = 0.0, far = kInf;
  for (int a = 0; a < 3; ++a) {
    if (d[a] == 0.0) {
      if (o[a] < box.lower[a] || o[a] > box.upper[a]) return kInf;
      continue;
    }
    const double s = (box.lower[a] - o[a]) / d[a], t = (box.upper[a] - o[a]) / d[a];
    near = std::max(near, std::min(s, t)), far = std::min(far, std::max(s, t));
  }
  return near <= far ? near : kInf;
}

// For each box the nearest depth at which some ray of the tile enters it:
// corners, sides and inner places.
std::vector<double> entries(Random& random, const TileView& view, const std::vector<Box3>& boxes) {
  std::vector<dvec2> places;
  for (int x = 0; x <= 8; ++x)
    for (int y = 0; y <= 8; ++y)
      places.push_back(view.at(0, 0, dvec2(view.width * x / 8.0, view.height * y / 8.0)));
  for (int i = 0; i < 60; ++i)
    places.push_back(view.at(0, 0, dvec2(view.width * random.unit(), view.height * random.unit())));
  std::vector<double> nearest;
  for (const Box3& box : boxes) {
    double near = kInf;
    for (const dvec2& at : places) near = std::min(near, entry(view, at, box));
    nearest.push_back(near);
  }
  return nearest;
}

TEST(TileWalk, VisitsWhatTheRaysMeet) {
  Random random(1);
  long met = 0, visited = 0, boxes_seen = 0, within = 0;
  for (int i = 0; i < 600; ++i) {
    const TileView view = random_tile(random, i % 3 == 0 ? 0.0 : random.log_between(0.1, 1e3),
                                      i % 2 ? 1.0 : random.log_between(1.0, 1e3));
    const std::vector<Box3> boxes = random_boxes(random, view);
    const trace::Bvh bvh = trace::build_bvh(boxes);
    const double reference = random.chance(0.3) ? 0.0 : view.depth * random.between(-2.0, 4.0);
    const TileSpace space(view.frame, bvh, view.rect, reference);
    const std::vector<double> nearest = entries(random, view, boxes);
    // All, then all before a limit, then with a limit that shrinks.
    std::vector<int> seen(boxes.size(), 0);
    std::vector<float> near_of(boxes.size(), kInf);
    const std::uint64_t opened = walk_tile(
        bvh, space, [] { return 1e30f; }, [&](std::int32_t p, float near) { ++seen[p], near_of[p] = near; });
    EXPECT_EQ(opened > 0, !boxes.empty());
    const float limit = static_cast<float>(view.depth * random.between(0.6, 1.4) - reference);
    std::vector<int> seen_before(boxes.size(), 0);
    int beyond = 0;
    const std::uint64_t fewer = walk_tile(
        bvh, space, [&] { return limit; },
        [&](std::int32_t p, float near) { ++seen_before[p], beyond += near > limit; });
    EXPECT_LE(fewer, opened);
    EXPECT_EQ(beyond, 0);
    float shrinking = 1e30f;
    std::vector<int> seen_shrinking(boxes.size(), 0);
    walk_tile(
        bvh, space, [&] { return shrinking; },
        [&](std::int32_t p, float) {
          ++seen_shrinking[p];
          // What the rays meet in this box ends at its nearest entry, if they
          // meet it at all.
          if (nearest[p] < kInf)
            shrinking = std::min(shrinking, static_cast<float>(nearest[p] - reference + 0.1 * view.size));
        });
    for (std::size_t p = 0; p < boxes.size(); ++p) {
      ++boxes_seen, visited += seen[p];
      ASSERT_LE(seen[p], 1);
      ASSERT_LE(seen_before[p], seen[p]);
      ASSERT_LE(seen_shrinking[p], seen[p]);
      ASSERT_EQ(seen_before[p] > 0, seen[p] && near_of[p] <= limit) << i;
      if (nearest[p] == kInf) continue;
      ++met;
      const double depth = nearest[p] - reference;
      ASSERT_EQ(seen[p], 1) << i << " box " << p
                            << (view.frame.perspective ? " perspective" : " orthographic") << " entered at "
                            << depth;
      ASSERT_LE(near_of[p], depth) << i << " box " << p;
      within += depth <= limit;
      ASSERT_TRUE(seen_before[p] || depth > limit) << i << " box " << p;
      ASSERT_TRUE(seen_shrinking[p] || depth > shrinking) << i << " box " << p;
    }
  }
  EXPECT_GT(met, 3000);
  EXPECT_GT(within, 1000);
  EXPECT_GT(met, within + 1000);
  EXPECT_LT(visited, boxes_seen - 10000);  // not simply all of them
}

// Small boxes all round the model: a tile visits few more than it meets.
TEST(TileWalk, VisitsLittleElse) {
  Random random(2);
  long met = 0, visited = 0, boxes_seen = 0, above = 0;
  for (int i = 0; i < 300; ++i) {
    const TileView view = random_tile(random, 1.0, 1.0);
    std::vector<Box3> boxes(500);
    for (Box3& box : boxes) {
      const dvec3 middle = view.target + view.size * random.unit() * random.direction();
      const double half = view.size * random.between(0.005, 0.02);
      box.add(middle - half), box.add(middle + half);
    }
    const trace::Bvh bvh = trace::build_bvh(boxes);
    const std::vector<double> nearest = entries(random, view, boxes);
    walk_tile(
        bvh, TileSpace(view.frame, bvh, view.rect, view.depth), [] { return 1e30f; },
        [&](std::int32_t p, float near) {
          ++visited;
          if (nearest[p] == kInf) return;
          above += near > nearest[p] - view.depth - 0.1 * view.size;
        });
    for (const double n : nearest) met += n < kInf;
    boxes_seen += static_cast<long>(boxes.size());
  }
  EXPECT_GT(met, 300);
  EXPECT_LT(visited, 3 * met) << met;
  EXPECT_LT(visited, boxes_seen / 5);
  EXPECT_GT(above, met / 2);  // near is not far too near
}

}  // namespace
}  // namespace trimray::hybrid
