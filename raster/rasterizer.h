// Rasterizer: draws the meshes of a view once and says what each pixel saw, for the tracer's seeds.
//
// Nothing here is linked to a graphics library: a backend is loaded when it is first asked for, and where
// none can be loaded the tracer works without seeds.
//
// Fork and threads. draw() may be called from many threads at once, each call has a context of its own, and
// the process may fork before, between and after draws; the child makes contexts of its own. What cannot
// work: to fork while another thread is drawing and then draw in the child (the libraries' locks stay
// closed), and to draw in the child after the parent drew on a graphics card, or with LP_NUM_THREADS set by
// hand; the last two throw Error.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/nurbs/store.h"
#include "core/tess/mesh_levels.h"
#include "core/view/camera.h"
#include "raster/seed_buffers.h"

namespace trimray::raster {

enum class Backend : std::uint8_t {
  kOsmesa,  // OpenGL on the processor, Mesa's off-screen library
  kEgl,     // OpenGL without a window: a graphics card where there is one, else Mesa on the processor
  kEmbree   // no raster at all: packets of rays through the same triangles
};
inline constexpr Backend kBackends[] = {Backend::kOsmesa, Backend::kEgl, Backend::kEmbree};

const char* backend_name(Backend backend);  // "osmesa", "egl", "embree"
std::optional<Backend> backend_of(std::string_view name);

// Whether the backend can draw on this machine; tried once a process, which takes some milliseconds the first
// time. *why_not: one line, empty where it can. The environment variable TRIMRAY_NO_RASTER takes a
// comma-separated list of backends, or "all", out of service.
bool available(Backend backend, std::string* why_not = nullptr);
// What was loaded, as "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 (Core Profile) Mesa 22.3.6"; empty where
// the backend is not available.
std::string version(Backend backend);

// The largest picture, in px, on each side.
inline constexpr int kMaxPicturePx = 1 << 15;

class Rasterizer {
 public:
  virtual ~Rasterizer() = default;
  virtual Backend backend() const = 0;
  std::string name() const { return backend_name(backend()); }

  // The first triangle through each pixel's centre, seen from both sides. meshes: of this store (placements
  // and uv boxes are taken from it). A face of triangles is drawn too. uv of pixels that nothing covers is
  // not set. threads: 0, all cores; the same bytes for any number. What can be kept for the next call with
  // the same meshes is kept. Throws ArgumentError for a picture without pixels or beyond kMaxPicturePx, or
  // for meshes that do not fit the store; Error where the library fails.
  virtual SeedBuffers draw(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store,
                           const view::Camera& camera, SeedProcess process, int threads = 0) = 0;

  // Does now what the first draw would spend on compiling; loading is done when the rasterizer is made. May
  // run in a thread beside other work.
  virtual void warm_up(SeedProcess process = SeedProcess::kUv) = 0;
};

// Throws Error with the reason where the backend is not available.
std::unique_ptr<Rasterizer> make_rasterizer(Backend backend);

// Whether a backend has drawn a view's meshes before and kept what it needs of them.
enum class Meshes : std::uint8_t { kKept, kFresh };

// The backend that gives seeds soonest for a picture in which about covered_px pixels show something, of a
// mesh of so many triangles; the next best where it is not available, and none where none is. What a library
// takes to load and to compile is left out of it: 35 ms of processor time for OpenGL, 60 where Mesa's cache
// of shaders has nothing yet, 5 for Embree.
std::optional<Backend> choose(double covered_px, std::size_t triangles, Meshes meshes = Meshes::kKept);

}  // namespace trimray::raster
