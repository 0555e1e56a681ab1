// The hybrid tracer beside its baselines on the rays of one picture, one ray through each pixel's middle, all
// with the same outputs: t, face, instance, uv and normal of the nearest hit.
//
//   hybrid_bench STORE [--size 512] [--view x,y,z] [--camera 16 numbers] [--repeat 7] [--threads 0]
//                [--tile 32] [--seed-px 1.5] [--mesh-px 0.1] [--skip NAME,NAME]
//
// Contenders: standard, our own best (tuned boxes, packets of 64 rays), through the same tiles as the hybrid
// one; cast, the same on rays that are ready; paper4 and paper1, the paper's way (many small boxes, packets
// of 2 x 2 rays, or single rays); hybrid, without seeds; hybrid_BACKEND_PROCESS with seeds that are ready,
// and raster_BACKEND_PROCESS, what these take with the mesh at hand; embree, packets through a triangle mesh
// as fine as --mesh-px. They take turns; figures are medians of --repeat turns: cpu_ms, processor time at one
// thread, and wall_ms, with all threads. Prints one JSON object.
//
// --camera: eye, right, up, forward (3 each), perspective (0 or 1), pixel, width, height; for scripts.
#include <chrono>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "core/base/parallel.h"
#include "core/hybrid/hybrid.h"
#include "core/tess/mesh_levels.h"
#include "core/trace/caster.h"
#include "core/trace/extent.h"
#include "raster/rasterizer.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/embree_mesh.h"

namespace {

using namespace trimray;
using raster::SeedProcess;
using trace::Hit;
using trace::Tile;
using trace::TileHits;

struct Args {
  const char* file = nullptr;
  int size = 512, repeat = 7, threads = 0, tile = 32;
  double seed_px = 1.5, mesh_px = 0.1;
  dvec3 from{1, -1, 1};
  std::vector<double> camera;
  std::set<std::string> skip;
  bool skips(const std::string& name) const { return skip.count(name) > 0; }
};

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Of all threads, finer than std::clock().
double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v.empty() ? 0.0 : v[v.size() / 2];
}

view::Camera camera_of(const Args& args, const nurbs::NurbsStore& store) {
  view::Camera c;
  if (args.camera.size() == 16) {
    const double* x = args.camera.data();
    c.eye = {x[0], x[1], x[2]}, c.right = {x[3], x[4], x[5]}, c.up = {x[6], x[7], x[8]};
    c.forward = {x[9], x[10], x[11]}, c.perspective = x[12] != 0.0, c.pixel = x[13];
    c.width_px = static_cast<int>(x[14]), c.height_px = static_cast<int>(x[15]);
    return c;
  }
  const double azimuth = std::atan2(args.from.x, -args.from.y) * 180.0 / M_PI;
  const double elevation = std::atan2(args.from.z, std::hypot(args.from.x, args.from.y)) * 180.0 / M_PI;
  return view::fit(view::look(azimuth, elevation, view::UpAxis::kZ), trace::model_extent(store).points,
                   {.width_px = args.size, .height_px = args.size});
}

// The picture in tiles; whoever traces them.
struct Picture {
  view::Camera camera;
  int tile;

  std::vector<Tile> tiles() const {
    static constexpr dvec2 kMiddle{0.5, 0.5};
    std::vector<Tile> out;
    for (int y = 0; y < camera.height_px; y += tile)
      for (int x = 0; x < camera.width_px; x += tile)
        out.push_back(
            {x, y, std::min(x + tile, camera.width_px), std::min(y + tile, camera.height_px), {&kMiddle, 1}});
    return out;
  }

  // use(tile, hits) may be called from many threads.
  template <typename Trace, typename Use>
  void run(int threads, const Trace& trace, const Use& use) const {
    const std::vector<Tile> all = tiles();
    const auto work = [&](std::size_t begin, std::size_t end) {
      thread_local TileHits hits;
      for (std::size_t i = begin; i < end; ++i) {
        trace(all[i], hits);
        use(all[i], hits);
      }
    };
    if (threads == 1)
      work(0, all.size());
    else
      parallel_ranges(all.size(), 1, threads, work);
  }

