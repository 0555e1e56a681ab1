#include "core/trace/bvh.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <set>

#include "core/trace/traverse.h"

namespace trimray::trace {
namespace {

std::vector<Box3> random_boxes(int count, dvec3 shift, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Box3> boxes(count);
  for (Box3& box : boxes) {
    const dvec3 p = shift + 50.0 * dvec3(unit(random), unit(random), unit(random));
    box.add(p), box.add(p + 3.0 * glm::abs(dvec3(unit(random), unit(random), unit(random))));
  }
  return boxes;
}

// In long double, no tree: does the line meet the box within [tmin, tmax]?
bool meets(const Box3& box, dvec3 org, dvec3 dir, double tmin, double tmax) {
  long double enter = tmin, leave = tmax;
  for (int a = 0; a < 3; ++a) {
    const long double lower = static_cast<long double>(box.lower[a]) - org[a],
                      upper = static_cast<long double>(box.upper[a]) - org[a];
    if (dir[a] == 0.0) {
      if (lower > 0 || upper < 0) return false;
      continue;
    }
    const long double p = lower / dir[a], q = upper / dir[a];
    enter = std::max(enter, std::min(p, q)), leave = std::min(leave, std::max(p, q));
  }
  return enter <= leave;
}

struct Visits {
  std::set<int> seen[kPacketSize];
};

void note(void* context, std::int32_t primitive, std::uint64_t rays) {
  for (; rays != 0; rays &= rays - 1)
    static_cast<Visits*>(context)->seen[std::countr_zero(rays)].insert(primitive);
}

void check(const std::vector<Box3>& boxes, dvec3 shift, bool axis_parallel) {
  const Bvh bvh = build_bvh(boxes);
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::uint64_t nodes = 0, extra = 0, met = 0;
  for (int round = 0; round < 20; ++round) {
    auto packet = std::make_unique<RayPacket>();
    auto block = std::make_unique<RayBlock>();
    auto visits = std::make_unique<Visits>();
    dvec3 org[kPacketSize], dir[kPacketSize];
    double tmin[kPacketSize], tmax[kPacketSize];
    for (int i = 0; i < kPacketSize; ++i) {
      dir[i] = glm::normalize(dvec3(unit(random), unit(random), unit(random)));
      if (axis_parallel) dir[i] = dvec3(0.0), dir[i][i % 3] = i % 2 ? 1.0 : -1.0;
      org[i] = shift + 40.0 * dvec3(unit(random), unit(random), unit(random)) - 1e3 * dir[i];
      tmin[i] = i % 5 == 0 ? 1000.0 : -kInf, tmax[i] = i % 7 == 0 ? 1010.0 : kInf;
      block->set(i, org[i], dir[i], tmin[i], tmax[i]);
    }
    packet->set(bvh, *block, ~std::uint64_t{0});
    traverse(bvh, *packet, note, visits.get(), &nodes);
    for (int i = 0; i < kPacketSize; ++i) {
      std::set<int> one;
      traverse_one(bvh, org[i], dir[i], tmin[i], tmax[i], [&](std::int32_t p) { one.insert(p); });
      for (int b = 0; b < static_cast<int>(boxes.size()); ++b) {
        if (!meets(boxes[b], org[i], dir[i], tmin[i], tmax[i])) continue;
        ++met;
        ASSERT_TRUE(visits->seen[i].count(b)) << "packet, ray " << i << " box " << b;
        ASSERT_TRUE(one.count(b)) << "one, ray " << i << " box " << b;
      }
      extra += visits->seen[i].size();
    }
  }
  ASSERT_GT(met, 100u);
  // The dilation adds next to nothing.
  EXPECT_LE(extra, met + met / 50 + 2);
}

TEST(BvhTest, NoRayMissesABoxThatItMeets) {
  check(random_boxes(500, dvec3(0.0), 1), dvec3(0.0), false);
  check(random_boxes(500, dvec3(1e5, -2e5, 3e4), 2), dvec3(1e5, -2e5, 3e4), false);
}

TEST(BvhTest, AxisParallelRaysKeepTheirSlabs) { check(random_boxes(500, dvec3(0.0), 3), dvec3(0.0), true); }

TEST(BvhTest, EmptyBoxesAreLeftOut) {
  std::vector<Box3> boxes = random_boxes(3, dvec3(0.0), 4);
  boxes.push_back({});
  const Bvh bvh = build_bvh(boxes);
  std::set<int> seen;
  for (const Box3& box : random_boxes(3, dvec3(0.0), 4))
    traverse_one(bvh, box.center() - dvec3(0, 0, 100), dvec3(0, 0, 1), 0.0, kInf,
                 [&](std::int32_t p) { seen.insert(p); });
  EXPECT_EQ(seen, (std::set<int>{0, 1, 2}));
  EXPECT_TRUE(build_bvh(std::vector<Box3>(2)).nodes.empty());
  EXPECT_TRUE(build_bvh({}).nodes.empty());
}

TEST(BvhTest, BoxesOnTopOfEachOtherDoNotDeepenTheTree) {
  std::vector<Box3> boxes(3000, Box3{dvec3(0.0), dvec3(1.0)});
  const Bvh bvh = build_bvh(boxes);
  int count = 0;
  traverse_one(bvh, dvec3(0.5, 0.5, -1), dvec3(0, 0, 1), 0.0, kInf, [&](std::int32_t) { ++count; });
  EXPECT_EQ(count, 3000);
}

TEST(BvhTest, RaysThatAreNotFiniteMeetNothing) {
  const Bvh bvh = build_bvh(random_boxes(50, dvec3(0.0), 5));
  auto packet = std::make_unique<RayPacket>();
  auto block = std::make_unique<RayBlock>();
  for (int i = 0; i < kPacketSize; ++i)
    block->set(i, dvec3(i % 2 ? kNaN : 0.0), dvec3(i % 2 ? 1.0 : kNaN, 0, 0), 0.0, kInf);
  packet->set(bvh, *block, ~std::uint64_t{0});
  EXPECT_EQ(packet->live, 0u);
}

TEST(CapsuleTest, NoRayWithinTheRadiusIsMissed) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Box3> boxes(1);
  boxes[0].add(dvec3(-10.0)), boxes[0].add(dvec3(10.0));
  const Bvh bvh = build_bvh(boxes);
  int near = 0, far_taken = 0, far = 0;
  for (int round = 0; round < 200; ++round) {
    Capsule c;
    dvec3 a, b;
    for (int k = 0; k < 3; ++k) {
      c.a[k] = static_cast<float>(5.0 * unit(random)), c.b[k] = static_cast<float>(5.0 * unit(random));
      a[k] = c.a[k], b[k] = c.b[k];
    }
    const double radius = 0.01;
    c.radius = static_cast<float>(radius + kCapsuleSlack * bvh.radius);
    auto packet = std::make_unique<RayPacket>();
    auto block = std::make_unique<RayBlock>();
    double distance[kPacketSize];
    for (int i = 0; i < kPacketSize; ++i) {
      const dvec3 dir = glm::normalize(dvec3(unit(random), unit(random), unit(random)));
      const double s = 0.5 + 0.6 * unit(random);
      const dvec3 p = a + s * (b - a) + 0.015 * dvec3(unit(random), unit(random), unit(random));
      block->set(i, p - 30.0 * dir, dir, -kInf, kInf);
      // Distance between the line and the segment, by calculus on the segment.
      const dvec3 w = (a - p) - glm::dot(a - p, dir) * dir, e = (b - a) - glm::dot(b - a, dir) * dir;
      const double at = std::clamp(-glm::dot(w, e) / glm::dot(e, e), 0.0, 1.0);
      distance[i] = glm::length(w + at * e);
    }
    packet->set(bvh, *block, ~std::uint64_t{0});
    const std::uint64_t taken = near_capsule(*packet, c, packet->live);
    for (int i = 0; i < kPacketSize; ++i) {
      const bool bit = (taken >> i) & 1;
      near += distance[i] <= radius;
      ASSERT_TRUE(bit || distance[i] > radius);
      if (distance[i] > radius + 3.0 * kCapsuleSlack * bvh.radius) ++far, far_taken += bit;
    }
  }
  EXPECT_GT(near, 1000);
  EXPECT_GT(far, 1000);
  EXPECT_EQ(far_taken, 0);
}

}  // namespace
}  // namespace trimray::trace
