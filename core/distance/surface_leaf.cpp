#include "core/distance/surface_leaf.h"

#include <algorithm>
#include <cmath>

#include "core/distance/nearest.h"
#include "core/nurbs/surface.h"
#include "core/trace/patch_build.h"
#include "core/trace/patch_net.h"

namespace trimray::distance {
namespace {

constexpr int kMaxCuts = 9;
// A leaf is small enough when the distance is convex for points that are beside it by this share of its size.
constexpr double kBeside = 0.25;
// Strips no wider than this fraction of the prototype's diagonal are left out.
constexpr double kNothing = 0.1 * kDistanceTol;

const dvec4* restrict(const trace::Patch& patch, const dvec4* net, const Domain& d, std::vector<dvec4>& out) {
  const int count = (patch.degree_u + 1) * (patch.degree_v + 1);
  out.assign(net, net + count);
  trace::restrict_net(out.data(), patch.degree_u, patch.degree_v, d.u0, d.u1, d.v0, d.v1);
  return out.data();
}

// Any unit vector across n.
dvec3 across(const dvec3& n) {
  const dvec3 a = glm::abs(n);
  const dvec3 axis = a.x <= a.y && a.x <= a.z ? dvec3(1, 0, 0) : a.y <= a.z ? dvec3(0, 1, 0) : dvec3(0, 0, 1);
  return glm::normalize(glm::cross(n, axis));
}

void set_frame(const dvec3& a, const dvec3& b, dvec3 (&axis)[3]) {
  const double la = glm::length(a), lb = glm::length(b);
  dvec3 n = glm::cross(a, b);
  const double ln = glm::length(n);
  if (ln > 1e-9 * la * lb && ln > 0.0) {
    axis[0] = a / la, axis[2] = n / ln, axis[1] = glm::cross(axis[2], axis[0]);
  } else {
    axis[0] = la >= lb && la > 0.0 ? a / la : lb > 0.0 ? b / lb : dvec3(1, 0, 0);
    axis[2] = across(axis[0]), axis[1] = glm::cross(axis[2], axis[0]);
  }
}

// The patch's part within the face's uv box, beyond which append_face reaches a little. Only near a patch's
// own ends: farther off its parameter means nothing.
double begin_of(const trace::ParamCurve& map, double lower) {
  return map.to_face(0.0) < lower ? std::clamp(map.from_face(lower), 0.0, 1.0) : 0.0;
}
double end_of(const trace::ParamCurve& map, double upper) {
  return map.to_face(1.0) > upper ? std::clamp(map.from_face(upper), 0.0, 1.0) : 1.0;
}

double square_outside(const SurfaceLeaf& leaf, const dvec3& q) {
  const dvec3 d = q - leaf.middle;
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double t = glm::dot(leaf.axis[k], d), out = std::max({leaf.lower[k] - t, t - leaf.upper[k], 0.0});
    sum += out * out;
  }
  return sum;
}

// A lower bound of the distance of S + offset n from the origin: seen along the way to its middle, with what
// the normal may turn.
double offset_bound(const dvec4* net, int count, const NetBound& b, double offset) {
  const dvec3 cross = glm::cross(b.middle.u, b.middle.v);
  const double area = glm::length(cross), lu = glm::length(b.middle.u), lv = glm::length(b.middle.v);
  const double turn = lu * b.turn_v + lv * b.turn_u + b.turn_u * b.turn_v;
  if (!(2.0 * turn < area)) return 0.0;
  const dvec3 normal = cross / area, middle = b.middle.p + offset * normal;
  const double size = glm::length(middle);
  if (!(size > 0.0)) return 0.0;
  const dvec3 towards = middle / size;
  const double sine = 2.0 * turn / area, along = glm::dot(towards, normal);
  const double aside = glm::length(towards - along * normal);
  const double cosine = std::max(0.0, 1.0 - sine * sine);
  const double share = offset * along;  // of the normal's own direction, at most turned by the angle
  return plane_bound(net, count, towards) + (share > 0.0 ? share * cosine : share) -
         std::abs(offset) * aside * sine;
}

}  // namespace

