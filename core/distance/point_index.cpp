#include "core/distance/point_index.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/distance/prototype_index.h"
#include "core/distance/stretched_store.h"

namespace trimray::distance {

using nurbs::NurbsStore;

namespace {

constexpr double kSimilar =
    1e-13;  // of the scale: placements that stretch directions more differently do not

struct PlacedIndex {
  const PrototypeIndex* index = nullptr;
  double scale = 1.0;
  dmat3 linear{1.0}, inverse{1.0};
  dvec3 translation{0.0};
};

// The one factor by which a placement stretches all lengths.
std::optional<double> scale_of(const dmat3& m) {
  const double scale = std::cbrt(std::abs(glm::determinant(m)));
  if (!(scale > 0.0) || !std::isfinite(scale)) return {};
  const dmat3 gram = glm::transpose(m) * m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(gram[i][j] / (scale * scale) - (i == j ? 1.0 : 0.0)) <= kSimilar * 10.0)) return {};
  return scale;
}

Box3 placed(const Transform& placement, const Box3& box) {
  Box3 out;
  if (box.empty()) return out;
  for (int corner = 0; corner < 8; ++corner)
    out.add(placement.point({(corner & 1 ? box.upper : box.lower).x, (corner & 2 ? box.upper : box.lower).y,
                             (corner & 4 ? box.upper : box.lower).z}));
  const dvec3 far = glm::max(glm::abs(out.lower), glm::abs(out.upper));
  out.dilate(1e-14 * (far.x + far.y + far.z));
  return out;
}

}  // namespace

struct PointIndex::Impl {
  std::shared_ptr<const NurbsStore> store;
  nurbs::TrimIndex trims;
  std::vector<std::unique_ptr<PrototypeIndex>> prototypes;
  // Of instances whose placement is no similarity: a store and an index of their own.
  struct Stretched {
    NurbsStore store;
    nurbs::TrimIndex trims;
    std::unique_ptr<PrototypeIndex> index;
  };
  std::vector<std::unique_ptr<Stretched>> stretched;
  std::vector<PlacedIndex> instances;
  trace::Bvh bvh;
  double diagonal = 0.0, slack = 0.0;
  std::vector<std::int32_t> left_out;
  IndexStats stats;

