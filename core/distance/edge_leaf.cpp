#include "core/distance/edge_leaf.h"

#include <algorithm>
#include <cmath>

#include "core/base/closest.h"
#include "core/trace/patch_net.h"

namespace trimray::distance {
namespace {

constexpr int kMaxCuts = 10;
constexpr double kEnough = 3.0;    // as for surfaces
constexpr double kSlender = 0.05;  // a leaf's thickness over its length

}  // namespace

bool is_used(const nurbs::NurbsStore& store, const nurbs::Edge& edge) {
  for (std::int32_t i = edge.coedges.begin; i < edge.coedges.end; ++i)
    if (store.faces[store.coedges[store.edge_coedges[i]].face].status == nurbs::FaceStatus::kOk) return true;
  return false;
}

EdgeLeaves::EdgeLeaves(const nurbs::NurbsStore& store, std::int32_t prototype) : paths_(store, prototype) {
  for (std::size_t e = 0; e < paths_.edges.size(); ++e) {
    const auto index = paths_.first_edge + static_cast<std::int32_t>(e);
    if (!is_used(store, store.edges[index])) continue;
    const trace::PathEdge& edge = paths_.edges[e];
    const dvec3* joint = paths_.joints.data() + edge.joint;
    const auto link = [&](std::int32_t from, std::int32_t to, double t) {
      if (joint[from] == joint[to] && edge.piece_count > 0) return;
      leaves_.push_back({index, -1, t, t, joint[from], joint[to], 0.0, kInf});
    };
    if (edge.piece_count == 0) {
      if (edge.joint_count > 0) {
        link(0, edge.joint_count - 1, 0.0);
        leaves_.back().s1 = 1.0;
      }
      continue;
    }
    link(0, 1, paths_.pieces[edge.piece].t0);
    for (std::int32_t p = 0; p < edge.piece_count; ++p) cut(index, edge.piece + p, 0.0, 1.0, 0);
    link(edge.joint_count - 2, edge.joint_count - 1, paths_.pieces[edge.piece + edge.piece_count - 1].t1);
  }
}

void EdgeLeaves::cut(std::int32_t edge, std::int32_t index, double s0, double s1, int depth) {
  const trace::PathPiece& piece = paths_.pieces[index];
  std::vector<dvec4> net(paths_.ctrl_h.begin() + piece.ctrl,
                         paths_.ctrl_h.begin() + piece.ctrl + piece.degree + 1);
  trace::restrict_line(net.data(), piece.degree, 1, s0, s1);
  NetBound bound;
  if (!bound_net(net.data(), piece.degree, 0, bound)) return;
  const auto point = [&](std::size_t k) { return dvec3(net[k]) / net[k].w; };
  EdgeLeaf leaf{edge, index, s0, s1, point(0), point(piece.degree), 0.0, convex_radius(bound)};
  double far = 0.0;
  for (std::size_t k = 0; k < net.size(); ++k) {
    leaf.radius =
        std::max(leaf.radius, glm::distance(point(k), closest_on_segment(point(k), leaf.a, leaf.b)));
    far = std::max(far, glm::length(point(k)));
  }
  leaf.radius += 1e-14 * far;
  const bool small = leaf.convex >= kEnough * bound.radius && leaf.radius <= kSlender * bound.radius;
  if (!small && depth < kMaxCuts && glm::length(bound.middle.u) > 0.0) {
    const double middle = 0.5 * (s0 + s1);
    cut(edge, index, s0, middle, depth + 1);
    cut(edge, index, middle, s1, depth + 1);
    return;
  }
  leaves_.push_back(leaf);
}

std::vector<Box3> EdgeLeaves::boxes() const {
  std::vector<Box3> boxes(leaves_.size());
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    boxes[i].add(leaves_[i].a + paths_.middle), boxes[i].add(leaves_[i].b + paths_.middle);
    const dvec3 far = glm::max(glm::abs(boxes[i].lower), glm::abs(boxes[i].upper));
    boxes[i].dilate(leaves_[i].radius + 4e-15 * (far.x + far.y + far.z));
  }
  return boxes;
}

bool EdgeLeaves::offer(const EdgeLeaf& leaf, const Foot& foot, EdgeFoot& best) const {
  if (!(foot.square < best.distance * best.distance)) return false;
  const trace::PathPiece& piece = paths_.pieces[leaf.piece];
  best = {std::sqrt(foot.square), foot.p + paths_.middle, leaf.edge,
          piece.t0 + (piece.t1 - piece.t0) * foot.u};
  return true;
}

bool EdgeLeaves::nearest(std::size_t index, const dvec3& point, double slack, EdgeFoot& best,
                         Workspace& work) const {
  const EdgeLeaf& leaf = leaves_[index];
  const dvec3 q = point - paths_.middle;
  const dvec3 on_line = closest_on_segment(q, leaf.a, leaf.b);
  const double line = glm::distance(q, on_line);
  if (!(line - leaf.radius < best.distance)) return false;
  const double length = glm::distance(leaf.a, leaf.b),
               along = length > 0.0 ? glm::distance(leaf.a, on_line) / length : 0.0;
  if (leaf.piece < 0) {
    best = {line, on_line + paths_.middle, leaf.edge, leaf.s0 + (leaf.s1 - leaf.s0) * along};
    return true;
  }
  const trace::PathPiece& piece = paths_.pieces[leaf.piece];
  const dvec4* net = paths_.ctrl_h.data() + piece.ctrl;
  const Domain whole{leaf.s0, leaf.s1, 0.0, 0.0};
  if (line + length + 2.0 * leaf.radius < leaf.convex)
    return offer(leaf, descend(net, piece.degree, 0, whole, q, leaf.s0 + (leaf.s1 - leaf.s0) * along, 0.0),
                 best);
  return search_parts(
      whole, true, 1, work, [&] { return best.distance - slack; },
      [&](const Domain& part, bool) { return examine(leaf, part, q, slack, best, work); });
}

bool EdgeLeaves::examine(const EdgeLeaf& leaf, const Domain& d, const dvec3& q, double slack, EdgeFoot& best,
                         Workspace& work) const {
  const trace::PathPiece& piece = paths_.pieces[leaf.piece];
  const dvec4* whole = paths_.ctrl_h.data() + piece.ctrl;
  const int n = piece.degree;
  work.net.assign(whole, whole + n + 1);
  dvec4* net = work.net.data();
  trace::restrict_line(net, n, 1, d.u0, d.u1);
  for (int k = 0; k <= n; ++k) net[k] -= dvec4(net[k].w * q, 0.0);
  NetBound& bound = work.bound;
  if (!bound_net(net, n, 0, bound)) return false;
  const double size = glm::length(bound.middle.p), wanted = best.distance - slack;
  double least = std::max(0.0, size - bound.radius);
  if (size > 0.0) least = std::max(least, plane_bound(net, n + 1, bound.middle.p / size));
  if (!(least < wanted) || (wanted < kInf && square_form(net, n, 0, wanted, work.coefficients).keeps_away))
    return false;
  const bool found = offer(leaf, descend(whole, n, 0, d, q, 0.5 * (d.u0 + d.u1), 0.0), best);
  if (shape_of(bound, true).convex || bound.radius <= slack) return found;
  push_part(work, {d, least, true, true});
  return found;
}

std::int64_t EdgeLeaves::bytes() const {
  return static_cast<std::int64_t>(leaves_.size() * sizeof(EdgeLeaf) + paths_.ctrl_h.size() * sizeof(dvec4) +
                                   paths_.joints.size() * sizeof(dvec3));
}

}  // namespace trimray::distance