bool SurfaceLeaves::append(std::int32_t face, std::vector<Box3>& boxes) {
  const std::size_t first = pool_.patches.size();
  const std::int64_t refused = pool_.refused;
  constexpr trace::LeafDetail kUncut{1, kInf, 3.0};  // leaves for rays are not wanted
  trace::append_face(store_, face, 0.0, kUncut, pool_);
  pool_.leaves.clear(), pool_.bounds.clear(), pool_.splits.clear(), pool_.leaf_cells.clear();
  bool whole = pool_.refused == refused && pool_.patches.size() > first;
  const Box2& box = store_.faces[face].uv_box;
  for (std::size_t k = first; k < pool_.patches.size(); ++k) {
    const trace::Patch& patch = pool_.patches[k];
    const Domain d{begin_of(patch.u, box.lower.x), end_of(patch.u, box.upper.x),
                   begin_of(patch.v, box.lower.y), end_of(patch.v, box.upper.y)};
    rims_.push_back(d);
    if (!(d.u0 <= d.u1 && d.v0 <= d.v1)) continue;
    whole = cut(static_cast<std::int32_t>(k), d, 0, boxes) && whole;
  }
  return whole;
}

bool SurfaceLeaves::cut(std::int32_t index, const Domain& d, int depth, std::vector<Box3>& boxes) {
  const trace::Patch& patch = pool_.patches[index];
  const int du = patch.degree_u, dv = patch.degree_v, count = (du + 1) * (dv + 1);
  SurfaceLeaf leaf;
  leaf.patch = index, leaf.face = patch.face, leaf.domain = d;
  Box2 uv;
  uv.add(dvec2(patch.u.to_face(d.u0), patch.v.to_face(d.v0)));
  uv.add(dvec2(patch.u.to_face(d.u1), patch.v.to_face(d.v1)));
  if (store_.faces[patch.face].iso_rectangle) {
    leaf.inside = true;
  } else {
    const nurbs::Coverage coverage = trims_.coverage(patch.face, uv);
    if (coverage == nurbs::Coverage::kOutside) return true;
    leaf.inside = coverage == nurbs::Coverage::kInside;
  }
  std::vector<dvec4> storage;
  const dvec4* net = restrict(patch, pool_.net.data() + patch.net, d, storage);
  NetBound bound;
  if (!bound_net(net, du, dv, bound)) return false;
  // A face may reach into a knot span by rounding alone: the strip there says nothing that its neighbours, or
  // the edges, do not say.
  const double diagonal = store_.prototypes[store_.faces[patch.face].prototype].bounds.diagonal();
  if (depth == 0 && std::min(glm::length(bound.middle.u) + bound.turn_u,
                             glm::length(bound.middle.v) + bound.turn_v) <= kNothing * diagonal)
    return true;
  leaf.radius = bound.radius, leaf.middle = bound.middle.p;
  const dvec3 a = bound.middle.u, b = bound.middle.v;
  set_frame(a, b, leaf.axis);
  leaf.lower = dvec3(kInf), leaf.upper = dvec3(-kInf);
  Box3 box;
  for (int k = 0; k < count; ++k) {
    const dvec3 p = dvec3(net[k]) / net[k].w;
    box.add(p + patch.origin);
    const dvec3 t(glm::dot(leaf.axis[0], p - leaf.middle), glm::dot(leaf.axis[1], p - leaf.middle),
                  glm::dot(leaf.axis[2], p - leaf.middle));
    leaf.lower = glm::min(leaf.lower, t), leaf.upper = glm::max(leaf.upper, t);
  }
  leaf.hessian = bound_hessian(bound, leaf.axis);
  const dvec3 extent = leaf.upper - leaf.lower;
  const double beside = kBeside * std::min(extent.x, extent.y);
  const Span near[3] = {
      {-extent.x, extent.x}, {-extent.y, extent.y}, {-extent.z - beside, extent.z + beside}};
  const bool pole = !(glm::length(a) > 0.0) || !(glm::length(b) > 0.0);
  if (depth < kMaxCuts && !pole && !convex_for(leaf.hessian, near)) {
    Domain low = d, high = d;
    // A strip that tapers along its length wants to be cut across it, whichever way it bends.
    const double la = glm::length(a), lb = glm::length(b);
    const bool tapers = bound.uv >= std::max(bound.uu, bound.vv) && std::max(la, lb) > 8.0 * std::min(la, lb);
    if (tapers || bound.uu == bound.vv ? la >= lb : bound.uu > bound.vv)
      low.u1 = high.u0 = 0.5 * (d.u0 + d.u1);
    else
      low.v1 = high.v0 = 0.5 * (d.v0 + d.v1);
    const bool first = cut(index, low, depth + 1, boxes);
    return cut(index, high, depth + 1, boxes) && first;
  }
  const double rounding = 1e-14 * patch.size;
  leaf.lower -= rounding, leaf.upper += rounding;
  // Least squares for the step in parameters that makes a step in the tangent plane.
  const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b), det = aa * bb - ab * ab;
  if (det > 1e-12 * aa * bb) {
    leaf.to_u = (d.u1 - d.u0) * (bb * a - ab * b) / det;
    leaf.to_v = (d.v1 - d.v0) * (aa * b - ab * a) / det;
  }
  const dvec3 far = glm::max(glm::abs(box.lower), glm::abs(box.upper));
  box.dilate(std::abs(patch.offset) * (1.0 + 1e-12) + 4e-15 * (far.x + far.y + far.z));
  leaves_.push_back(leaf), boxes.push_back(box);
  return true;
}

