// Primary rays per second and core of the standard tracer, in processor time.
//
//   trace_bench FILE [--size 1024] [--repeat 5] [--threads 1] [--view x,y,z] [--boxes tuned|paper] [--packet
//   N]
//
// FILE: a saved store (trimray's cache), or a BinTools stream, whose outermost shapes are then placed at the
// origin. Orthographic rays from the named side (default the iso view), fitted to the bounds, in tiles of 8
// x 8.
#include <algorithm>
#include <cstdio>

#include "core/trace/scene.h"
#include "tests/bench/bench_scene.h"

namespace {

using namespace trimray;
using bench::cpu_seconds;

int run(const bench::Options& options) {
  double start = cpu_seconds();
  const auto store = bench::load(options.file);
  const double store_seconds = cpu_seconds() - start;
  start = cpu_seconds();
  const trace::Scene scene(store, options.threads, options.scene);
  const double scene_seconds = cpu_seconds() - start;
  std::printf("%zu faces, store %.3f s, scene %.3f s (%.3f s per 1000 faces), %lld leaves, %.1f MB\n",
              store->faces.size(), store_seconds, scene_seconds,
              scene_seconds / static_cast<double>(store->faces.size()) * 1e3,
              static_cast<long long>(scene.stats().leaf_boxes),
              static_cast<double>(scene.stats().bytes) * 1e-6);
  const std::vector<trace::Ray> rays =
      bench::camera_rays(bench::world_bounds(*store), options.from, options.size);
  std::vector<trace::Hit> hits(rays.size());
  std::vector<double> times;
  trace::TraceStats stats;
  for (int r = 0; r < options.repeat; ++r) {
    stats = {};
    start = cpu_seconds();
    scene.cast(rays, hits, options.threads, &stats);
    times.push_back(cpu_seconds() - start);
  }
  std::sort(times.begin(), times.end());
  const double n = static_cast<double>(rays.size());
  const auto hit =
      std::count_if(hits.begin(), hits.end(), [](const trace::Hit& h) { return h.face != kNoFace; });
  std::printf("coverage %.1f %%, %.2f M rays/s/core with %d threads (median of %d, best %.2f)\n",
              100.0 * static_cast<double>(hit) / n, n / times[times.size() / 2] * 1e-6, options.threads,
              options.repeat, n / times[0] * 1e-6);
  std::printf(
      "per ray: %.2f leaves, %.2f Newton steps, %.2f trim tests, %.3f nodes; %.5f open lanes, %.5f edge "
      "rays\n",
      static_cast<double>(stats.leaves) / n, static_cast<double>(stats.newton_steps) / n,
      static_cast<double>(stats.trim_tests) / n, static_cast<double>(stats.nodes) / n,
      static_cast<double>(stats.fallbacks) / n, static_cast<double>(stats.edge_rays) / n);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return bench::main_with(argc, argv, run); }
