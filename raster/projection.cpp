#include "raster/projection.h"

#include <algorithm>
#include <cmath>

namespace trimray::raster {

namespace {

constexpr std::uint32_t kUnused = ~std::uint32_t{0};
// Rasterizers move corners to a grid of 1/256 px; a triangle may so come to cover a centre it just misses.
constexpr float kSnapPx = 1.0f / 128.0f;

// Of the centres i + 0.5 the first at or after x, and the last at or before x, for x >= 0.5; no call of
// floor().
int first_centre(float x) {
  if (!(x > 0.5f)) return 0;
  const int i = static_cast<int>(x - 0.5f);
  return static_cast<float>(i) < x - 0.5f ? i + 1 : i;
}
int last_centre(float x, float size) { return static_cast<int>(std::min(x, size) - 0.5f); }

template <typename Body>
void for_corners(const Box3& box, const Body& body) {
  for (int k = 0; k < 8; ++k)
    body(dvec3((k & 1 ? box.lower : box.upper).x, (k & 2 ? box.lower : box.upper).y,
               (k & 4 ? box.lower : box.upper).z));
}

// A triangle's corners in a window, px.
struct Corners {
  float x[3], y[3];

  // Twice the area; below 0 for a triangle that turns to the eye, since y points down.
  float area() const { return (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]); }

  // Whether it may cover a pixel's centre, and if so in which rows. Few centres are tried one by one: every
  // triangle that the rasterizer is spared is ten times what this costs, and a third of a fine mesh's lie
  // between the centres.
  bool may_cover(float area, float width, float height, int& first_row, int& last_row) const {
    const float left = std::min({x[0], x[1], x[2]}) - kSnapPx, right = std::max({x[0], x[1], x[2]}) + kSnapPx;
    const float top = std::min({y[0], y[1], y[2]}) - kSnapPx, bottom = std::max({y[0], y[1], y[2]}) + kSnapPx;
    // Comparisons reject what is no number.
    if (!(right >= 0.5f && left <= width - 0.5f && bottom >= 0.5f && top <= height - 0.5f)) return false;
    const int x0 = first_centre(left), x1 = last_centre(right, width);
    const int y0 = first_centre(top), y1 = last_centre(bottom, height);
    if (x1 < x0 || y1 < y0) return false;
    first_row = y0, last_row = y1;
    constexpr int kFew = 6;
    if ((x1 - x0 + 1) * static_cast<std::int64_t>(y1 - y0 + 1) > kFew) return true;
    const float sign = area < 0.0f ? -1.0f : 1.0f;
    float by_x[3], by_y[3], at[3];
    for (int k = 0; k < 3; ++k) {
      const int n = (k + 1) % 3;
      by_x[k] = sign * (y[k] - y[n]), by_y[k] = sign * (x[n] - x[k]);
      // At the first centre, and as far off as corners may be moved.
      at[k] = by_x[k] * (static_cast<float>(x0) + 0.5f - x[k]) +
              by_y[k] * (static_cast<float>(y0) + 0.5f - y[k]) +
              kSnapPx * (std::abs(by_x[k]) + std::abs(by_y[k]));
    }
    for (int j = 0; j <= y1 - y0; ++j)
      for (int i = 0; i <= x1 - x0; ++i) {
        const float dx = static_cast<float>(i), dy = static_cast<float>(j);
        if (at[0] + dx * by_x[0] + dy * by_y[0] >= 0.0f && at[1] + dx * by_x[1] + dy * by_y[1] >= 0.0f &&
            at[2] + dx * by_x[2] + dy * by_y[2] >= 0.0f)
          return true;
      }
    return false;
  }
};

}  // namespace

DepthRange depth_range(const tess::ViewMeshes& meshes, std::span<const std::shared_ptr<const DrawMesh>> drawn,
                       const nurbs::NurbsStore& store, const view::Camera& camera) {
  DepthRange range;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    if (drawn[i]->bounds.empty()) continue;
    const Transform& placement = store.instances[meshes.instances[i].instance].placement;
    for_corners(drawn[i]->bounds, [&](const dvec3& p) {
      const double z = glm::dot(placement.point(p) - camera.eye, camera.forward);
      range.near = std::min(range.near, z), range.far = std::max(range.far, z);
    });
  }
  if (!(range.far > 0.0 && range.far < kInf && range.near <= range.far)) return {};  // nothing before the eye
  // A margin, so that rounding clips nothing; and depths as fine as they may be before a near plane.
  const double margin = 1e-3 * (range.far - std::max(range.near, 0.0)) + 1e-9 * range.far;
  range.far += margin;
  range.near = std::max(range.near - margin, camera.perspective ? 1e-5 * range.far : 0.0);
  return range;
}

