// Time of the raster pass by backend, for meshes of several finenesses at several resolutions.
//
//   raster_bench FILE [--size N] [--repeat 9] [--threads 1] [--view x,y,z]
//
// Milliseconds, medians: processor time of all threads, then wall time, both with the meshes at hand; `first`
// is the processor time of the first draw of a mesh that is new to the backend (its blocks or its hierarchy
// are built), and `start` what the library takes to load and to compile (wall time). The last column: pixels
// in which the surface is another one than the first backend's (coincident surfaces among them).
#include <chrono>

#include "core/tess/mesh_levels.h"
#include "raster/rasterizer.h"
#include "tests/bench/bench_scene.h"

namespace {

using namespace trimray;
using raster::Backend;

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}

view::Camera camera_for(const nurbs::NurbsStore& store, dvec3 from, int size) {
  const Box3 bounds = bench::world_bounds(store);
  std::vector<dvec3> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back({(k & 1 ? bounds.lower : bounds.upper).x, (k & 2 ? bounds.lower : bounds.upper).y,
                       (k & 4 ? bounds.lower : bounds.upper).z});
  const double azimuth = std::atan2(from.x, -from.y) * 180.0 / M_PI;
  const double elevation = std::atan2(from.z, std::hypot(from.x, from.y)) * 180.0 / M_PI;
  return view::fit(view::look(azimuth, elevation, view::UpAxis::kZ), corners,
                   {.width_px = size, .height_px = size});
}

// Surface and instance of a pixel, whatever the process.
std::pair<int, int> surface(const raster::SeedBuffers& b, std::size_t i) {
  if (b.id[i] == 0) return {-1, -1};
  const raster::SeedTarget& t = b.targets[b.id[i] - 1];
  return {t.instance, t.face};
}

struct Timing {
  double first = 0, cpu = 0, wall = 0;
  raster::SeedBuffers last;
};

Timing measure(raster::Rasterizer& r, const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store,
               const view::Camera& camera, raster::SeedProcess process, const bench::Options& options) {
  Timing t;
  const double start = bench::cpu_seconds();
  t.last = r.draw(meshes, store, camera, process, options.threads);
  t.first = 1e3 * (bench::cpu_seconds() - start);
  std::vector<double> cpu, wall;
  for (int k = 0; k < options.repeat; ++k) {
    const double w = wall_seconds(), c = bench::cpu_seconds();
    t.last = r.draw(meshes, store, camera, process, options.threads);
    cpu.push_back(1e3 * (bench::cpu_seconds() - c)), wall.push_back(1e3 * (wall_seconds() - w));
  }
  t.cpu = median(cpu), t.wall = median(wall);
  return t;
}

int run(const bench::Options& options) {
  const auto store = bench::load(options.file);
  std::vector<std::unique_ptr<raster::Rasterizer>> rasterizers;
  for (const Backend backend : raster::kBackends) {
    std::string why;
    double start = wall_seconds();
    if (!raster::available(backend, &why)) {
      std::printf("%s: %s\n", raster::backend_name(backend), why.c_str());
      continue;
    }
    rasterizers.push_back(raster::make_rasterizer(backend));
    const double load = wall_seconds() - start;
    start = wall_seconds();
    rasterizers.back()->warm_up();
    std::printf("%s: %s; start %.1f ms + %.1f ms\n", raster::backend_name(backend),
                raster::version(backend).c_str(), 1e3 * load, 1e3 * (wall_seconds() - start));
  }
  std::printf("%5s %9s %9s %5s %8s %8s %8s %8s %8s\n", "size", "covered", "triangles", "seeds", "backend",
              "cpu", "wall", "first", "differ");
  for (int size : {256, 512, 1024, 2048}) {
    if (options.size != 1024 && size != options.size) continue;
    const view::Camera camera = camera_for(*store, options.from, size);
    std::size_t triangles = 0;  // of the mesh before: a finer one may take minutes to be made
    for (const double deviation : {1.0, 0.3, 0.1, 0.03, 0.01}) {
      if (triangles > 80'000) break;
      tess::MeshLevels levels(store);
      const tess::ViewMeshes meshes = levels.meshes(camera, deviation);
      triangles = meshes.triangles;
      for (const auto process : {raster::SeedProcess::kUv, raster::SeedProcess::kId}) {
        raster::SeedBuffers first;
        for (const auto& r : rasterizers) {
          Timing t = measure(*r, meshes, *store, camera, process, options);
          if (first.id.empty()) first = t.last;
          std::size_t covered = 0, differ = 0;
          for (std::size_t i = 0; i < t.last.id.size(); ++i)
            covered += t.last.id[i] != 0, differ += surface(t.last, i) != surface(first, i);
          std::printf("%5d %9zu %9zu %5s %8s %8.2f %8.2f %8.2f %8zu\n", size, covered, meshes.triangles,
                      process == raster::SeedProcess::kUv ? "uv" : "id", r->name().c_str(), t.cpu, t.wall,
                      t.first, differ);
        }
      }
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return bench::main_with(argc, argv, run); }
