// What `trimray bench` asks: the time and the counters of one picture, by tracer, and the paper's baseline.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <memory>
#include <mutex>

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/bind/bind.h"
#include "core/bind/seeds.h"
#include "core/hybrid/hybrid.h"
#include "core/trace/caster.h"
#include "core/trace/scene.h"

namespace trimray::bind {

namespace {

using hybrid::HybridStats;
using trace::Tile;
using trace::TileHits;
using trace::TraceStats;

struct Clock {
  std::chrono::steady_clock::time_point wall = std::chrono::steady_clock::now();
  double processor = now();

  static double now() {  // of all threads
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  double wall_seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
  }
};

// One ray through each pixel's middle, by tile. Returns the number of hits.
template <typename Trace>
std::uint64_t trace_picture(const view::Camera& camera, int side, int threads, const Trace& trace) {
  static constexpr dvec2 kMiddle{0.5, 0.5};
  const auto columns = static_cast<std::size_t>((camera.width_px + side - 1) / side);
  const auto rows = static_cast<std::size_t>((camera.height_px + side - 1) / side);
  std::atomic<std::uint64_t> hits{0};
  parallel_ranges(columns * rows, 1, threads, [&](std::size_t begin, std::size_t end) {
    TileHits found;
    for (std::size_t i = begin; i < end; ++i) {
      const int x = static_cast<int>(i % columns) * side, y = static_cast<int>(i / columns) * side;
      trace(
          Tile{
              x, y, std::min(x + side, camera.width_px), std::min(y + side, camera.height_px), {&kMiddle, 1}},
          found);
      hits += found.hit.size();
    }
  });
  return hits;
}

using Figures = nb::typed<nb::dict, nb::str, nb::any>;

// solves: rays x surfaces, or rays x boxes, that an intersector was called for.
Figures measure_picture(const trace::Scene& scene, const view::Camera& camera, const std::string& mode,
                        const Seeds* seeds, int tile, int threads) {
  if (mode != "hybrid" && mode != "standard") throw ArgumentError("no tracer is called " + mode);
  if (tile < 1 || tile > 64) throw ArgumentError("a tile has 1 to 64 px along its sides");
  std::mutex mutex;
  HybridStats sum;
  double wall = 0.0, processor = 0.0;
  std::uint64_t hits = 0;
  {
    nb::gil_scoped_release release;
    const Clock clock;
    if (mode == "hybrid") {
      const hybrid::HybridView view(scene, camera, seeds ? &seeds->buffers : nullptr);
      hits = trace_picture(camera, tile, threads, [&](const Tile& t, TileHits& found) {
        HybridStats own;
        view.trace(t, found, &own);
        const std::scoped_lock lock(mutex);
        sum.seeded += own.seeded, sum.solves += own.solves, sum.newton_steps += own.newton_steps;
        sum.newton_roots += own.newton_roots, sum.open += own.open, sum.edge_rays += own.edge_rays;
        sum.candidates += own.candidates;
      });
    } else {
      const auto cast = [&](std::span<const trace::Ray> rays, std::span<trace::Hit> out) {
        TraceStats own;
        scene.cast(rays, out, 1, &own);
        const std::scoped_lock lock(mutex);
        sum.solves += own.leaves, sum.newton_steps += own.newton_steps, sum.open += own.fallbacks;
        sum.newton_roots += own.certified, sum.edge_rays += own.edge_rays;
      };
      hits = trace_picture(camera, tile, threads, trace::tiles_of(camera, cast));
    }
    wall = clock.wall_seconds(), processor = Clock::now() - clock.processor;
  }
  nb::dict d;
  d["seconds"] = wall, d["processor_seconds"] = processor;
  d["pixels"] = static_cast<std::uint64_t>(camera.width_px) * static_cast<std::uint64_t>(camera.height_px);
  d["covered"] = hits, d["solves"] = sum.solves, d["seeded"] = sum.seeded;
  d["newton_steps"] = sum.newton_steps, d["newton_roots"] = sum.newton_roots;
  d["open"] = sum.open, d["edge_rays"] = sum.edge_rays;
  return d;
}

}  // namespace

void bind_bench(nb::module_& m) {
  m.def(
      "paper_scene",
      [](std::shared_ptr<nurbs::NurbsStore> store, int packet, int threads) {
        nb::gil_scoped_release release;
        return std::make_unique<trace::Scene>(std::move(store), threads,
                                              trace::SceneOptions{trace::LeafBoxes::kPaper, packet});
      },
      nb::arg("store"), nb::arg("packet") = 4, nb::arg("threads") = 0,
      "A scene as the paper has it: many small boxes, rays in packets of so many (1 to 64). The same hits.");
  m.def(
      "measure_picture", &measure_picture, nb::arg("scene"), nb::arg("camera"), nb::arg("mode"),
      nb::arg("seeds").none() = nb::none(), nb::arg("tile") = 32, nb::arg("threads") = 0,
      "Time of the nearest hits of one ray a pixel, in seconds and in processor seconds of all threads, and "
      "counters. mode: hybrid or standard. solves: calls of an intersector, a ray and a surface or box "
      "each.");
}

}  // namespace trimray::bind