  template <typename Trace>
  std::vector<Hit> hits(const Trace& trace) const {
    std::vector<Hit> out(static_cast<std::size_t>(camera.width_px) * camera.height_px);
    run(0, trace, [&](const Tile& t, const TileHits& h) {
      for (std::size_t i = 0; i < h.ray.size(); ++i)
        out[static_cast<std::size_t>(t.y0 + h.ray[i] / t.width()) * camera.width_px + t.x0 +
            h.ray[i] % t.width()] = h.hit[i];
    });
    return out;
  }
};

bool same(const Hit& a, const Hit& b) {
  return a.face == b.face && a.instance == b.instance && std::memcmp(&a.t, &b.t, sizeof a.t) == 0 &&
         std::memcmp(&a.uv_face, &b.uv_face, sizeof a.uv_face) == 0 &&
         std::memcmp(&a.normal, &b.normal, sizeof a.normal) == 0;
}

struct Contender {
  std::string name;
  std::function<void(int threads)> run;
  std::vector<double> cpu, wall;
};

// Turn by turn, so that whatever else the machine does falls on all alike.
void compete(std::vector<Contender>& contenders, int repeat, int threads) {
  for (Contender& c : contenders) c.run(1);
  for (int r = 0; r < repeat; ++r)
    for (Contender& c : contenders) {
      const double start = cpu_seconds();
      c.run(1);
      c.cpu.push_back(1e3 * (cpu_seconds() - start));
    }
  for (int r = 0; r < repeat; ++r)
    for (Contender& c : contenders) {
      const double start = wall_seconds();
      c.run(threads);
      c.wall.push_back(1e3 * (wall_seconds() - start));
    }
}

class Json {
 public:
  template <typename T>
  void add(const std::string& key, const T& value) {
    text_ << (empty_ ? "" : ",") << '"' << key << "\":" << value;
    empty_ = false;
  }
  std::string text() const { return std::string("{").append(text_.str()).append("}"); }

 private:
  std::ostringstream text_;
  bool empty_ = true;
};

std::string stats_json(const hybrid::HybridStats& s) {
  Json j;
  j.add("rays", s.rays), j.add("hits", s.hits), j.add("seeded", s.seeded), j.add("solves", s.solves);
  j.add("newton_steps", s.newton_steps), j.add("newton_roots", s.newton_roots), j.add("open", s.open);
  j.add("edge_rays", s.edge_rays), j.add("candidates", s.candidates);
  return j.text();
}

// A hybrid contender, and what it counts and how many pixels differ from the standard picture.
struct HybridRun {
  const trace::Scene& scene;
  const Picture& picture;
  const raster::SeedBuffers* seeds;

  void operator()(int threads) const {
    const hybrid::HybridView view(scene, picture.camera, seeds);
    picture.run(
        threads, [&](const Tile& t, TileHits& h) { view.trace(t, h); }, [](const auto&...) {});
  }
  hybrid::HybridStats compare(const std::vector<Hit>& expected, std::size_t& differ) const {
    const hybrid::HybridView view(scene, picture.camera, seeds);
    hybrid::HybridStats sum;
    for (const Tile& t : picture.tiles()) {
      TileHits hits;
      view.trace(t, hits, &sum);
    }
    const std::vector<Hit> got = picture.hits([&](const Tile& t, TileHits& h) { view.trace(t, h); });
    differ = 0;
    for (std::size_t i = 0; i < got.size(); ++i) differ += !same(got[i], expected[i]);
    return sum;
  }
};