Projection::Projection(const view::Camera& camera, const Transform& placement, const Window& view,
                       const DepthRange& range)
    : perspective(camera.perspective),
      mirrored(glm::determinant(placement.linear) < 0.0),
      near(range.near),
      window(view) {
  const dmat3 to_prototype = glm::transpose(placement.linear);
  const dvec3 origin = placement.translation - camera.eye;
  const dvec3 axes[3] = {camera.right, -camera.up, camera.forward};
  dvec3 row[3], at;
  for (int k = 0; k < 3; ++k) row[k] = to_prototype * axes[k], at[k] = glm::dot(origin, axes[k]);
  // x_px = width_px / 2 + x / pixel (over w), and the window's [0, width] px becomes [-w, w].
  const double scale[2] = {2.0 / (camera.pixel * view.width), 2.0 / (camera.pixel * view.height)};
  const double offset[2] = {(camera.width_px - 2.0 * view.x0) / view.width - 1.0,
                            (camera.height_px - 2.0 * view.y0) / view.height - 1.0};
  for (int k = 0; k < 2; ++k) {
    rows[k] = scale[k] * row[k], shift[k] = scale[k] * at[k];
    if (perspective)
      rows[k] += offset[k] * row[2], shift[k] += offset[k] * at[2];
    else
      shift[k] += offset[k];
  }
  if (perspective) {
    rows[2] = row[2], shift[2] = at[2];
  } else {
    rows[2] = dvec3(0.0), shift[2] = 1.0;
    const double per_mm = -1.0 / (range.far - range.near);
    depth_row = per_mm * row[2], depth_shift = per_mm * (at[2] - range.far);
  }
}

bool Projection::sees(const Box3& box) const {
  // Outside when all corners are beyond the same plane of the frustum, two pixels wider than the picture.
  const double wide = 1.0 + 4.0 / window.width, high = 1.0 + 4.0 / window.height;
  int outside = 0x3f;
  for_corners(box, [&](const dvec3& p) {
    const double x = glm::dot(rows[0], p) + shift.x, y = glm::dot(rows[1], p) + shift.y;
    const double w = glm::dot(rows[2], p) + shift.z;
    int planes = 0;
    if (x < -wide * w) planes |= 1;
    if (x > wide * w) planes |= 2;
    if (y < -high * w) planes |= 4;
    if (y > high * w) planes |= 8;
    const double depth = glm::dot(depth_row, p) + depth_shift;
    if (perspective ? w < near : depth > 1.0) planes |= 16;
    if (!perspective && depth < 0.0) planes |= 32;
    outside &= planes;
  });
  return outside == 0;
}

bool Projection::beyond_near(const Box3& box) const {
  bool all = true;
  for_corners(box, [&](const dvec3& p) {
    if (perspective)
      all &= glm::dot(rows[2], p) + shift[2] > near;
    else
      all &= glm::dot(depth_row, p) + depth_shift < 1.0;
  });
  return all;
}

