#include "core/trace/edge_rule.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/nurbs/surface.h"
#include "core/nurbs/trim_bezier.h"
#include "core/trace/edge_rule_loops.h"
#include "core/trace/edge_rule_path.h"
#include "core/trace/edge_rule_tree.h"

namespace trimray::trace {
namespace {

// A root counts as close to a near edge when, moved along the face's tangent plane to where the ray
// passes the edge, it changes its distance from the ray by at most this many bands.
constexpr double kCloseBands = 8.0;

// A root this close to one place of one edge, and to no other, is on the face's side of the path or not.
constexpr double kSideBands = 2.0, kSideReach = 16.0;

// One use of an edge by a face: its part of the boundary winding.
struct Use {
  std::int32_t local_edge = -1, coedge = -1;
  int sign = 0;
};

}  // namespace

struct EdgeRule::Impl {
  Impl(const nurbs::NurbsStore& s, std::int32_t prototype) : store(s), paths(s, prototype), tree(paths) {
    const nurbs::Range faces = s.prototypes[prototype].faces;
    first_face = faces.begin;
    for (std::int32_t f = faces.begin; f < faces.end; ++f) {
      face_uses.push_back({static_cast<std::int32_t>(uses.size()), 0});
      if (s.faces[f].status == nurbs::FaceStatus::kOk) add_face(f);
      face_uses.back().end = static_cast<std::int32_t>(uses.size());
    }
  }

  void add_face(std::int32_t face) {
    const std::vector<int> signs = loop_signs(store, face);
    const nurbs::Range loops = store.faces[face].loops;
    for (std::int32_t l = loops.begin; l < loops.end; ++l) {
      const int loop_sign = store.faces[face].reversed ? -signs[l - loops.begin] : signs[l - loops.begin];
      for (std::int32_t c = store.loops[l].coedges.begin; c < store.loops[l].coedges.end; ++c) {
        const nurbs::CoEdge& coedge = store.coedges[c];
        const std::int32_t local = coedge.edge - paths.first_edge;
        if (local < 0 || local >= static_cast<std::int32_t>(paths.edges.size())) continue;
        uses.push_back({local, c, coedge.reversed ? -loop_sign : loop_sign});
      }
    }
  }

  std::span<const Use> of_face(std::int32_t face) const {
    const nurbs::Range r = face_uses[face - first_face];
    return {uses.data() + r.begin, static_cast<std::size_t>(r.size())};
  }

  int winding(const RayFrame& frame, std::int32_t face) const {
    int sum = 0;
    for (const Use& use : of_face(face)) sum += use.sign * paths.crossings(use.local_edge, frame);
    return sum;
  }

  const Use* use_of(std::int32_t face, std::int32_t edge) const {
    for (const Use& use : of_face(face))
      if (use.local_edge == edge - paths.first_edge) return &use;
    return nullptr;
  }

  // The face uses the edge twice, once in each direction: it goes on across the edge.
  bool is_seam(std::int32_t face, std::int32_t edge) const {
    int count = 0, sign = 0;
    for (const Use& use : of_face(face))
      if (use.local_edge == edge - paths.first_edge) sign += use.sign, ++count;
    return count == 2 && sign == 0;
  }

  // Null when the face uses the edge more than once.
  const Use* only_use(std::int32_t face, std::int32_t edge) const {
    const Use* found = nullptr;
    for (const Use& use : of_face(face)) {
      if (use.local_edge != edge - paths.first_edge) continue;
      if (found) return nullptr;
      found = &use;
    }
    return found;
  }

  void decide_by_side(const Ray& ray, std::int32_t face, std::span<const NearEdge* const> own,
                      std::vector<Root>& roots) const;
  Root root_on_edge(const Ray& ray, std::int32_t face, const NearEdge& near, int sign) const;

