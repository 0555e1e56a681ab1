// Primary rays per second of the standard tracer.
//
//   trace_bench FILE [--size 1024] [--repeat 5] [--threads 1] [--view x,y,z]
//
// FILE: a saved store (trimray's cache), or a BinTools stream, whose outermost shapes are then placed at the
// origin. Orthographic rays from the named side (default the iso view), fitted to the bounds, in tiles of 8 x 8.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "core/base/error.h"
#include "core/brep/bintools.h"
#include "core/nurbs/build_store.h"
#include "core/trace/scene.h"

namespace {

using namespace trimray;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::vector<std::byte> read_bytes(const char* path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> chars((std::istreambuf_iterator<char>(file)), {});
  std::vector<std::byte> bytes(chars.size());
  if (!chars.empty()) std::memcpy(bytes.data(), chars.data(), chars.size());
  return bytes;
}

nurbs::NurbsStore from_stream(const std::vector<std::byte>& bytes) {
  const brep::Model model = brep::parse_bintools(bytes);
  std::vector<bool> used(model.shapes.size());
  for (const brep::Shape& shape : model.shapes)
    for (const brep::ShapeUse& child : shape.children) used[child.shape] = true;
  nurbs::BuildInput input;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) continue;
    input.instance_prototypes.push_back(static_cast<std::int32_t>(input.prototype_shapes.size()));
    input.prototype_shapes.push_back(static_cast<std::int32_t>(i + 1));
    for (const double x : {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}) input.instance_placements.push_back(x);
    for (int k = 0; k < 4; ++k) input.prototype_colors.push_back(-1.0f), input.instance_colors.push_back(-1.0f);
  }
  return nurbs::build_store(bytes, input);
}

Box3 world_bounds(const nurbs::NurbsStore& store) {
  Box3 bounds;
  for (const nurbs::Instance& instance : store.instances) {
    const Box3& b = store.prototypes[instance.prototype].bounds;
    for (int k = 0; k < 8; ++k)
      bounds.add(instance.placement.point({(k & 1 ? b.lower : b.upper).x, (k & 2 ? b.lower : b.upper).y, (k & 4 ? b.lower : b.upper).z}));
  }
  return bounds;
}

std::vector<trace::Ray> camera_rays(const Box3& bounds, dvec3 from, int size) {
  const dvec3 dir = -glm::normalize(from);
  const dvec3 right = glm::normalize(glm::cross(dir, std::abs(dir.z) > 0.99 ? dvec3(0, 1, 0) : dvec3(0, 0, 1)));
  const dvec3 up = glm::cross(right, dir);
  dvec2 half(0.0);
  for (int k = 0; k < 8; ++k) {
    const dvec3 corner = dvec3((k & 1 ? bounds.lower : bounds.upper).x, (k & 2 ? bounds.lower : bounds.upper).y,
                               (k & 4 ? bounds.lower : bounds.upper).z) - bounds.center();
    half = glm::max(half, glm::abs(dvec2(glm::dot(corner, right), glm::dot(corner, up))));
  }
  const double pixel = 2.0 * std::max(half.x, half.y) * 1.05 / size;
  std::vector<trace::Ray> rays;
  for (int tile = 0; tile < size / 8 * (size / 8); ++tile)
    for (int k = 0; k < 64; ++k) {
      const double x = (tile % (size / 8) * 8 + k % 8 + 0.5 - size / 2.0) * pixel, y = (tile / (size / 8) * 8 + k / 8 + 0.5 - size / 2.0) * pixel;
      rays.push_back({bounds.center() + x * right - y * up - bounds.diagonal() * dir, dir, 0.0, kInf});
    }
  return rays;
}

int run(int argc, char** argv) {
  int size = 1024, repeat = 5, threads = 1;
  dvec3 from(1, -1, 1);
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    if (option == "--size") size = std::stoi(argv[i + 1]);
    if (option == "--repeat") repeat = std::stoi(argv[i + 1]);
    if (option == "--threads") threads = std::stoi(argv[i + 1]);
    if (option == "--view") std::sscanf(argv[i + 1], "%lf,%lf,%lf", &from.x, &from.y, &from.z);
  }
  const std::vector<std::byte> bytes = read_bytes(argv[1]);
  auto start = Clock::now();
  std::shared_ptr<nurbs::NurbsStore> store;
  try {
    store = std::make_shared<nurbs::NurbsStore>(nurbs::load_store(bytes));
  } catch (const FormatError&) {
    store = std::make_shared<nurbs::NurbsStore>(from_stream(bytes));
  }
  const double store_seconds = seconds_since(start);
  start = Clock::now();
  const trace::Scene scene(store, threads);
  const double scene_seconds = seconds_since(start);
  std::printf("%zu faces, store %.3f s, scene %.3f s (%.3f s per 1000 faces), %lld leaves, %.1f MB\n", store->faces.size(),
              store_seconds, scene_seconds, scene_seconds / static_cast<double>(store->faces.size()) * 1e3,
              static_cast<long long>(scene.stats().leaf_boxes), static_cast<double>(scene.stats().bytes) * 1e-6);
  const std::vector<trace::Ray> rays = camera_rays(world_bounds(*store), from, size);
  std::vector<trace::Hit> hits(rays.size());
  std::vector<double> times;
  trace::TraceStats stats;
  for (int r = 0; r < repeat; ++r) {
    stats = {};
    start = Clock::now();
    scene.cast(rays, hits, threads, &stats);
    times.push_back(seconds_since(start));
  }
  std::sort(times.begin(), times.end());
  const double n = static_cast<double>(rays.size());
  const auto hit = std::count_if(hits.begin(), hits.end(), [](const trace::Hit& h) { return h.face != kNoFace; });
  std::printf("coverage %.1f %%, %.2f M rays/s with %d threads (median of %d, best %.2f)\n", 100.0 * static_cast<double>(hit) / n,
              n / times[times.size() / 2] * 1e-6, threads, repeat, n / times[0] * 1e-6);
  std::printf("per ray: %.2f leaves, %.2f Newton steps, %.2f trim tests, %.3f nodes; %.5f open lanes, %.5f edge rays\n",
              static_cast<double>(stats.leaves) / n, static_cast<double>(stats.newton_steps) / n, static_cast<double>(stats.trim_tests) / n,
              static_cast<double>(stats.nodes) / n, static_cast<double>(stats.fallbacks) / n, static_cast<double>(stats.edge_rays) / n);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: trace_bench FILE [--size N] [--repeat N] [--threads N] [--view x,y,z]\n");
    return 2;
  }
  return run(argc, argv);
}