void VisibleTriangles::transform(const DrawMesh& mesh, const DrawBlock& block, const Projection& projection) {
  const auto count = static_cast<std::size_t>(block.vertices.size());
  if (px_.size() < count) {
    for (auto& c : clip_) c.resize(count);
    px_.resize(count), py_.resize(count), number_.resize(count);
  }
  std::fill_n(number_.begin(), count, kUnused);
  const double* x = mesh.x.data() + block.vertices.begin;
  const double* y = mesh.y.data() + block.vertices.begin;
  const double* z = mesh.z.data() + block.vertices.begin;
  const dvec3 r0 = projection.rows[0], r1 = projection.rows[1], r2 = projection.rows[2], s = projection.shift;
  const double half_width = 0.5 * projection.window.width, half_height = 0.5 * projection.window.height;
  float *cx = clip_[0].data(), *cy = clip_[1].data(), *cz = clip_[2].data(), *cw = clip_[3].data();
  float *px = px_.data(), *py = py_.data();
  if (projection.perspective) {
    const auto near = static_cast<float>(projection.near);
    for (std::size_t i = 0; i < count; ++i) {
      const double a = r0.x * x[i] + r0.y * y[i] + r0.z * z[i] + s.x;
      const double b = r1.x * x[i] + r1.y * y[i] + r1.z * z[i] + s.y;
      const double w = r2.x * x[i] + r2.y * y[i] + r2.z * z[i] + s.z;
      const double inverse = 1.0 / w;
      cx[i] = static_cast<float>(a), cy[i] = static_cast<float>(b), cz[i] = near,
      cw[i] = static_cast<float>(w);
      px[i] = static_cast<float>(half_width + half_width * a * inverse);
      py[i] = static_cast<float>(half_height + half_height * b * inverse);
    }
    return;
  }
  const dvec3 rd = projection.depth_row;
  const double sd = projection.depth_shift;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = r0.x * x[i] + r0.y * y[i] + r0.z * z[i] + s.x;
    const double b = r1.x * x[i] + r1.y * y[i] + r1.z * z[i] + s.y;
    const double d = rd.x * x[i] + rd.y * y[i] + rd.z * z[i] + sd;
    cx[i] = static_cast<float>(a), cy[i] = static_cast<float>(b), cz[i] = static_cast<float>(d), cw[i] = 1.0f;
    px[i] = static_cast<float>(half_width + half_width * a);
    py[i] = static_cast<float>(half_height + half_height * b);
  }
}

void VisibleTriangles::add(const DrawMesh& mesh, const DrawBlock& block, const Projection& projection,
                           std::uint32_t first_id) {
  if (!projection.sees(block.bounds)) return;
  transform(mesh, block, projection);
  // The side that a closed shell hides is hidden only where the eye stands outside of it.
  const bool outside = projection.beyond_near(mesh.bounds);
  float hidden_sign = 0.0f;
  if (outside && block.hidden != Hidden::kNever) {
    // y points down: triangles that turn to the eye have an area below 0.
    hidden_sign = block.hidden == Hidden::kBack ? 1.0f : -1.0f;
    if (projection.mirrored) hidden_sign = -hidden_sign;
  }
  const bool clipped = projection.perspective && !projection.beyond_near(block.bounds);
  const auto near = static_cast<float>(projection.near);
  const auto width = static_cast<float>(projection.window.width),
             height = static_cast<float>(projection.window.height);
  for (std::int32_t t = block.triangles.begin; t < block.triangles.end; ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    int first_row = 0, last_row = projection.window.height - 1;
    const bool crosses = clipped && !(clip_[3][a] > near && clip_[3][b] > near && clip_[3][c] > near);
    if (crosses) {
      float sum = 0.0f;  // of what is no number, or too large for one, it is none
      for (const std::uint16_t v : {a, b, c}) sum += 0.0f * (clip_[0][v] + clip_[1][v] + clip_[3][v]);
      if (sum != 0.0f) continue;
    } else {
      const Corners corners{{px_[a], px_[b], px_[c]}, {py_[a], py_[b], py_[c]}};
      const float area = corners.area();
      if (area * hidden_sign > 0.0f || !corners.may_cover(area, width, height, first_row, last_row)) continue;
    }
    for (const std::uint16_t v : {a, b, c}) {
      if (number_[v] != kUnused) continue;
      number_[v] = static_cast<std::uint32_t>(vertices.size());
      const auto at = static_cast<std::size_t>(block.vertices.begin) + v;
      vertices.push_back({clip_[0][v], clip_[1][v], clip_[2][v], clip_[3][v], mesh.uv[at][0], mesh.uv[at][1],
                          first_id + mesh.id[at]});
    }
    const int last_band = last_row / projection.window.band_height;
    for (int band = first_row / projection.window.band_height; band <= last_band; ++band)
      indices[band].insert(indices[band].end(), {number_[a], number_[b], number_[c]});
  }
}

}  // namespace trimray::raster
