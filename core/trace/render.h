// The render loop: rays of a camera, in tiles over all cores, to the planes of a Frame.
#pragma once

#include <atomic>

#include "core/nurbs/store.h"
#include "core/trace/caster.h"
#include "core/trace/secondary.h"
#include "core/view/camera.h"
#include "core/view/frame.h"
#include "core/view/shade.h"

namespace trimray::trace {

struct RenderOptions {
  view::Camera camera;
  view::Planes planes;
  view::Background background;
  int samples = 4;           // rays per pixel for the colour, >= 1
  bool orientation = false;  // tint faces that turn their inner side to the eye
  int tile = 32;             // px along the sides of what is traced at once, >= 1; fewer for many samples
                             // and for the plane of times
  SecondaryOptions secondary;
  int threads = 0;  // 0: all cores
};

// Shared with the thread that waits: tiles done of total, and its wish to stop.
struct Progress {
  std::atomic<std::int64_t> done{0}, total{0};
  std::atomic<bool> cancelled{false};
};

// The same bytes for any number of threads. When progress->cancelled is raised, returns within a tile's time,
// with the rest of the frame left at its background values.
view::Frame render(const nurbs::NurbsStore& store, const Caster& caster, const RenderOptions& options,
                   Progress* progress = nullptr);

}  // namespace trimray::trace
