// Seeds without a raster: packets of 4 x 4 rays through the view's triangles, with Embree.
#include <unistd.h>

#include <algorithm>
#include <mutex>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "raster/backends.h"
#include "raster/embree_scene.h"
#include "raster/picture_memory.h"

namespace trimray::raster {

namespace {

const embree::Library& library() {
  static const auto* loaded = new embree::Library;  // throws again each time it fails
  return *loaded;
}

std::shared_ptr<const EmbreeDevice> device() {
  static auto* mutex = new std::mutex;
  static auto* made = new std::shared_ptr<const EmbreeDevice>;
  const std::lock_guard lock(*mutex);
  if (!*made || (*made)->process != getpid()) *made = std::make_shared<EmbreeDevice>(library());
  return *made;
}

// The rays of a picture's 4 x 4 blocks, in the scene's coordinates. They do not start at the eye but close
// before the model, where floats are fine.
class Rays {
 public:
  Rays(const view::Camera& camera, const EmbreeScene& scene)
      : camera_(camera), origin_(camera.eye - scene.center()) {
    const Box3& b = scene.bounds();
    double near = kInf;
    Box2 seen;
    for (int k = 0; k < 8; ++k) {
      const dvec3 p =
          dvec3((k & 1 ? b.lower : b.upper).x, (k & 2 ? b.lower : b.upper).y, (k & 4 ? b.lower : b.upper).z) -
          camera.eye;
      const double z = glm::dot(p, camera.forward), scale = camera.pixel * (camera.perspective ? z : 1.0);
      near = std::min(near, z);
      seen.add({0.5 * camera.width_px + glm::dot(p, camera.right) / scale,
                0.5 * camera.height_px - glm::dot(p, camera.up) / scale});
    }
    start_ = std::max(0.0, near - 1e-3 * b.diagonal());
    if (near > 0.0 || !camera.perspective) {
      seen.dilate(1.0);
      x0_ = seen.lower.x, x1_ = seen.upper.x, y0_ = seen.lower.y, y1_ = seen.upper.y;
    }
    for (int k = 0; k < 16; ++k) {
      const dvec3 aside = at(k % 4, k / 4) - at(0, 0);
      for (int a = 0; a < 3; ++a) lanes_[a][k] = static_cast<float>(aside[a]);
    }
    for (int k = 0; k < 16; ++k) lane_start_[k] = static_cast<float>(start_);
  }

  // Whether the block at (px, py) may see something.
  bool sees(int px, int py) const { return px + 4 > x0_ && px < x1_ && py + 4 > y0_ && py < y1_; }

  void set(embree::RayHit16& r, int px, int py) const {
    const dvec3 aside = at(px, py);
    if (camera_.perspective) {
      // dir = forward + aside, org = eye + start * dir
      const dvec3 dir = camera_.forward + aside, org = origin_ + start_ * dir;
      fill(r.dir_x, dir.x, lanes_[0]), fill(r.dir_y, dir.y, lanes_[1]), fill(r.dir_z, dir.z, lanes_[2]);
      scaled(r.org_x, org.x, lanes_[0]), scaled(r.org_y, org.y, lanes_[1]), scaled(r.org_z, org.z, lanes_[2]);
    } else {
      const dvec3 dir = camera_.forward, org = origin_ + start_ * dir + aside;
      fill(r.org_x, org.x, lanes_[0]), fill(r.org_y, org.y, lanes_[1]), fill(r.org_z, org.z, lanes_[2]);
      std::fill_n(r.dir_x, 16, static_cast<float>(dir.x)),
          std::fill_n(r.dir_y, 16, static_cast<float>(dir.y));
      std::fill_n(r.dir_z, 16, static_cast<float>(dir.z));
    }
  }

 private:
  // Of a pixel's centre from the picture's: mm, or tangents.
  dvec3 at(int px, int py) const {
    return (px + 0.5 - 0.5 * camera_.width_px) * camera_.pixel * camera_.right +
           (0.5 * camera_.height_px - (py + 0.5)) * camera_.pixel * camera_.up;
  }
  static void fill(float* to, double first, const float* lanes) {
    const auto f = static_cast<float>(first);
    for (int k = 0; k < 16; ++k) to[k] = f + lanes[k];
  }
  void scaled(float* to, double first, const float* lanes) const {
    const auto f = static_cast<float>(first);
    for (int k = 0; k < 16; ++k) to[k] = f + lane_start_[k] * lanes[k];
  }

  const view::Camera& camera_;
  dvec3 origin_;
  double start_ = 0.0;
  double x0_ = -kInf, x1_ = kInf, y0_ = -kInf, y1_ = kInf;  // px: of what can be seen
  float lanes_[3][16], lane_start_[16];                     // from the block's first pixel
};

class EmbreeRasterizer final : public Rasterizer {
 public:
  Backend backend() const override { return Backend::kEmbree; }

