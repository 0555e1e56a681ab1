#include "core/trace/scene.h"

#include <algorithm>
#include <mutex>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/trace/scene_impl.h"

namespace trimray::trace {
namespace {

constexpr std::size_t kRaysPerTask = 1024;

void add(TraceStats& sum, const TraceStats& s) {
  sum.rays += s.rays, sum.nodes += s.nodes, sum.leaves += s.leaves, sum.newton_steps += s.newton_steps;
  sum.certified += s.certified, sum.fallbacks += s.fallbacks, sum.trim_tests += s.trim_tests;
  sum.edge_rays += s.edge_rays, sum.given_up += s.given_up;
}

}  // namespace

Scene::Scene(std::shared_ptr<const nurbs::NurbsStore> store, int threads, const SceneOptions& options)
    : impl_(std::make_unique<Impl>(std::move(store), threads, options)) {}
Scene::Scene(Scene&&) noexcept = default;
Scene::~Scene() = default;

const nurbs::NurbsStore& Scene::store() const { return *impl_->store; }
const SceneStats& Scene::stats() const { return impl_->stats; }

void Scene::cast(std::span<const Ray> rays, std::span<Hit> out, int threads, TraceStats* stats) const {
  if (out.size() != rays.size()) throw ArgumentError("cast: out must be as long as rays");
  std::mutex mutex;
  const auto work = [&](std::size_t begin, std::size_t end) {
    TraceStats counters;
    const std::uint64_t before = searches_given_up();
    const std::size_t first = begin * kRaysPerTask, count = std::min(end * kRaysPerTask, rays.size()) - first;
    impl_->nearest(rays.subspan(first, count), out.subspan(first, count), counters);
    if (stats == nullptr) return;
    counters.given_up = searches_given_up() - before;
    const std::scoped_lock lock(mutex);
    add(*stats, counters);
  };
  const std::size_t tasks = (rays.size() + kRaysPerTask - 1) / kRaysPerTask;
  if (threads == 1)
    work(0, tasks);
  else
    parallel_ranges(tasks, 1, threads, work);
}

void Scene::cast_all(const Ray& ray, std::vector<Hit>& out) const {
  out.clear();
  impl_->all_hits(ray, out);
}

bool Scene::near_edge(const Ray& ray) const { return impl_->near_edge(ray, ray.tmax); }

void Scene::count_hits(std::span<const Ray> rays, std::span<std::int32_t> out, int threads) const {
  if (out.size() != rays.size()) throw ArgumentError("count_hits: out must be as long as rays");
  const auto work = [&](std::size_t begin, std::size_t end) {
    std::vector<Hit> hits;
    for (std::size_t i = begin; i < end; ++i) {
      hits.clear();
      impl_->all_hits(rays[i], hits);
      out[i] = static_cast<std::int32_t>(hits.size());
    }
  };
  if (threads == 1)
    work(0, rays.size());
  else
    parallel_ranges(rays.size(), 64, threads, work);
}

}  // namespace trimray::trace
