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

// Where the rays of a picture start and go, in the scene's coordinates: not at the eye but close before the
// model, where floats are fine.
struct Rays {
  const view::Camera& camera;
  dvec3 origin;  // orthographic: on the plane where rays start; perspective: the eye
  double start = 0.0;

  Rays(const view::Camera& c, const EmbreeScene& scene) : camera(c), origin(c.eye - scene.center()) {
    const Box3& b = scene.bounds();
    double near = kInf;
    for (int k = 0; k < 8; ++k)
      near = std::min(near, glm::dot(dvec3((k & 1 ? b.lower : b.upper).x, (k & 2 ? b.lower : b.upper).y,
                                           (k & 4 ? b.lower : b.upper).z) -
                                         c.eye,
                                     c.forward));
    start = std::max(0.0, near - 1e-3 * b.diagonal());
  }

  void set(embree::RayHit16& r, int lane, int px, int py) const {
    const double x = (px + 0.5 - 0.5 * camera.width_px) * camera.pixel;
    const double y = (0.5 * camera.height_px - (py + 0.5)) * camera.pixel;
    const dvec3 aside = x * camera.right + y * camera.up;
    const dvec3 dir = camera.perspective ? camera.forward + aside : camera.forward;
    const dvec3 org = origin + start * dir + (camera.perspective ? dvec3(0.0) : aside);
    r.org_x[lane] = static_cast<float>(org.x), r.org_y[lane] = static_cast<float>(org.y),
    r.org_z[lane] = static_cast<float>(org.z);
    r.dir_x[lane] = static_cast<float>(dir.x), r.dir_y[lane] = static_cast<float>(dir.y),
    r.dir_z[lane] = static_cast<float>(dir.z);
  }
};

class EmbreeRasterizer final : public Rasterizer {
 public:
  Backend backend() const override { return Backend::kEmbree; }

  SeedBuffers draw(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store, const view::Camera& camera,
                   SeedProcess process, int threads) override;
  void warm_up() override { device(); }

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
    for (std::size_t row = begin; row < end; ++row)
      for (int x0 = 0; x0 < width; x0 += 4) {
        alignas(64) int valid[16];
        const int y0 = static_cast<int>(4 * row);
        for (int k = 0; k < 16; ++k) {
          const int x = x0 + k % 4, y = y0 + k / 4;
          valid[k] = x < width && y < height ? -1 : 0;
          rays.set(r, k, x, y);
          r.tnear[k] = 0.0f, r.tfar[k] = std::numeric_limits<float>::infinity(), r.time[k] = 0.0f;
          r.mask[k] = ~0u, r.id[k] = 0, r.flags[k] = 0;
          r.geometry[k] = embree::kNothing, r.instance[k] = embree::kNothing;
        }
        embree.intersect16(valid, scene->scene(), &context, &r);
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