  Impl(std::shared_ptr<const NurbsStore> s, int threads) : store(std::move(s)), trims(*store, threads) {
    prototypes.resize(store->prototypes.size());
    const bool many = prototypes.size() > 4;
    parallel_ranges(prototypes.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        prototypes[i] =
            std::make_unique<PrototypeIndex>(*store, static_cast<std::int32_t>(i), trims, many ? 1 : threads);
    });
    std::vector<Box3> boxes;
    Box3 all;
    for (const nurbs::Instance& instance : store->instances) {
      boxes.push_back(place(instance));
      all.add(boxes.back());
    }
    bvh = trace::build_bvh(boxes);
    diagonal = all.diagonal(), slack = 0.1 * kDistanceTol * diagonal;
    for (const auto& p : prototypes) count(*p);
    for (const auto& p : stretched) count(*p->index);
    std::sort(left_out.begin(), left_out.end());
    left_out.erase(std::unique(left_out.begin(), left_out.end()), left_out.end());
  }

  // Appends the instance; its box in the world, empty where there is nothing to search.
  Box3 place(const nurbs::Instance& instance) {
    const Transform& placement = instance.placement;
    PlacedIndex p;
    p.index = prototypes[instance.prototype].get();
    p.linear = placement.linear, p.translation = placement.translation;
    Box3 box;
    if (const std::optional<double> scale = scale_of(placement.linear)) {
      p.scale = *scale, p.inverse = glm::inverse(placement.linear);
      box = placed(placement, p.index->box);
    } else if (NurbsStore copy; stretch_prototype(*store, instance.prototype, placement, copy)) {
      auto s =
          std::make_unique<Stretched>(Stretched{std::move(copy), nurbs::TrimIndex(NurbsStore{}), nullptr});
      s->trims = nurbs::TrimIndex(s->store);
      s->index = std::make_unique<PrototypeIndex>(s->store, instance.prototype, s->trims, 1);
      p.index = s->index.get(), p.linear = dmat3(1.0), p.translation = dvec3(0.0);
      box = s->index->box;
      stretched.push_back(std::move(s));
    }
    instances.push_back(p);
    const bool sound = !box.empty() && std::isfinite(box.diagonal());
    return sound ? box : Box3{};
  }

  void count(const PrototypeIndex& p) {
    left_out.insert(left_out.end(), p.left_out.begin(), p.left_out.end());
    stats.surface_leaves += static_cast<std::int64_t>(p.surfaces.size());
    stats.closed_leaves += static_cast<std::int64_t>(p.closed_leaves.size());
    stats.triangle_blocks += static_cast<std::int64_t>(p.triangles.blocks.size());
    stats.edge_leaves += static_cast<std::int64_t>(p.edges.size());
    stats.bytes += p.bvh.bytes() + p.edge_bvh.bytes() + p.surfaces.bytes() + p.edges.bytes() +
                   p.triangles.bytes() +
                   static_cast<std::int64_t>(p.closed_leaves.size() * sizeof(trace::ClosedLeaf));
  }

  Nearest nearest(const dvec3& point, bool edges_only, Workspace& work) const {
    Nearest best;
    if (!std::isfinite(point.x + point.y + point.z)) return best;
    LocalNearest found;
    std::int32_t found_in = -1;
    work.parts_left = kMaxParts, work.unsearched = kInf;
    visit_nearest(
        bvh, point, [&] { return best.distance; },
        [&](std::int32_t i) {
          const PlacedIndex& instance = instances[i];
          const dvec3 q = instance.inverse * (point - instance.translation);
          LocalNearest local;
          local.face.distance = local.edge.distance = best.distance / instance.scale;
          const double unsearched = std::exchange(work.unsearched, kInf);
          instance.index->search(q, slack / instance.scale, edges_only, local, work);
          work.unsearched = std::min(unsearched, work.unsearched * instance.scale);
          const double distance = local.distance() * instance.scale;
          if (!(distance < best.distance) || (local.face_index == kNoFace && local.edge.edge < 0)) return;
          best.distance = distance, found = local, found_in = i;
        });
    if (found_in < 0) return best;
    const PlacedIndex& instance = instances[found_in];
    const bool on_edge =
        found.edge.edge >= 0 &&
        (found.face_index == kNoFace || found.edge.distance <= found.face.distance + slack / instance.scale);
    const dvec3 p = on_edge ? found.edge.p : found.face.p;
    best.distance = instance.scale * (on_edge ? found.edge.distance : found.face.distance);
    best.point = instance.linear * p + instance.translation, best.instance = found_in;
    const double gap = best.distance - work.unsearched;
    if (gap > kDistanceTol * diagonal) best.gap = gap;
    if (on_edge) {
      best.edge = found.edge.edge;
      best.band = store->edges[best.edge].band * instance.scale;
      instance.index->place_on_face(found.edge, best.face, best.uv_face);
    } else {
      best.face = found.face_index, best.uv_face = found.face.uv_face;
    }
    return best;
  }
};

PointIndex::PointIndex(std::shared_ptr<const NurbsStore> store, int threads)
    : impl_(std::make_unique<Impl>(std::move(store), threads)) {}
PointIndex::PointIndex(PointIndex&&) noexcept = default;
PointIndex::~PointIndex() = default;

void PointIndex::nearest(std::span<const dvec3> points, std::span<Nearest> out, int threads,
                         bool edges_only) const {
  if (out.size() != points.size()) throw ArgumentError("as many answers as points are wanted");
  PerThread<Workspace> spaces;
  parallel_ranges(points.size(), 64, threads, [&](std::size_t begin, std::size_t end) {
    Workspace& work = spaces.local();
    for (std::size_t i = begin; i < end; ++i) out[i] = impl_->nearest(points[i], edges_only, work);
  });
}

Nearest PointIndex::nearest(const dvec3& point, bool edges_only) const {
  Workspace work;
  return impl_->nearest(point, edges_only, work);
}

double PointIndex::diagonal() const { return impl_->diagonal; }
std::span<const std::int32_t> PointIndex::left_out() const { return impl_->left_out; }
const IndexStats& PointIndex::stats() const { return impl_->stats; }

}  // namespace trimray::distance
