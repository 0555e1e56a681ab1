// The raster pass over a view's meshes, with OpenGL.
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "raster/backends.h"
#include "raster/gl_pass.h"
#include "raster/picture_memory.h"

namespace trimray::raster {

namespace {

// The passes of one library that no thread is using. One a process and backend, and never destroyed: the
// library's own clean-up at exit may run first.
class GlPool {
 public:
  explicit GlPool(std::unique_ptr<GlPlatform> (*open)()) : open_(open) {}

  std::unique_ptr<GlPass> take() {
    const std::lock_guard lock(mutex_);
    if (process_ != getpid()) {
      if (platform_ && process_ != 0 && !platform_->survives_fork())
        throw Error(
            "this process was forked from one that has drawn already: draw before the fork or after it");
      for (auto& pass : idle_) static_cast<void>(pass.release());  // the parent's: left alone
      idle_.clear();
      process_ = getpid();
    }
    if (!idle_.empty()) {
      auto pass = std::move(idle_.back());
      idle_.pop_back();
      return pass;
    }
    if (!platform_) platform_ = open_();
    auto pass = std::make_unique<GlPass>(platform_->make_context());
    version_ = pass->version();
    return pass;
  }

  void give_back(std::unique_ptr<GlPass> pass) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(pass));
  }

  std::string version() {
    const std::lock_guard lock(mutex_);
    return version_;
  }

 private:
  std::unique_ptr<GlPlatform> (*open_)();
  std::mutex mutex_;
  std::unique_ptr<GlPlatform> platform_;
  std::vector<std::unique_ptr<GlPass>> idle_;
  std::string version_;
  pid_t process_ = 0;
};

GlPool& pool_of(Backend backend) {
  static auto* osmesa = new GlPool(open_osmesa);
  static auto* egl = new GlPool(open_egl);
  return backend == Backend::kEgl ? *egl : *osmesa;
}

// A pass that is current in this thread. One that failed is not given back: its state is unknown.
class Lease {
 public:
  explicit Lease(GlPool& pool) : pool_(pool), pass_(pool.take()) { pass_->make_current(); }
  ~Lease() {
    if (!pass_) return;
    pass_->release();
    if (done_) pool_.give_back(std::move(pass_));
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  GlPass* operator->() const { return pass_.get(); }
  void done() { done_ = true; }

 private:
  GlPool& pool_;
  std::unique_ptr<GlPass> pass_;
  bool done_ = false;
};

// Consecutive blocks, in the order of the instances, of kBlockTriangles triangles or a little more together.
struct Piece {
  std::size_t instance, block;
};

class GlRasterizer final : public Rasterizer {
 public:
  GlRasterizer(Backend backend, int largest_px)
      : backend_(backend), pool_(pool_of(backend)), largest_px_(largest_px) {}
  Backend backend() const override { return backend_; }

  SeedBuffers draw(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store, const view::Camera& camera,
                   SeedProcess process, int threads) override;
  void warm_up(SeedProcess process) override;

