#include "core/reference/model.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/base/parallel.h"
#include "core/reference/mesh.h"

namespace trimray::reference {
namespace {

using Matrix = glm::mat<3, 3, Real>;

constexpr double kSearchBands = 2.0;  // how far beyond its uv_box a face is searched

// What the p-curves misjudge lies between a p-curve's image and the path: followed along the face's tangent
// plane to where the line passes the path, such a root comes this near to the line, in bands.
constexpr double kCloseBands = 8.0;

// A root so close to one place of one edge, across and along the line, and to no other, is judged by the side
// of the path on which the line passes.
constexpr double kSideBands = 2.0, kSideReach = 16.0;

Line local_line(const trace::Ray& ray, const nurbs::Instance& instance) {
  const Matrix inverse = glm::inverse(Matrix(instance.placement.linear));
  const Vec3 org = inverse * (Vec3(ray.org) - Vec3(instance.placement.translation));
  Line line(dvec3(0.0), dvec3(inverse * Vec3(ray.dir)));
  line.org = org;
  return line;
}

bool usable(const nurbs::Face& face) {
  return face.status == nurbs::FaceStatus::kOk && face.surface >= 0 && !face.is_mesh();
}

}  // namespace

Model::Model(const nurbs::NurbsStore& store, const trace::Ray* only, int threads)
    : store_(store), faces_(store.faces.size()), paths_(store.edges.size()) {
  parallel_ranges(store.edges.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) paths_[e] = edge_path(store, static_cast<std::int32_t>(e));
  });
  std::vector<char> wanted(store.faces.size(), only == nullptr);
  auto margin = [&](std::int32_t face) {
    double band = 0.0;
    for (std::int32_t e : edges_of(face)) band = std::max(band, store.edges[e].band);
    return kSearchBands * band;
  };
  if (only) {
    for (const nurbs::Instance& instance : store.instances) {
      const Line line = local_line(*only, instance);
      const nurbs::Range faces = store.prototypes[instance.prototype].faces;
      for (std::int32_t f = faces.begin; f < faces.end; ++f)
        if (usable(store.faces[f]) && !wanted[f]) wanted[f] = line.meets(rough_box(store, f, margin(f)), 0.0);
    }
  }
  parallel_ranges(store.faces.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::int32_t f = static_cast<std::int32_t>(k);
      if (wanted[k] && usable(store.faces[k])) faces_[k].emplace(store, f, margin(f));
    }
  });
}

std::vector<std::int32_t> Model::edges_of(std::int32_t face) const {
  std::vector<std::int32_t> edges;
  const nurbs::Range loops = store_.faces[face].loops;
  for (std::int32_t l = loops.begin; l < loops.end; ++l)
    for (std::int32_t c = store_.loops[l].coedges.begin; c < store_.loops[l].coedges.end; ++c)
      if (store_.coedges[c].edge >= 0) edges.push_back(store_.coedges[c].edge);
  return edges;
}

int Model::winding(std::int32_t face, const Line& line) const {
  int sum = 0;
  const nurbs::Range loops = store_.faces[face].loops;
  for (std::int32_t l = loops.begin; l < loops.end; ++l)
    for (std::int32_t c = store_.loops[l].coedges.begin; c < store_.loops[l].coedges.end; ++c) {
      const nurbs::CoEdge& use = store_.coedges[c];
      if (use.edge < 0) continue;
      const int crossings = path_crossings(paths_[use.edge], line);
      sum += use.reversed ? -crossings : crossings;
    }
  // Counterclockwise loops go with Su x Sv; the winding that counts goes with the outward normal.
  return sum * faces_[face]->trims().orientation() * (store_.faces[face].reversed ? -1 : 1);
}

// Surface and p-curve give the uv and the normal of a hit that is put on the path.
trace::Root Model::on_path(std::int32_t face, const Line& line, const NearStretch& spot, int sign) const {
  trace::Root root;
  root.t = spot.t, root.face = face, root.sign = static_cast<std::int8_t>(sign), root.inside = true;
  const Vec3 target = line.org + Real(spot.t) * line.dir;
  double best = kInf;
  const nurbs::Range loops = store_.faces[face].loops;
  for (std::int32_t l = loops.begin; l < loops.end; ++l)
    for (std::int32_t c = store_.loops[l].coedges.begin; c < store_.loops[l].coedges.end; ++c) {
      const nurbs::CoEdge& use = store_.coedges[c];
      if (use.edge != spot.edge) continue;
      for (std::int32_t k = use.pieces.begin; k < use.pieces.end; ++k) {
        const nurbs::Range ctrl = store_.trim_pieces[k].ctrl;
        for (int step = 0; step <= 64; ++step) {
          std::vector<dvec3> h(store_.trim_ctrl_h.begin() + ctrl.begin,
                               store_.trim_ctrl_h.begin() + ctrl.end);
          for (std::size_t r = 1; r < h.size(); ++r)
            for (std::size_t i = 0; i + r < h.size(); ++i)
              h[i] = (1.0 - step / 64.0) * h[i] + step / 64.0 * h[i + 1];
          const dvec2 uv = dvec2(h[0]) / h[0].z;
          const FaceModel::Point p = faces_[face]->at(uv);
          const double distance = double(glm::length(p.p - target));
          if (!(distance < best)) continue;
          best = distance, root.uv_face = uv;
          root.normal = dvec3(glm::normalize(store_.faces[face].reversed ? -p.normal : p.normal));
        }
      }
    }
  return root;
}