int run(const Args& args) {
  const auto store = bench::load(args.file);
  const Picture picture{camera_of(args, *store), args.tile};
  const view::Camera& camera = picture.camera;
  const trace::Scene tuned(store), paper4(store, 0, {trace::LeafBoxes::kPaper, 4}),
      paper1(store, 0, {trace::LeafBoxes::kPaper, 1});
  std::vector<Contender> contenders;
  const auto add = [&](const std::string& name, std::function<void(int)> work) {
    if (!args.skips(name)) contenders.push_back({name, std::move(work), {}, {}});
  };

  const trace::Caster standard = trace::standard_caster(tuned, camera);
  const auto by_caster = [&picture](trace::Caster caster) {
    return [&picture, caster = std::move(caster)](int threads) {
      picture.run(threads, caster.tile, [](const auto&...) {});
    };
  };
  add("standard", by_caster(standard));
  const std::vector<Hit> expected = picture.hits(standard.tile);
  std::vector<trace::Ray> rays;
  for (const Tile& t : picture.tiles())
    for (int k = 0; k < args.tile * args.tile; ++k) {
      int x = 0, y = 0;
      for (int b = 0; b < 8; ++b) x |= (k >> 2 * b & 1) << b, y |= (k >> (2 * b + 1) & 1) << b;
      if (t.x0 + x >= t.x1 || t.y0 + y >= t.y1) continue;
      const view::CameraRay r = camera.ray(t.x0 + x + 0.5, t.y0 + y + 0.5);
      rays.push_back({r.org, r.dir, 0.0, kInf});
    }
  std::vector<Hit> cast_hits(rays.size());
  add("cast", [&](int threads) { tuned.cast(rays, cast_hits, threads); });
  add("paper4", by_caster(trace::standard_caster(paper4, camera)));
  add("paper1", by_caster(trace::standard_caster(paper1, camera)));
  std::size_t paper_differ = 0;
  {
    const std::vector<Hit> got = picture.hits(trace::standard_caster(paper4, camera).tile);
    for (std::size_t i = 0; i < got.size(); ++i) paper_differ += !same(got[i], expected[i]);
  }
  trace::TraceStats standard_stats;
  tuned.cast(rays, cast_hits, 0, &standard_stats);
  trace::TraceStats paper_stats;
  paper4.cast(rays, cast_hits, 0, &paper_stats);

  // The hybrid tracer: without seeds, then with those of every backend.
  Json differ, stats;
  differ.add("paper4", paper_differ);
  const auto add_hybrid = [&](const std::string& name, const raster::SeedBuffers* seeds) {
    if (args.skips(name)) return;
    const HybridRun work{tuned, picture, seeds};
    std::size_t different = 0;
    stats.add(name, stats_json(work.compare(expected, different)));
    differ.add(name, different);
    add(name, work);
  };
  add_hybrid("hybrid", nullptr);
  double start = wall_seconds();
  tess::MeshLevels levels(store);
  const tess::ViewMeshes seed_mesh = levels.meshes(camera, args.seed_px);
  const double seed_mesh_seconds = wall_seconds() - start;
  std::vector<std::unique_ptr<raster::Rasterizer>> rasterizers;
  std::vector<std::unique_ptr<raster::SeedBuffers>> buffers;
  for (const raster::Backend backend : raster::kBackends) {
    const std::string name = raster::backend_name(backend);
    std::string why;
    if (args.skips(name)) continue;
    if (!raster::available(backend, &why)) {
      std::fprintf(stderr, "%s: %s\n", name.c_str(), why.c_str());
      continue;
    }
    rasterizers.push_back(raster::make_rasterizer(backend));
    raster::Rasterizer* r = rasterizers.back().get();
    for (const SeedProcess process : {SeedProcess::kId, SeedProcess::kUv}) {
      const std::string of = name + (process == SeedProcess::kId ? "_id" : "_uv");
      add("raster_" + of,
          [&, r, process](int threads) { (void)r->draw(seed_mesh, *store, camera, process, threads); });
      buffers.push_back(std::make_unique<raster::SeedBuffers>(r->draw(seed_mesh, *store, camera, process)));
      add_hybrid("hybrid_" + of, buffers.back().get());
    }
  }

  std::unique_ptr<bench::EmbreeMesh> embree;
  std::vector<Hit> embree_hits(expected.size());
  std::size_t triangles = 0;
  double mesh_seconds = 0.0;
  if (!args.skips("embree")) {
    start = wall_seconds();
    tess::MeshLevels fine(store);
    const tess::ViewMeshes meshes = fine.meshes(camera, args.mesh_px);
    mesh_seconds = wall_seconds() - start;
    triangles = meshes.triangles;
    embree = std::make_unique<bench::EmbreeMesh>(meshes, *store);
    add("embree", [&](int threads) {
      const std::size_t rows = (static_cast<std::size_t>(camera.height_px) + 31) / 32;
      const auto work = [&](std::size_t begin, std::size_t end) {
        embree->trace(camera, 32 * static_cast<int>(begin),
                      std::min(32 * static_cast<int>(end), camera.height_px), embree_hits);
      };
      if (threads == 1)
        work(0, rows);
      else
        parallel_ranges(rows, 1, threads, work);
    });
  }
  compete(contenders, args.repeat, args.threads);
  if (embree) {
    std::size_t other = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) other += embree_hits[i].face != expected[i].face;
    differ.add("embree_face", other);
  }

  std::size_t covered = 0;
  for (const Hit& h : expected) covered += h.face != kNoFace;
  Json out, cpu, wall;
  for (const Contender& c : contenders) cpu.add(c.name, median(c.cpu)), wall.add(c.name, median(c.wall));
  out.add("pixels", expected.size()), out.add("covered", covered), out.add("faces", store->faces.size());
  out.add("boxes", tuned.stats().leaf_boxes), out.add("paper_boxes", paper4.stats().leaf_boxes);
  out.add("seed_triangles", seed_mesh.triangles), out.add("seed_mesh_seconds", seed_mesh_seconds);
  out.add("triangles", triangles), out.add("mesh_seconds", mesh_seconds);
  out.add("standard_leaves", standard_stats.leaves), out.add("paper_leaves", paper_stats.leaves);
  out.add("cpu_ms", cpu.text()), out.add("wall_ms", wall.text());
  out.add("differ", differ.text()), out.add("stats", stats.text());
  std::printf("%s\n", out.text().c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Args args;
  if (argc < 2 || argc % 2 != 0) {
    std::fprintf(stderr, "usage: %s STORE [--option value]...; see the head of hybrid_bench.cpp\n", argv[0]);
    return 2;
  }
  args.file = argv[1];
  const auto numbers = [](const char* text) {
    std::vector<double> out;
    std::istringstream in(text);
    for (std::string item; std::getline(in, item, ',');) out.push_back(std::stod(item));
    return out;
  };
  const std::map<std::string, std::function<void(const char*)>> options{
      {"--size", [&](const char* v) { args.size = std::stoi(v); }},
      {"--repeat", [&](const char* v) { args.repeat = std::stoi(v); }},
      {"--threads", [&](const char* v) { args.threads = std::stoi(v); }},
      {"--tile", [&](const char* v) { args.tile = std::stoi(v); }},
      {"--seed-px", [&](const char* v) { args.seed_px = std::stod(v); }},
      {"--mesh-px", [&](const char* v) { args.mesh_px = std::stod(v); }},
      {"--skip",
       [&](const char* v) {
         std::istringstream in(v);
         for (std::string item; std::getline(in, item, ',');) args.skip.insert(item);
       }},
      {"--camera", [&](const char* v) { args.camera = numbers(v); }},
      {"--view",
       [&](const char* v) { std::sscanf(v, "%lf,%lf,%lf", &args.from.x, &args.from.y, &args.from.z); }}};
  for (int i = 2; i + 1 < argc; i += 2) {
    const auto option = options.find(argv[i]);
    if (option == options.end()) {
      std::fprintf(stderr, "unknown option %s\n", argv[i]);
      return 2;
    }
    option->second(argv[i + 1]);
  }
  try {
    return run(args);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s: %s\n", args.file, error.what());
    return 1;
  }
}
