// Rays a lane at a time: bit by bit those of Camera::ray and
// InstanceScene::local.
#include "core/hybrid/lane_rays.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstring>

#include "tests/core/hybrid/scenes.h"

namespace trimray::hybrid {
namespace {

using testing::Random;

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

view::Camera random_camera(Random& random, bool perspective) {
  view::Camera camera;
  const dmat3 axes = random.rotation();
  camera.right = axes[0], camera.up = axes[1], camera.forward = -axes[2];
  if (random.chance(0.2)) camera = view::look(90.0 * random.below(4), 0.0, view::UpAxis::kZ);
  camera.eye = random.log_between(1e-3, 1e5) * random.direction();
  camera.perspective = perspective;
  camera.pixel = random.log_between(1e-6, 10.0);
  camera.width_px = 1 + static_cast<int>(random.below(2000));
  camera.height_px = 1 + static_cast<int>(random.below(2000));
  return camera;
}

TEST(LaneRays, AreTheBitsOfTheCameraAndTheInstance) {
  Random random(5);
  nurbs::NurbsStore store = testing::bodies(true);
  const nurbs::Instance first = store.instances[0];
  store.instances.clear();
  const dmat3 mirror(dvec3(1, 0, 0), dvec3(0, -1, 0), dvec3(0, 0, 1));
  for (int i = 0; i < 60; ++i) {
    const dmat3 turn = random.rotation();
    const dmat3 sheared(dvec3(1, random.between(-1, 1), 0), dvec3(0, random.log_between(0.01, 100), 0),
                        dvec3(random.between(-1, 1), 0, random.log_between(0.01, 100)));
    const dmat3 linear[] = {dmat3(1.0),     turn,    turn * mirror, random.log_between(1e-3, 1e3) * turn,
                            turn * sheared, -sheared};
    const dvec3 shifts[] = {dvec3(0.0), random.direction(), 1e4 * random.direction()};
    store.instances.push_back(first);
    store.instances.back().placement = {linear[i % 6], shifts[i / 6 % 3]};
  }
  const trace::Scene scene(std::make_shared<nurbs::NurbsStore>(store), 2);
  std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  ASSERT_FALSE(targets.empty());
  int unit = 0, scaled = 0;
  for (const std::int64_t target : targets) {
    hwy::SetSupportedTargetsForTest(target);
    for (int i = 0; i < 4000; ++i) {
      const view::Camera camera = random_camera(random, i % 2 == 1);
      const auto index = static_cast<std::int32_t>(random.below(store.instances.size()));
      const InstanceView view(scene.impl(), camera, index);
      const int count = 1 + static_cast<int>(random.below(trace::kLanes));
      double x[trace::kLanes], y[trace::kLanes];
      for (int k = 0; k < count; ++k) {
        x[k] = random.between(0.0, camera.width_px), y[k] = random.between(0.0, camera.height_px);
        if (random.chance(0.3)) x[k] = std::floor(x[k]) + 0.5;
        if (random.chance(0.1)) x[k] = 0.5 * camera.width_px, y[k] = 0.5 * camera.height_px;
      }
      trace::RayLanes rays;
      LaneScales scales;
      lane_rays(camera, view, x, y, count, rays, scales);
      ASSERT_EQ(rays.active, (1u << count) - 1u);
      for (int k = 0; k < trace::kLanes; ++k) {
        const int from = k < count ? k : 0;
        const view::CameraRay world = camera.ray(x[from], y[from]);
        double scale;
        const trace::Ray local =
            scene.impl().instances[index].local({world.org, world.dir, 0.0, kInf}, scale);
        ASSERT_TRUE(same(rays.org_x[k], local.org.x) && same(rays.org_y[k], local.org.y) &&
                    same(rays.org_z[k], local.org.z))
            << hwy::TargetName(target) << " case " << i << " lane " << k << " instance " << index;
        ASSERT_TRUE(same(rays.dir_x[k], local.dir.x) && same(rays.dir_y[k], local.dir.y) &&
                    same(rays.dir_z[k], local.dir.z))
            << hwy::TargetName(target) << " case " << i << " lane " << k << " instance " << index;
        ASSERT_TRUE(same(scales.scale[k], scale)) << hwy::TargetName(target) << " case " << i;
        ++(scale == 1.0 ? unit : scaled);
      }
    }
  }
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_GT(unit, 1000);
  EXPECT_GT(scaled, 1000);
}

}  // namespace
}  // namespace trimray::hybrid