  SeedBuffers draw(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store, const view::Camera& camera,
                   SeedProcess process, int threads) override;
  void warm_up(SeedProcess) override { device(); }

 private:
  std::shared_ptr<const EmbreeScene> scene_of(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store,
                                              int threads) {
    const std::lock_guard lock(mutex_);
    if (!scene_ || !scene_->is_of(meshes, store)) {
      scene_.reset();
      scene_ = std::make_shared<EmbreeScene>(device(), meshes, store, threads);
    }
    return scene_;
  }

  std::mutex mutex_;
  std::shared_ptr<const EmbreeScene> scene_;  // of the last call
  std::shared_ptr<PictureMemory> memory_ = std::make_shared<PictureMemory>();
};

SeedBuffers EmbreeRasterizer::draw(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store,
                                   const view::Camera& camera, SeedProcess process, int threads) {
  check_view(meshes, store, camera);
  const bool with_uv = process == SeedProcess::kUv;
  const auto scene = scene_of(meshes, store, threads);
  AllTargets targets;
  for (std::size_t i = 0; i < meshes.instances.size(); ++i)
    targets.add(meshes.instances[i].instance, scene->targets(i, process).targets);

  SeedBuffers result;
  const int width = camera.width_px, height = camera.height_px;
  result.width_px = width, result.height_px = height, result.process = process;
  const std::size_t pixels = static_cast<std::size_t>(width) * height;
  auto memory = memory_->take(pixels * (with_uv ? 12 : 4));
  auto* id = static_cast<std::uint32_t*>(memory.get());
  auto* uv = reinterpret_cast<float*>(id + pixels);

  const embree::Library& embree = library();
  const Rays rays(camera, *scene);
  const auto hit = [&](const embree::RayHit16& r, int lane, std::size_t pixel) {
    const unsigned instance = r.geometry[lane];
    if (instance == embree::kNothing) {
      id[pixel] = 0;
      return;
    }
    const unsigned triangle = r.primitive[lane];
    id[pixel] = targets.first[instance] + scene->targets(instance, process).of_triangle[triangle];
    if (!with_uv) return;
    const tess::TriMesh& mesh = meshes.instances[instance].mesh->mesh;
    const auto& c = mesh.corner_uv[triangle];
    const double u = r.u[lane], v = r.v[lane];
    const auto at = uv_fraction(store.faces[mesh.face[triangle]], (1.0 - u - v) * c[0] + u * c[1] + v * c[2]);
    uv[2 * pixel] = at[0], uv[2 * pixel + 1] = at[1];
  };
  const std::size_t rows = (static_cast<std::size_t>(height) + 3) / 4;
  parallel_ranges(rows, 4, threads, [&](std::size_t begin, std::size_t end) {
    embree::RayHit16 r;
    embree::Context context;
    std::fill_n(r.tnear, 16, 0.0f), std::fill_n(r.time, 16, 0.0f), std::fill_n(r.mask, 16, ~0u);
    std::fill_n(r.id, 16, 0u), std::fill_n(r.flags, 16, 0u);
    for (std::size_t row = begin; row < end; ++row)
      for (int x0 = 0; x0 < width; x0 += 4) {
        alignas(64) int valid[16];
        const int y0 = static_cast<int>(4 * row);
        for (int k = 0; k < 16; ++k) valid[k] = x0 + k % 4 < width && y0 + k / 4 < height ? -1 : 0;
        std::fill_n(r.geometry, 16, embree::kNothing), std::fill_n(r.instance, 16, embree::kNothing);
        if (rays.sees(x0, y0)) {
          rays.set(r, x0, y0);
          std::fill_n(r.tfar, 16, std::numeric_limits<float>::infinity());
          embree.intersect16(valid, scene->scene(), &context, &r);
        }
        for (int k = 0; k < 16; ++k)
          if (valid[k]) hit(r, k, static_cast<std::size_t>(y0 + k / 4) * width + x0 + k % 4);
      }
  });
  result.id = {id, pixels};
  if (with_uv) result.uv = {uv, 2 * pixels};
  result.targets = std::move(targets.targets);
  result.owner = std::move(memory);
  return result;
}

}  // namespace

std::unique_ptr<Rasterizer> make_embree_rasterizer() {
  device();
  return std::make_unique<EmbreeRasterizer>();
}

std::string embree_version() {
  const auto v = device()->library.device_property(device()->device, embree::kVersion);
  return "Embree " + std::to_string(v / 10000) + "." + std::to_string(v / 100 % 100) + "." +
         std::to_string(v % 100);
}

}  // namespace trimray::raster
