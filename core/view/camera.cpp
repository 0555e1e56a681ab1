#include "core/view/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trimray::view {

CameraRay Camera::ray(double x_px, double y_px) const {
  const double x = (x_px - 0.5 * width_px) * pixel;
  const double y = (0.5 * height_px - y_px) * pixel;
  if (perspective) return {eye, glm::normalize(forward + x * right + y * up)};
  return {eye + x * right + y * up, forward};
}

namespace {

// Cosine and sine of an angle in degrees, exact at the multiples of 90 that named views use.
void cos_sin_deg(double angle_deg, double& c, double& s) {
  const double turn = std::remainder(angle_deg, 360.0);
  if (std::remainder(turn, 90.0) == 0.0) {
    const int quarter = (static_cast<int>(std::lround(turn / 90.0)) + 4) % 4;
    constexpr double kCos[4] = {1, 0, -1, 0};
    constexpr double kSin[4] = {0, 1, 0, -1};
    c = kCos[quarter], s = kSin[quarter];
    return;
  }
  const double angle = turn * std::numbers::pi / 180.0;
  c = std::cos(angle), s = std::sin(angle);
}

// Right and up of the front view; the third, towards the eye, is their cross product.
void front_axes(UpAxis axis, dvec3& right, dvec3& up) {
  switch (axis) {
    case UpAxis::kX:
      right = {0, 1, 0}, up = {1, 0, 0};
      break;
    case UpAxis::kY:
      right = {1, 0, 0}, up = {0, 1, 0};
      break;
    case UpAxis::kZ:
      right = {1, 0, 0}, up = {0, 0, 1};
      break;
    case UpAxis::kMinusX:
      right = {0, 1, 0}, up = {-1, 0, 0};
      break;
    case UpAxis::kMinusY:
      right = {1, 0, 0}, up = {0, -1, 0};
      break;
    case UpAxis::kMinusZ:
      right = {1, 0, 0}, up = {0, 0, -1};
      break;
  }
}

struct Interval {
  double lower = kInf, upper = -kInf;
  void add(double x) { lower = std::min(lower, x), upper = std::max(upper, x); }
};

// How near to the foremost point the eye of an orthographic camera stands, as a fraction of the depth.
constexpr double kEyeGap = 0.05;

Camera fit_orthographic(Camera camera, std::span<const dvec3> points, double half_width, double half_height) {
  Interval x, y, z;
  for (const dvec3& p : points) {
    x.add(glm::dot(p, camera.right)), y.add(glm::dot(p, camera.up)), z.add(glm::dot(p, camera.forward));
  }
  const double size = std::max({x.upper - x.lower, y.upper - y.lower, z.upper - z.lower});
  camera.pixel = std::max(0.5 * (x.upper - x.lower) / half_width, 0.5 * (y.upper - y.lower) / half_height);
  if (!(camera.pixel > 1e-6 * size / half_width)) {  // a point, or a flat part seen from its edge
    camera.pixel = std::max(0.5 * size, 0.5) / std::min(half_width, half_height);
  }
  const double gap = std::max(kEyeGap * size, camera.pixel);
  camera.eye = 0.5 * (x.lower + x.upper) * camera.right + 0.5 * (y.lower + y.upper) * camera.up +
               (z.lower - gap) * camera.forward;
  return camera;
}

// The frustum's four planes touch the points: with a = max(x - t z) and b = max(-x - t z), the eye must
// satisfy a <= ex - t ez and b <= -ex - t ez, so ez <= -(a + b) / 2t, and ex = (a - b) / 2 serves every such
// ez.
Camera fit_perspective(Camera camera, std::span<const dvec3> points, double half_width, double half_height) {
  const double tx = half_width * camera.pixel, ty = half_height * camera.pixel;
  double ax = -kInf, bx = -kInf, ay = -kInf, by = -kInf;
  Interval z, all;
  for (const dvec3& p : points) {
    const double px = glm::dot(p, camera.right), py = glm::dot(p, camera.up),
                 pz = glm::dot(p, camera.forward);
    ax = std::max(ax, px - tx * pz), bx = std::max(bx, -px - tx * pz);
    ay = std::max(ay, py - ty * pz), by = std::max(by, -py - ty * pz);
    z.add(pz);
    all.add(px), all.add(py), all.add(pz);
  }
  double ez = std::min(-(ax + bx) / (2.0 * tx), -(ay + by) / (2.0 * ty));
  // A point or a line along the view would put the eye on the model itself.
  const double size = std::max(z.upper - z.lower, 0.0);
  const double gap = std::max(kEyeGap * size, 1e-6 * std::max(1.0, size));
  ez = std::min(ez, z.lower - gap);
  camera.eye = 0.5 * (ax - bx) * camera.right + 0.5 * (ay - by) * camera.up + ez * camera.forward;
  return camera;
}

}  // namespace

Camera look(double azimuth_deg, double elevation_deg, UpAxis axis) {
  dvec3 right{0.0}, up{0.0};
  front_axes(axis, right, up);
  const dvec3 front = glm::cross(right, up);  // from the model to the eye of the front view
  double ca, sa, ce, se;
  cos_sin_deg(azimuth_deg, ca, sa);
  cos_sin_deg(std::clamp(elevation_deg, -90.0, 90.0), ce, se);
  const dvec3 level = ca * front + sa * right;  // to the eye, at elevation 0
  Camera camera;
  camera.forward = -(ce * level + se * up);
  camera.right = ca * right - sa * front;
  camera.up = ce * up - se * level;
  return camera;
}

Camera turned(const Camera& camera, double angle_deg, const dvec3& pivot, UpAxis axis) {
  dvec3 right{0.0}, up{0.0};
  front_axes(axis, right, up);
  double c, s;
  cos_sin_deg(angle_deg, c, s);
  const auto turn = [&](const dvec3& v) {  // Rodrigues' formula
    const dvec3 upright = glm::dot(v, up) * up, level = v - upright;
    return upright + c * level + s * glm::cross(up, v);
  };
  Camera result = camera;
  result.eye = pivot + turn(camera.eye - pivot);
  result.right = turn(camera.right), result.up = turn(camera.up), result.forward = turn(camera.forward);
  return result;
}

Camera fit(const Camera& directions, std::span<const dvec3> points, const FitOptions& options) {
  static constexpr dvec3 kOrigin{0.0};
  if (points.empty()) points = {&kOrigin, 1};
  Camera camera = directions;
  camera.width_px = options.width_px, camera.height_px = options.height_px;
  camera.perspective = options.perspective;
  const double shorter = std::min(options.width_px, options.height_px);
  const double border = options.margin * shorter;
  const double half_width = std::max(0.5 * options.width_px - border, 0.25);
  const double half_height = std::max(0.5 * options.height_px - border, 0.25);
  if (!options.perspective) return fit_orthographic(camera, points, half_width, half_height);
  camera.pixel = 2.0 * std::tan(0.5 * options.fov_deg * std::numbers::pi / 180.0) / shorter;
  return fit_perspective(camera, points, half_width, half_height);
}

}  // namespace trimray::view
