#include "core/trace/patch.h"

#include <algorithm>
#include <bit>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/trace/clipping.h"
#include "core/trace/newton.h"
#include "core/trace/newton_seeded.h"
#include "core/trace/open_lanes.h"
#include "core/trace/patch_build.h"
#include "core/trace/patch_data.h"
#include "core/trace/patch_offset.h"

namespace trimray::trace {

namespace {
thread_local std::uint64_t given_up = 0;
}

std::uint64_t searches_given_up() { return given_up; }

PatchSet::PatchSet(const nurbs::NurbsStore& store, std::int32_t prototype, std::span<const double> margin_mm,
                   int threads, const LeafDetail& detail)
    : impl_(std::make_unique<Impl>()) {
  const nurbs::Range faces = store.prototypes[prototype].faces;
  if (margin_mm.size() != static_cast<std::size_t>(faces.size()))
    throw ArgumentError("PatchSet: one margin per face of the prototype is needed");
  std::vector<PatchPool> pools(faces.size());
  parallel_ranges(pools.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::int32_t face = faces.begin + static_cast<std::int32_t>(i);
      const nurbs::Face& f = store.faces[face];
      if (f.status != nurbs::FaceStatus::kOk || f.surface < 0) continue;
      switch (store.surfaces[f.surface].kind) {
        case nurbs::SurfaceKind::kExtrusion:
        case nurbs::SurfaceKind::kRevolution:
        case nurbs::SurfaceKind::kBezier:
        case nurbs::SurfaceKind::kBspline:
        case nurbs::SurfaceKind::kOffset:
          append_face(store, face, margin_mm[i], detail, pools[i]);
          break;
        default:
          break;
      }
    }
  });
  impl_->first_face = faces.begin;
  for (PatchPool& pool : pools) {
    pool.grids.resize(1);  // faces without patches: an empty one
    append_pool(pool, *impl_);
    pool = PatchPool();
  }
}

PatchSet::PatchSet(PatchSet&&) noexcept = default;
PatchSet::~PatchSet() = default;

std::span<const PatchLeaf> PatchSet::leaves() const { return impl_->leaves; }

OrientedBox PatchSet::oriented_box(std::int32_t leaf) const {
  const LeafBound& bound = impl_->bounds[leaf];
  const auto vec = [](const double(&v)[3]) { return dvec3(v[0], v[1], v[2]); };
  return {impl_->patches[impl_->leaves[leaf].patch].origin + vec(bound.center),
          {vec(bound.a), vec(bound.b), vec(bound.k)}};
}

std::int64_t PatchSet::bytes() const {
  const auto size = [](const auto& v) { return static_cast<std::int64_t>(v.capacity() * sizeof(v[0])); };
  return size(impl_->patches) + size(impl_->net) + size(impl_->coef) + size(impl_->bounds) +
         size(impl_->leaves) + size(impl_->splits) + size(impl_->leaf_cells) + size(impl_->grids) +
         size(impl_->breaks) + size(impl_->cells);
}

std::int64_t PatchSet::refused() const { return impl_->refused; }

void PatchSet::solve(std::int32_t leaf, const RayLanes& rays, RootLanes& out) const {
  const Patch& patch = impl_->patches[impl_->leaves[leaf].patch];
  solve_leaf(patch, impl_->coef.data() + patch.coef, impl_->bounds[leaf], rays, out);
  out.patch = impl_->leaves[leaf].patch;
}

std::int32_t PatchSet::patch_at(std::int32_t face, dvec2 uv_face) const {
  const PatchGrid& grid = impl_->grids[face - impl_->first_face];
  if (grid.count_u == 0 || grid.count_v == 0) return -1;
  const double* u = impl_->breaks.data() + grid.breaks;
  const double* v = u + grid.count_u - 1;
  const auto i = std::upper_bound(u, v, uv_face.x) - u;
  const auto j = std::upper_bound(v, v + grid.count_v - 1, uv_face.y) - v;
  return impl_->cells[grid.cells + i * grid.count_v + j];
}

void PatchSet::solve_seeded(std::int32_t patch, const RayLanes& rays, const SeedLanes& seeds,
                            SeededRoots& out) const {
  solve_from_seeds(impl_->patches[patch], *impl_, rays, seeds, out);
}

std::uint32_t PatchSet::rules_out(std::int32_t leaf, const RayLanes& rays, const double* param_u,
                                  const double* param_v) const {
  return lies_beside(impl_->bounds[leaf], rays, param_u, param_v);
}

namespace {

Root make_root(const Patch& patch, const PatchRoot& r, const dvec3& dir) {
  Root root;
  root.t = r.t;
  root.uv_face = dvec2(patch.u.to_face(r.u), patch.v.to_face(r.v));
  root.normal = patch.reversed ? -r.normal : r.normal;
  root.face = patch.face;
  root.sign = glm::dot(root.normal, dir) > 0.0 ? 1 : -1;
  return root;
}

}  // namespace

bool PatchSet::all_roots(std::int32_t leaf, const Ray& ray, std::vector<Root>& out) const {
  const Patch& patch = impl_->patches[impl_->leaves[leaf].patch];
  thread_local std::vector<PatchRoot> roots;
  roots.clear();
  const ClipStats stats = patch.offset != 0.0 ? offset_roots(patch, *impl_, impl_->bounds[leaf], ray, roots)
                                              : clip_roots(patch, *impl_, impl_->bounds[leaf], ray, roots);
  for (const PatchRoot& r : roots) out.push_back(make_root(patch, r, ray.dir));
  given_up += stats.exhausted;
  return !stats.exhausted;
}

int PatchSet::open_roots(std::int32_t leaf, const RayLanes& rays, std::vector<LaneRoot>& out) const {
  const Patch& patch = impl_->patches[impl_->leaves[leaf].patch];
  const auto dir = [&](int i) { return dvec3(rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]); };
  if (patch.offset != 0.0) {
    thread_local std::vector<Root> found;
    for (std::uint32_t rest = rays.active; rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      found.clear();
      all_roots(leaf, {dvec3(rays.org_x[i], rays.org_y[i], rays.org_z[i]), dir(i)}, found);
      for (const Root& root : found) out.push_back({i, root});
    }
    return std::popcount(rays.active);
  }
  thread_local std::vector<LanePatchRoot> roots;
  roots.clear();
  const OpenStats stats = open_lane_roots(patch, *impl_, impl_->bounds[leaf], rays, roots);
  given_up += stats.exhausted;
  for (const LanePatchRoot& r : roots) out.push_back({r.lane, make_root(patch, r.root, dir(r.lane))});
  return stats.searched;
}

}  // namespace trimray::trace