bool SurfaceLeaves::inside(std::int32_t face, dvec2& uv) const {
  const nurbs::Face& f = store_.faces[face];
  uv = trims_.wrap(face, uv);
  return f.iso_rectangle ? f.uv_box.contains(uv) : trims_.inside(face, uv);
}

// Where a foot point is nearer than the best and inside of the loops, it is the best.
bool SurfaceLeaves::offer(const SurfaceLeaf& leaf, const trace::Patch& patch, const Foot& foot,
                          bool known_inside, const dvec3& q, SurfaceFoot& best) const {
  dvec3 p = foot.p;
  double distance = std::sqrt(foot.square);
  dvec2 uv(patch.u.to_face(foot.u), patch.v.to_face(foot.v));
  if (patch.offset != 0.0) {
    p = nurbs::evaluate(store_, store_.surfaces[store_.faces[leaf.face].surface], uv).p - patch.origin;
    distance = glm::distance(p, q);
  }
  if (!(distance < best.distance)) return false;
  if (known_inside)
    uv = trims_.wrap(leaf.face, uv);
  else if (!inside(leaf.face, uv))
    return false;
  best = {distance, p + patch.origin, uv};
  return true;
}

bool SurfaceLeaves::nearest(std::size_t index, const dvec3& point, double slack, SurfaceFoot& best,
                            Workspace& work) const {
  const SurfaceLeaf& leaf = leaves_[index];
  const trace::Patch& patch = pool_.patches[leaf.patch];
  const dvec3 q = point - patch.origin;
  if (patch.offset != 0.0) {
    const double low = std::sqrt(square_outside(leaf, q)), off = std::abs(patch.offset);
    const double high = glm::distance(q, leaf.middle) + leaf.radius;
    if (!(std::max(low - off, off - high) < best.distance)) return false;
    return subdivide(leaf, q, slack, best, work);
  }
  if (!(square_outside(leaf, q) < best.distance * best.distance)) return false;
  const dvec3 d = q - leaf.middle;
  Span e[3];
  for (int k = 0; k < 3; ++k) {
    const double t = glm::dot(leaf.axis[k], d);
    e[k] = {leaf.lower[k] - t, leaf.upper[k] - t};
  }
  if (!convex_for(leaf.hessian, e)) return subdivide(leaf, q, slack, best, work);
  const Domain& in = leaf.domain;
  const Foot foot =
      descend(pool_.net.data() + patch.net, patch.degree_u, patch.degree_v, in, q,
              0.5 * (in.u0 + in.u1) + glm::dot(leaf.to_u, d), 0.5 * (in.v0 + in.v1) + glm::dot(leaf.to_v, d));
  return offer(leaf, patch, foot, leaf.inside, q, best);
}

struct SurfaceLeaves::Query {
  const SurfaceLeaf& leaf;
  const trace::Patch& patch;
  dvec3 q;
  double slack;
};

