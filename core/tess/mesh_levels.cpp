#include "core/tess/mesh_levels.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace trimray::tess {

using nurbs::NurbsStore;
using nurbs::Prototype;

namespace {

constexpr double kFiner = 2.0;   // by how much a mesh may be finer than it must
constexpr double kSpread = 2.0;  // of the tolerance over an instance that one level serves
// Part of an instance's box that must be in the picture for a level. A box is larger than what is in it, and
// a level lasts longer than a mesh that is cut.
constexpr double kSeen = 0.5;

// The power of the root of two that is not above it.
double quantized(double tolerance) { return std::exp2(0.5 * std::floor(2.0 * std::log2(tolerance) + 1e-9)); }

std::size_t bytes_of(const Tessellation& t) {
  const TriMesh& m = t.mesh;
  return sizeof(t) + m.vertices.size() * sizeof(m.vertices[0]) +
         m.triangles.size() *
             (sizeof(m.triangles[0]) + sizeof(m.corner_uv[0]) + sizeof(m.face[0]) + sizeof(m.deviation[0]));
}

// Without the triangles whose part of the surface cannot be in the picture.
TriMesh cut(const TriMesh& mesh, const ViewTolerance& view) {
  TriMesh out;
  std::vector<std::int32_t> number(mesh.vertices.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Box3 box;
    for (const std::int32_t v : mesh.triangles[t]) box.add(mesh.vertices[v]);
    if (mesh.deviation[t] < kInf) {
      box.dilate(mesh.deviation[t]);
      if (view.outside(box)) continue;
    }
    std::array<std::int32_t, 3> corner = mesh.triangles[t];
    for (std::int32_t& v : corner) {
      if (number[v] < 0) {
        number[v] = static_cast<std::int32_t>(out.vertices.size());
        out.vertices.push_back(mesh.vertices[v]);
      }
      v = number[v];
    }
    out.triangles.push_back(corner);
    out.corner_uv.push_back(mesh.corner_uv[t]);
    out.face.push_back(mesh.face[t]);
    out.deviation.push_back(mesh.deviation[t]);
  }
  return out;
}

Box3 placed(const Box3& box, const Transform& placement) {
  const dvec3 half = 0.5 * box.extent(), centre = placement.point(box.center());
  const dvec3 reach = glm::abs(placement.linear[0]) * half.x + glm::abs(placement.linear[1]) * half.y +
                      glm::abs(placement.linear[2]) * half.z;
  return {centre - reach, centre + reach};
}

}  // namespace

struct MeshLevels::Kept {
  std::int32_t prototype = -1;
  std::int32_t instance = -1;           // of a cut mesh
  double tolerance = 0.0;               // mm
  std::unique_ptr<ViewTolerance> view;  // of a cut mesh
  std::uint64_t used = 0;               // the last call that did
  std::size_t bytes = 0;
  std::shared_ptr<const Tessellation> mesh;
};

struct MeshLevels::Wish {
  std::int32_t instance = -1, prototype = -1;
  ViewTolerance view;
  double tolerance = 0.0;
  bool whole = false;  // one level is as good as a mesh of its own
};

MeshLevels::MeshLevels(std::shared_ptr<const NurbsStore> store, const LevelOptions& options)
    : store_(std::move(store)), options_(options), kept_(store_->prototypes.size()) {
  Box3 bounds;
  for (const nurbs::Instance& i : store_->instances) {
    const Box3& box = store_->prototypes[i.prototype].bounds;
    if (!box.empty()) bounds.add(placed(box, i.placement));
  }
  if (bounds.diagonal() > 0.0) near_ = 1e-4 * bounds.diagonal();
}

std::size_t MeshLevels::bytes() const {
  const std::lock_guard lock(mutex_);
  std::size_t sum = 0;
  for (const auto& of_prototype : kept_)
    for (const auto& k : of_prototype) sum += k->bytes;
  return sum;
}

// The coarsest one that serves.
std::shared_ptr<MeshLevels::Kept> MeshLevels::level_for(std::int32_t prototype, double tolerance) const {
  std::shared_ptr<Kept> best;
  for (const auto& k : kept_[prototype])
    if (k->instance < 0 && k->tolerance <= tolerance * (1.0 + 1e-9) && tolerance <= kFiner * k->tolerance &&
        (!best || k->tolerance > best->tolerance))
      best = k;
  return best;
}