 private:
  Backend backend_;
  GlPool& pool_;
  int largest_px_;
  DrawMeshes meshes_[2];  // by SeedProcess
  std::shared_ptr<PictureMemory> memory_ = std::make_shared<PictureMemory>();
};

std::vector<std::vector<Piece>> batches_of(std::span<const std::shared_ptr<const DrawMesh>> drawn) {
  std::vector<std::vector<Piece>> batches;
  int triangles = kBlockTriangles;
  for (std::size_t i = 0; i < drawn.size(); ++i)
    for (std::size_t b = 0; b < drawn[i]->blocks.size(); ++b) {
      if (triangles >= kBlockTriangles) batches.emplace_back(), triangles = 0;
      batches.back().push_back({i, b});
      triangles += drawn[i]->blocks[b].triangles.size();
    }
  return batches;
}

// Bands of rows, each with a context of its own: OpenGL's share of the work is serial. More of them cost a
// few hundredths of the pass. Never by the number of threads, so that the bytes do not depend on it.
int bands_of(std::size_t triangles, int height) {
  const int bands = triangles < 8'000 ? 1 : triangles < 30'000 ? 2 : 4;
  return std::max(1, std::min(bands, height / 64));
}

SeedBuffers GlRasterizer::draw(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store,
                               const view::Camera& camera, SeedProcess process, int threads) {
  check_view(meshes, store, camera);
  const bool with_uv = process == SeedProcess::kUv;
  const auto drawn = meshes_[static_cast<int>(process)].of(meshes, store, process, threads);
  AllTargets targets;
  for (std::size_t i = 0; i < drawn.size(); ++i) targets.add(meshes.instances[i].instance, drawn[i]->targets);

  SeedBuffers result;
  result.width_px = camera.width_px, result.height_px = camera.height_px, result.process = process;
  const std::size_t pixels = static_cast<std::size_t>(camera.width_px) * camera.height_px;
  auto memory = memory_->take(pixels * (with_uv ? 12 : 4));
  auto* id = static_cast<std::uint32_t*>(memory.get());
  auto* uv = reinterpret_cast<float*>(id + pixels);

  const DepthRange range = depth_range(meshes, drawn, store, camera);
  const auto batches = batches_of(drawn);
  std::vector<VisibleTriangles> visible(range.far > 0.0 ? batches.size() : 0);
  const int bands = bands_of(meshes.triangles, camera.height_px);
  const int side = std::min(largest_px_, kMaxPicturePx);
  for (int y0 = 0; y0 < camera.height_px; y0 += side)
    for (int x0 = 0; x0 < camera.width_px; x0 += side) {
      Window window{x0, y0, std::min(side, camera.width_px - x0), std::min(side, camera.height_px - y0)};
      window.band_height = (window.height + bands - 1) / bands;
      std::vector<Projection> projections;
      if (!visible.empty())
        for (const tess::InstanceMesh& i : meshes.instances)
          projections.emplace_back(camera, store.instances[i.instance].placement, window, range);
      parallel_ranges(visible.size(), 1, visible.size() < 4 ? 1 : threads,
                      [&](std::size_t begin, std::size_t end) {
                        for (std::size_t k = begin; k < end; ++k) {
                          visible[k].start(window.bands());
                          for (const Piece& p : batches[k])
                            visible[k].add(*drawn[p.instance], drawn[p.instance]->blocks[p.block],
                                           projections[p.instance], targets.first[p.instance]);
                        }
                      });
      const auto draw_bands = [&](std::size_t begin, std::size_t end) {
        Lease pass(pool_);
        for (std::size_t band = begin; band < end; ++band)
          pass->draw(visible, window, static_cast<int>(band), process, camera.width_px, id, uv);
        pass.done();
      };
      if (window.bands() == 1)
        draw_bands(0, 1);
      else
        parallel_ranges(static_cast<std::size_t>(window.bands()), 1, threads, draw_bands);
    }
  result.id = {id, pixels};
  if (with_uv) result.uv = {uv, 2 * pixels};
  result.targets = std::move(targets.targets);
  result.owner = std::move(memory);
  return result;
}

// Libraries compile when they draw first, and for each program apart.
void GlRasterizer::warm_up(SeedProcess process) {
  VisibleTriangles one;
  one.vertices = {{-1, -1, 0.5f, 1, 0, 0, 1}, {3, -1, 0.5f, 1, 0, 0, 1}, {-1, 3, 0.5f, 1, 0, 0, 1}};
  one.indices = {{0, 1, 2}};
  Lease pass(pool_);
  std::uint32_t id[64 * 64];
  float uv[2 * 64 * 64];
  pass->draw({&one, 1}, {0, 0, 64, 64, 64}, 0, process, 64, id, uv);
  pass.done();
}

}  // namespace

std::unique_ptr<Rasterizer> make_gl_rasterizer(Backend backend) {
  Lease pass(pool_of(backend));  // fails here rather than at the first draw
  pass.done();
  return std::make_unique<GlRasterizer>(backend, pass->largest_px());
}

std::string gl_version(Backend backend) { return pool_of(backend).version(); }

}  // namespace trimray::raster