// Looks at one part: drops it, settles it, or puts it on the heap. True when it found something nearer.
bool SurfaceLeaves::examine(const Query& query, const Domain& d, bool known_inside, SurfaceFoot& best,
                            Workspace& work) const {
  const trace::Patch& patch = query.patch;
  const int du = patch.degree_u, dv = patch.degree_v, count = (du + 1) * (dv + 1);
  const dvec4* whole = pool_.net.data() + patch.net;
  if (!known_inside) {
    Box2 uv;
    uv.add(dvec2(patch.u.to_face(d.u0), patch.v.to_face(d.v0)));
    uv.add(dvec2(patch.u.to_face(d.u1), patch.v.to_face(d.v1)));
    const nurbs::Coverage coverage = trims_.coverage(patch.face, uv);
    if (coverage == nurbs::Coverage::kOutside) return false;
    known_inside = coverage == nurbs::Coverage::kInside;
  }
  restrict(patch, whole, d, work.net);
  dvec4* net = work.net.data();
  for (int k = 0; k < count; ++k) net[k] -= dvec4(net[k].w * query.q, 0.0);
  NetBound& bound = work.bound;
  if (!bound_net(net, du, dv, bound)) return false;
  const double off = std::abs(patch.offset), wanted = best.distance - query.slack;
  const double size = glm::length(bound.middle.p);
  double low = std::max(0.0, size - bound.radius);
  if (size > 0.0) low = std::max(low, plane_bound(net, count, bound.middle.p / size));
  const double least =
      off > 0.0
          ? std::max({low - off, off - size - bound.radius, offset_bound(net, count, bound, patch.offset)})
          : low;
  if (!(least < wanted)) return false;
  SquareForm form;
  // Is all of it certainly too far? Of an offset, where its base is farther by the offset.
  const auto far = [&] {
    form = square_form(net, du, dv, wanted < kInf ? wanted + off : size, work.coefficients);
    return wanted < kInf && form.keeps_away;
  };
  const Shape shape = shape_of(bound, false);
  bool found = false;
  if (off == 0.0) {
    // A minimum is where nothing slopes, or on the rim of the patch, the slope against it.
    const Domain& rim = rims_[query.leaf.patch];
    if ((shape.slope_u > 0 && d.u0 > rim.u0) || (shape.slope_u < 0 && d.u1 < rim.u1) ||
        (shape.slope_v > 0 && d.v0 > rim.v0) || (shape.slope_v < 0 && d.v1 < rim.v1))
      return false;
    const bool settled = shape.convex || (shape.slope_u != 0 && (shape.slope_v != 0 || shape.convex_v)) ||
                         (shape.slope_v != 0 && shape.convex_u);
    if (!settled && far()) return false;
    const Foot foot = descend(whole, du, dv, d, query.q, 0.5 * (d.u0 + d.u1), 0.5 * (d.v0 + d.v1));
    found = offer(query.leaf, patch, foot, known_inside, query.q, best);
    if (settled) return found;
  } else {
    if (far()) return false;
    const Critical critical = critical_point(whole, du, dv, d, query.q);
    Foot foot = critical.foot;  // not beyond a pole, where the normal turns round
    foot.u = std::clamp(foot.u, d.u0, d.u1), foot.v = std::clamp(foot.v, d.v0, d.v1);
    found = offer(query.leaf, patch, foot, known_inside, query.q, best);
    // The nearest point of an offset lies over a critical point of its base, of whatever kind.
    if ((shape.regular && critical.settled) || shape.slope_u != 0 || shape.slope_v != 0) return found;
  }
  if (bound.radius <= query.slack) return found;
  // Without a difference to go by, as at a pole, the longer side.
  const bool longer_u =
      glm::length(bound.middle.u) + bound.turn_u >= glm::length(bound.middle.v) + bound.turn_v;
  const bool halve_u = form.bend_u != form.bend_v ? form.bend_u > form.bend_v : longer_u;
  push_part(work, {d, least, known_inside, halve_u});
  return found;
}

bool SurfaceLeaves::subdivide(const SurfaceLeaf& leaf, const dvec3& q, double slack, SurfaceFoot& best,
                              Workspace& work) const {
  const trace::Patch& patch = pool_.patches[leaf.patch];
  const Query query{leaf, patch, q, slack};
  const int count = (patch.degree_u + 1) * (patch.degree_v + 1), cost = 1 + count * count / 4096;
  return search_parts(
      leaf.domain, leaf.inside, cost, work, [&] { return best.distance - slack; },
      [&](const Domain& part, bool inside) { return examine(query, part, inside, best, work); });
}

std::int64_t SurfaceLeaves::bytes() const {
  return static_cast<std::int64_t>(leaves_.size() * sizeof(SurfaceLeaf) + pool_.net.size() * sizeof(dvec4) +
                                   pool_.patches.size() * sizeof(trace::Patch) +
                                   pool_.coef.size() * sizeof(double));
}

}  // namespace trimray::distance
