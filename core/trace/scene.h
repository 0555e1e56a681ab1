// A store made ready for rays: hierarchies, trim indices, edge rules. Immutable after construction;
// every method may be called from many threads.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/nurbs/store.h"
#include "core/trace/ray.h"

namespace trimray::trace {

// Counters of one call, for reports and tests (never milliseconds in tests).
struct TraceStats {
  std::uint64_t rays = 0, nodes = 0, leaves = 0, newton_steps = 0, certified = 0, fallbacks = 0,
                trim_tests = 0, edge_rays = 0;
  std::uint64_t given_up = 0;  // searches for roots that ended early: rays that lie in a surface may miss it
};

struct SceneStats {
  std::int64_t bytes = 0, leaf_boxes = 0;
  std::int64_t refused_patches = 0;  // missing, a weight not being positive
  double build_seconds = 0.0;
};

// kPaper: many small boxes, the way of Abert, Broecker, Spring (WSCG 2008): each surface is cut uniformly
// until its parts are about as flat as theirs (their teapot of 32 surfaces has 13,018 boxes, their Cornell
// box of 18 has 445). Surfaces with a closed form keep it, with boxes of that size. kTuned: as few boxes as
// give each ray little more than one solve.
enum class LeafBoxes { kTuned, kPaper };

// The defaults are the fastest; the others are a baseline for measurements. The hits are the same.
struct SceneOptions {
  LeafBoxes boxes = LeafBoxes::kTuned;
  int packet = 64;  // consecutive rays that go through the hierarchy together, 1 to 64; the paper: 4
};

class Scene {
 public:
  // Throws ArgumentError for a packet that is not from 1 to 64.
  explicit Scene(std::shared_ptr<const nurbs::NurbsStore> store, int threads = 0,
                 const SceneOptions& options = {});
  Scene(Scene&&) noexcept;
  ~Scene();

  const nurbs::NurbsStore& store() const;
  const SceneStats& stats() const;

  // Nearest hits; out.size() == rays.size(). The same bytes for any number of threads and any grouping of
  // the rays.
  void cast(std::span<const Ray> rays, std::span<Hit> out, int threads = 0,
            TraceStats* stats = nullptr) const;

  // Every hit of one ray in [tmin, tmax], sorted by t.
  void cast_all(const Ray& ray, std::vector<Hit>& out) const;

  // Crossings per ray in [tmin, tmax]: even on closed solids for rays that start outside.
  void count_hits(std::span<const Ray> rays, std::span<std::int32_t> out, int threads = 0) const;

  // Does the ray pass within the band of some edge at a t in [tmin, tmax]? Only then does the answer depend
  // on the edge rule, within the file's own tolerance.
  bool near_edge(const Ray& ray) const;

  struct Impl;                                 // core/trace/scene_impl.h
  const Impl& impl() const { return *impl_; }  // for the hybrid tracer

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace trimray::trace