std::shared_ptr<MeshLevels::Kept> MeshLevels::cut_for(const Wish& wish) const {
  const Box3& bounds = store_->prototypes[wish.prototype].bounds;
  for (const auto& k : kept_[wish.prototype])
    if (k->instance == wish.instance && k->view->serves(wish.view, bounds, kFiner)) return k;
  return nullptr;
}

ViewMeshes MeshLevels::meshes(const view::Camera& camera, double deviation_px, int threads) {
  if (!(deviation_px > 0.0 && deviation_px < kInf)) throw ArgumentError("deviation must be above 0 px");
  const std::lock_guard lock(mutex_);
  ++calls_;
  const ViewLimits limits{.deviation_px = deviation_px, .near = near_};
  std::vector<Wish> wishes;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(store_->instances.size()); ++i) {
    const nurbs::Instance& instance = store_->instances[i];
    const Box3& bounds = store_->prototypes[instance.prototype].bounds;
    if (bounds.empty()) continue;
    const ViewTolerance view(camera, limits, instance.placement);
    if (view.outside(bounds)) continue;
    const double least = view.at(bounds);
    if (!(least > 0.0)) continue;  // placed by what are no numbers
    wishes.push_back({i, instance.prototype, view, least,
                      view.share(bounds) >= kSeen && view.most(bounds) <= kSpread * least});
  }
  // Levels first, the finest of a prototype first: it may serve others, and cut instances as well.
  std::vector<std::size_t> order(wishes.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Wish &x = wishes[a], &y = wishes[b];
    return std::tuple(!x.whole, x.prototype, x.tolerance) < std::tuple(!y.whole, y.prototype, y.tolerance);
  });

  ViewMeshes result;
  std::vector<std::shared_ptr<Kept>> chosen(wishes.size()), fresh;
  for (const std::size_t w : order) {
    const Wish& wish = wishes[w];
    std::shared_ptr<Kept> k = level_for(wish.prototype, wish.tolerance);
    if (!k && !wish.whole) k = cut_for(wish);
    if (!k) {
      k = std::make_shared<Kept>();
      k->prototype = wish.prototype;
      k->tolerance = quantized(wish.tolerance);
      if (!wish.whole) {
        k->instance = wish.instance;
        // Views that this mesh serves may have a larger deviation, and with it a wider rim.
        const double longer = std::max(camera.width_px, camera.height_px);
        const ViewLimits wider{.deviation_px = deviation_px * (k->tolerance / wish.tolerance),
                               .near = near_,
                               .guard_px = kFiner * deviation_px + options_.guard * longer};
        k->view = std::make_unique<ViewTolerance>(camera, wider, store_->instances[wish.instance].placement);
      }
      fresh.push_back(k), kept_[wish.prototype].push_back(k);
      ++result.built;
    } else if (k->used != calls_) {
      ++result.reused;
    }
    k->used = calls_;
    chosen[w] = k;
  }
  try {
    build(fresh, threads);
  } catch (...) {
    for (auto& of_prototype : kept_) std::erase_if(of_prototype, [](const auto& k) { return !k->mesh; });
    throw;
  }
  for (std::size_t w = 0; w < wishes.size(); ++w) {
    const Kept& k = *chosen[w];
    result.instances.push_back({wishes[w].instance, k.mesh, k.tolerance, k.instance >= 0});
    result.triangles += k.mesh->mesh.triangles.size();
  }
  drop();
  return result;
}

void MeshLevels::build(const std::vector<std::shared_ptr<Kept>>& fresh, int threads) const {
  parallel_ranges(fresh.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Kept& k = *fresh[i];
      const TessOptions options{.angle = options_.angle, .threads = threads};
      auto made = std::make_shared<Tessellation>(
          k.view ? tessellate(*store_, k.prototype, *k.view, options)
                 : tessellate(*store_, k.prototype, UniformTolerance(k.tolerance), options));
      if (k.view) made->mesh = cut(made->mesh, *k.view);
      k.bytes = bytes_of(*made);
      k.mesh = std::move(made);
    }
  });
}

void MeshLevels::drop() {
  std::vector<std::shared_ptr<Kept>> all;
  std::size_t sum = 0;
  for (const auto& of_prototype : kept_)
    for (const auto& k : of_prototype) all.push_back(k), sum += k->bytes;
  if (sum <= options_.max_bytes) return;
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a->used < b->used; });
  for (const auto& k : all) {
    if (sum <= options_.max_bytes) break;
    sum -= k->bytes;
    std::erase(kept_[k->prototype], k);
  }
}

}  // namespace trimray::tess
