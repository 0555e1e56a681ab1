#include "core/view/camera.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace trimray::view {
namespace {

std::vector<dvec3> box_corners(const dvec3& lower, const dvec3& upper) {
  std::vector<dvec3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back({i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
  }
  return corners;
}

// Where a camera puts a point, in px.
dvec2 project(const Camera& camera, const dvec3& p) {
  const dvec3 d = p - camera.eye;
  const double scale = camera.perspective ? camera.pixel * glm::dot(d, camera.forward) : camera.pixel;
  return {0.5 * camera.width_px + glm::dot(d, camera.right) / scale,
          0.5 * camera.height_px - glm::dot(d, camera.up) / scale};
}

void expect_vector(const dvec3& a, const dvec3& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-15);
}

constexpr UpAxis kAxes[6] = {UpAxis::kX,      UpAxis::kY,      UpAxis::kZ,
                             UpAxis::kMinusX, UpAxis::kMinusY, UpAxis::kMinusZ};
const dvec3 kAxisVectors[6] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};

TEST(Camera, NamedViewsWithZUpAreExact) {
  const Camera front = look(0, 0, UpAxis::kZ), right = look(90, 0, UpAxis::kZ), top = look(0, 90, UpAxis::kZ);
  EXPECT_EQ(front.forward, dvec3(0, 1, 0));
  EXPECT_EQ(front.right, dvec3(1, 0, 0));
  EXPECT_EQ(front.up, dvec3(0, 0, 1));
  EXPECT_EQ(right.forward, dvec3(-1, 0, 0));
  EXPECT_EQ(right.right, dvec3(0, 1, 0));
  EXPECT_EQ(top.forward, dvec3(0, 0, -1));
  EXPECT_EQ(top.up, dvec3(0, 1, 0));
  EXPECT_EQ(look(180, 0, UpAxis::kZ).forward, dvec3(0, -1, 0));
  EXPECT_EQ(look(270, 0, UpAxis::kZ).forward, look(-90, 0, UpAxis::kZ).forward);
  EXPECT_EQ(look(0, -90, UpAxis::kZ).forward, dvec3(0, 0, 1));
}

TEST(Camera, DirectionsAreOrthonormalAndRightHandedForEveryUpAxis) {
  for (int a = 0; a < 6; ++a) {
    for (double azimuth = -170; azimuth <= 360; azimuth += 37) {
      for (double elevation = -90; elevation <= 90; elevation += 22.5) {
        const Camera c = look(azimuth, elevation, kAxes[a]);
        expect_vector(glm::cross(c.right, c.up), -c.forward);
        EXPECT_NEAR(glm::length(c.right), 1.0, 1e-15);
        EXPECT_NEAR(glm::length(c.up), 1.0, 1e-15);
        EXPECT_NEAR(glm::dot(c.right, c.up), 0.0, 1e-15);
        EXPECT_NEAR(glm::dot(c.right, kAxisVectors[a]), 0.0, 1e-15);  // the horizon is level
        EXPECT_GE(glm::dot(c.up, kAxisVectors[a]), -1e-15);           // and up is up
      }
    }
  }
}

TEST(Camera, FitPutsEveryPointWithinTheMarginAndTouchesItOnTwoSides) {
  const std::vector<dvec3> corners = box_corners({-10, 3, 100000}, {40, 33, 100007});
  for (const bool perspective : {false, true}) {
    for (const double elevation : {-90.0, -20.0, 0.0, 35.0, 90.0}) {
      const FitOptions options{.width_px = 640, .height_px = 400, .perspective = perspective};
      const Camera c = fit(look(45, elevation, UpAxis::kZ), corners, options);
      const double border = options.margin * 400;
      double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
      for (const dvec3& p : corners) {
        const dvec2 q = project(c, p);
        left = std::min(left, q.x), right = std::max(right, q.x), top = std::min(top, q.y),
        bottom = std::max(bottom, q.y);
        EXPECT_GT(glm::dot(p - c.eye, c.forward), 0.0);
      }
      EXPECT_GE(left, border - 1e-6);
      EXPECT_LE(right, 640 - border + 1e-6);
      EXPECT_GE(top, border - 1e-6);
      EXPECT_LE(bottom, 400 - border + 1e-6);
      const bool touches_width = std::abs(left - border) < 1e-6 && std::abs(right - 640 + border) < 1e-6;
      const bool touches_height = std::abs(top - border) < 1e-6 && std::abs(bottom - 400 + border) < 1e-6;
      EXPECT_TRUE(touches_width || touches_height);
    }
  }
}

TEST(Camera, RayThroughAProjectedPointMeetsThePoint) {
  const std::vector<dvec3> corners = box_corners({-1, -2, -3}, {4, 5, 6});
  for (const bool perspective : {false, true}) {
    const Camera c = fit(look(30, 20, UpAxis::kY), corners, {.perspective = perspective});
    for (const dvec3& p : corners) {
      const dvec2 q = project(c, p);
      const CameraRay ray = c.ray(q.x, q.y);
      EXPECT_NEAR(glm::length(ray.dir), 1.0, 1e-15);
      EXPECT_NEAR(glm::length(glm::cross(p - ray.org, ray.dir)), 0.0, 1e-12);
    }
  }
}

TEST(Camera, FitOfAPointALineAndNothingIsFinite) {
  for (const bool perspective : {false, true}) {
    for (const std::vector<dvec3>& points :
         {std::vector<dvec3>{}, {{5, 5, 5}}, {{0, 0, 0}, {0, 10, 0}}, {{0, 0, 0}, {0, 0, 1e-9}}}) {
      const Camera c = fit(look(0, 0, UpAxis::kZ), points, {.perspective = perspective});
      EXPECT_GT(c.pixel, 0.0);
      EXPECT_TRUE(std::isfinite(c.pixel) && std::isfinite(glm::length(c.eye)));
      for (const dvec3& p : points) EXPECT_GT(glm::dot(p - c.eye, c.forward), 0.0);
    }
  }
}

TEST(Camera, TurningIsLookingFromAnotherAzimuth) {
  for (const UpAxis up : {UpAxis::kX, UpAxis::kY, UpAxis::kZ, UpAxis::kMinusX, UpAxis::kMinusZ}) {
    for (const double angle : {0.0, 37.5, 90.0, -200.0, 360.0}) {
      Camera camera = look(20.0, 35.0, up);
      camera.eye = {3.0, -2.0, 5.0};
      const dvec3 pivot{1.0, 7.0, -4.0};
      const Camera turn = turned(camera, angle, pivot, up), wanted = look(20.0 + angle, 35.0, up);
      EXPECT_LT(glm::length(turn.right - wanted.right), 1e-14);
      EXPECT_LT(glm::length(turn.up - wanted.up), 1e-14);
      EXPECT_LT(glm::length(turn.forward - wanted.forward), 1e-14);
      // The pivot is seen at the same place, from as far.
      const dvec3 before = pivot - camera.eye, after = pivot - turn.eye;
      EXPECT_NEAR(glm::dot(before, camera.right), glm::dot(after, turn.right), 1e-13);
      EXPECT_NEAR(glm::dot(before, camera.up), glm::dot(after, turn.up), 1e-13);
      EXPECT_NEAR(glm::dot(before, camera.forward), glm::dot(after, turn.forward), 1e-13);
      if (angle == 0.0) {
        EXPECT_LT(glm::length(turn.eye - camera.eye), 1e-14);
      }
    }
  }
}

}  // namespace
}  // namespace trimray::view