  const nurbs::NurbsStore& store;
  EdgePaths paths;
  EdgeTree tree;
  std::int32_t first_face = 0;
  std::vector<nurbs::Range> face_uses;  // into uses, by face - first_face
  std::vector<Use> uses;
};

EdgeRule::EdgeRule(const nurbs::NurbsStore& store, std::int32_t prototype)
    : impl_(std::make_unique<Impl>(store, prototype)) {}
EdgeRule::EdgeRule(EdgeRule&&) noexcept = default;
EdgeRule& EdgeRule::operator=(EdgeRule&&) noexcept = default;
EdgeRule::~EdgeRule() = default;

void EdgeRule::near_edges(const Ray& ray, std::vector<NearEdge>& out) const {
  impl_->tree.near_edges(ray, impl_->paths.frame(ray), out);
}

bool EdgeRule::may_be_near(const Ray& ray) const {
  return impl_->tree.may_be_near(ray, impl_->paths.frame(ray));
}

int EdgeRule::winding(const Ray& ray, std::int32_t face) const {
  return impl_->winding(impl_->paths.frame(ray), face);
}

namespace {

dvec2 trim_point(const nurbs::NurbsStore& store, std::int32_t piece, double s) {
  const nurbs::Range r = store.trim_pieces[piece].ctrl;
  const dvec3 h = nurbs::evaluate_bezier<dvec3>(
      {store.trim_ctrl_h.data() + r.begin, static_cast<std::size_t>(r.size())}, s);
  return {h.x / h.z, h.y / h.z};
}

// The point of a co-edge's p-curve whose place on the surface is next to `point`. The curve's own parameter
// only says about where: rational pieces run unevenly.
dvec2 nearest_uv(const nurbs::NurbsStore& store, const nurbs::Surface& surface, nurbs::Range pieces,
                 dvec3 point) {
  constexpr int kSamples = 12, kSteps = 40;
  const auto distance = [&](std::int32_t piece, double s) {
    return glm::length(nurbs::evaluate(store, surface, trim_point(store, piece, s)).p - point);
  };
  double best = kInf, best_s = 0.0;
  std::int32_t best_piece = pieces.begin;
  for (std::int32_t p = pieces.begin; p < pieces.end; ++p) {
    for (int i = 0; i <= kSamples; ++i) {
      const double s = static_cast<double>(i) / kSamples, d = distance(p, s);
      if (d < best) best = d, best_piece = p, best_s = s;
    }
  }
  double step = 1.0 / kSamples;
  for (int i = 0; i < kSteps; ++i, step *= 0.5) {
    for (const double s : {best_s - step, best_s + step}) {
      if (s < 0.0 || s > 1.0) continue;
      const double d = distance(best_piece, s);
      if (d < best) best = d, best_s = s;
    }
  }
  return trim_point(store, best_piece, best_s);
}

}  // namespace

// A hit on the edge path itself, where the surface gives none.
Root EdgeRule::Impl::root_on_edge(const Ray& ray, std::int32_t face, const NearEdge& near, int sign) const {
  Root root;
  root.t = near.t;
  root.face = face;
  root.sign = static_cast<std::int8_t>(sign);
  root.inside = true;
  const nurbs::Face& f = store.faces[face];
  const nurbs::Surface& surface = store.surfaces[f.surface];
  const nurbs::Range pieces = store.coedges[use_of(face, near.edge)->coedge].pieces;
  if (pieces.size() > 0) root.uv_face = nearest_uv(store, surface, pieces, ray.org + near.t * ray.dir);
  const nurbs::SurfacePoint at = nurbs::evaluate(store, surface, root.uv_face);
  const dvec3 normal = glm::cross(at.du, at.dv);
  const double length = glm::length(normal);
  // At a pole the surface has no normal: any that faces the right way.
  root.normal =
      length > 0.0 ? normal * ((f.reversed ? -1.0 : 1.0) / length) : ray.dir * static_cast<double>(sign);
  return root;
}

// Where a root lies at one place of one edge, the side of the path decides, the same for both faces. The sum
// alone would let two mistakes at two edges of a face pass.
void EdgeRule::Impl::decide_by_side(const Ray& ray, std::int32_t face, std::span<const NearEdge* const> own,
                                    std::vector<Root>& roots) const {
  for (Root& r : roots) {
    const NearEdge* place = nullptr;
    int places = 0, seams = 0;
    for (const NearEdge* n : own) {
      const double band = store.edges[n->edge].band, gap = std::abs(r.t - n->t);
      if (gap > kSideReach * band || gap * std::abs(glm::dot(r.normal, ray.dir)) > kSideBands * band)
        continue;
      place = n, ++places;
      seams += is_seam(face, n->edge);
    }
    // On a seam, and where seams cross, the face is on all sides, whatever rounding makes of uv there.
    if (places > 0 && seams == places) {
      r.inside = true;
    } else if (places == 1 && place->side != 0) {
      // Elsewhere the face lies to the left of its boundary as seen from outside.
      const Use* use = only_use(face, place->edge);
      if (use) r.inside = place->side * use->sign * r.sign > 0;
    }
  }
}

void EdgeRule::resolve(const Ray& ray, std::int32_t face, std::span<const NearEdge> near,
                       std::vector<Root>& roots) const {
  const Impl& m = *impl_;
  const auto finish = [&] {
    std::erase_if(roots, [](const Root& r) { return !r.inside; });
    std::sort(roots.begin(), roots.end(),
              [](const Root& a, const Root& b) { return a.t != b.t ? a.t < b.t : a.sign < b.sign; });
  };
  std::vector<const NearEdge*> own;
  for (const NearEdge& n : near)
    if (m.use_of(face, n.edge)) own.push_back(&n);
  if (own.empty()) return finish();
  std::sort(own.begin(), own.end(), [](const NearEdge* a, const NearEdge* b) {
    return std::tie(a->distance, a->edge, a->t) < std::tie(b->distance, b->edge, b->t);
  });

  m.decide_by_side(ray, face, own, roots);
  int sum = 0;
  for (const Root& r : roots) sum += r.inside ? r.sign : 0;
  const int wanted = m.winding(m.paths.frame(ray), face);
  if (sum == wanted) return finish();

  // In bands: along a surface that the ray grazes, a small gap at the edge is a long way for the root.
  const auto closeness = [&](const Root& r) {
    double best = kInf;
    for (const NearEdge* n : own) {
      const double band = m.store.edges[n->edge].band;
      best = std::min(best,
                      std::abs(r.t - n->t) * std::abs(glm::dot(r.normal, ray.dir)) / std::max(band, 1e-300));
    }
    return best;
  };
  std::size_t next_edge = 0;
  bool far_too = false;  // roots that are nowhere near an edge, when nothing else is left
  while (sum != wanted) {
    const int need = sum < wanted ? 1 : -1;
    Root* best = nullptr;
    double best_closeness = far_too ? kInf : kCloseBands;
    for (Root& r : roots) {
      // Letting in a root of the needed sign or throwing out one of the other sign does the same.
      if (r.sign != (r.inside ? -need : need)) continue;
      const double c = far_too ? std::min(closeness(r), 1e300) : closeness(r);
      if (c < best_closeness) best_closeness = c, best = &r;
    }
    if (best) {
      best->inside = !best->inside;
      sum += need;
    } else if (next_edge < 2 * own.size() + 2) {
      // A cap on their number: a face wound many times about the ray is a damaged one.
      roots.push_back(m.root_on_edge(ray, face, *own[next_edge++ % own.size()], need));
      sum += need;
    } else if (!far_too) {
      far_too = true;
    } else {
      break;
    }
  }
  finish();
}

}  // namespace trimray::trace