// The sum alone would let two mistakes at two edges of a face pass.
void Model::decide_by_side(std::int32_t face, const Line& line, std::span<const NearStretch> near,
                           std::vector<trace::Root>& roots) const {
  const nurbs::Range loops = store_.faces[face].loops;
  for (trace::Root& r : roots) {
    const NearStretch* place = nullptr;
    int places = 0;
    for (const NearStretch& spot : near) {
      const double gap = std::abs(r.t - spot.t), band = paths_[spot.edge].band;
      if (gap > kSideReach * band || gap * std::abs(glm::dot(r.normal, dvec3(line.dir))) > kSideBands * band)
        continue;
      place = &spot, ++places;
    }
    if (places != 1 || place->side == 0) continue;
    int sign = 0, uses = 0;
    for (std::int32_t l = loops.begin; l < loops.end; ++l)
      for (std::int32_t c = store_.loops[l].coedges.begin; c < store_.loops[l].coedges.end; ++c)
        if (store_.coedges[c].edge == place->edge) sign += store_.coedges[c].reversed ? -1 : 1, ++uses;
    sign *= faces_[face]->trims().orientation() * (store_.faces[face].reversed ? -1 : 1);
    // A seam has the face on both sides; elsewhere the face lies left of its boundary, seen from outside.
    if (uses == 2 && sign == 0)
      r.inside = true;
    else if (uses == 1)
      r.inside = place->side * sign * r.sign > 0;
  }
}

void Model::resolve(std::int32_t face, const Line& line, std::span<const NearStretch> near,
                    std::vector<trace::Root>& roots) const {
  decide_by_side(face, line, near, roots);
  int missing = winding(face, line);
  for (const trace::Root& r : roots) missing -= r.inside ? r.sign : 0;
  auto closeness = [&](const trace::Root& r) {
    const double slope = std::abs(glm::dot(r.normal, dvec3(line.dir)));
    double best = kInf;
    for (const NearStretch& spot : near)
      best = std::min(best, std::abs(r.t - spot.t) * slope / paths_[spot.edge].band);
    return best;
  };
  std::vector<const NearStretch*> spots;
  for (const NearStretch& spot : near) spots.push_back(&spot);
  std::sort(spots.begin(), spots.end(),
            [](const NearStretch* a, const NearStretch* b) { return a->distance < b->distance; });
  std::size_t next_spot = 0;
  while (missing != 0) {
    const int sign = missing > 0 ? 1 : -1;
    trace::Root* pick = nullptr;
    double closest = kCloseBands;
    for (trace::Root& r : roots) {
      if ((r.inside ? -r.sign : r.sign) != sign) continue;
      const double distance = closeness(r);
      if (distance < closest) closest = distance, pick = &r;
    }
    if (pick)
      pick->inside = !pick->inside;
    else
      roots.push_back(on_path(face, line, *spots[next_spot++ % spots.size()], sign));
    missing -= sign;
  }
}

void Model::instance_hits(const trace::Ray& ray, std::int32_t instance, std::vector<trace::Hit>& out) const {
  const nurbs::Instance& placed = store_.instances[instance];
  const nurbs::Prototype& prototype = store_.prototypes[placed.prototype];
  const Line line = local_line(ray, placed);
  std::vector<std::vector<NearStretch>> near(prototype.faces.size());
  std::vector<NearStretch> stretches;
  for (std::int32_t e = prototype.edges.begin; e < prototype.edges.end; ++e) {
    stretches.clear();
    near_stretches(paths_[e], e, line, stretches);
    if (stretches.empty()) continue;
    const nurbs::Range uses = store_.edges[e].coedges;
    for (std::int32_t k = uses.begin; k < uses.end; ++k) {
      const nurbs::CoEdge& use = store_.coedges[store_.edge_coedges[k]];
      if (use.face < prototype.faces.begin || use.face >= prototype.faces.end) continue;
      std::vector<NearStretch>& list = near[use.face - prototype.faces.begin];
      if (list.empty() || list.back().edge != e) list.insert(list.end(), stretches.begin(), stretches.end());
    }
  }
  const Matrix inverse = glm::inverse(Matrix(placed.placement.linear));
  std::vector<trace::Root> roots;
  for (std::int32_t f = prototype.faces.begin; f < prototype.faces.end; ++f) {
    roots.clear();
    if (store_.faces[f].is_mesh())
      mesh_roots(store_, f, line, roots);
    else if (faces_[f])
      faces_[f]->roots(line, roots);
    const std::vector<NearStretch>& spots = near[f - prototype.faces.begin];
    if (!spots.empty() && faces_[f]) resolve(f, line, spots, roots);
    for (const trace::Root& r : roots) {
      const double t = double(Real(r.t) / line.length);
      if (!r.inside || !(t >= ray.tmin && t <= ray.tmax)) continue;
      const Vec3 normal = glm::normalize(glm::transpose(inverse) * Vec3(r.normal));
      out.push_back({t, f, instance, r.uv_face, dvec3(normal)});
    }
  }
}

std::vector<trace::Hit> Model::hits(const trace::Ray& ray) const {
  std::vector<trace::Hit> out;
  if (!(glm::length(ray.dir) > 0.0) || !(glm::length(ray.dir) < kInf) || !(glm::length(ray.org) < kInf))
    return out;
  for (std::size_t k = 0; k < store_.instances.size(); ++k)
    instance_hits(ray, static_cast<std::int32_t>(k), out);
  std::sort(out.begin(), out.end(), [](const trace::Hit& a, const trace::Hit& b) {
    return std::tie(a.t, a.instance, a.face) < std::tie(b.t, b.instance, b.face);
  });
  return out;
}

}  // namespace trimray::reference
