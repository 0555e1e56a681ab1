#include "core/trace/scene_edges.h"

#include <algorithm>
#include <cmath>

namespace trimray::trace {
namespace {

struct Segment {
  dvec3 a{0.0}, b{0.0};
  double deviation = 0.0;  // the path keeps this close to the segment
  double band = 0.0;
};

double distance_to_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 e = b - a;
  const double ee = glm::dot(e, e);
  const double s = ee > 0.0 ? std::clamp(glm::dot(p - a, e) / ee, 0.0, 1.0) : 0.0;
  return glm::length(p - (a + s * e));
}

dvec3 project(const dvec4& h) { return dvec3(h) / h.w; }

// Cuts rational Bezier pieces until the control polygon hugs the chord.
struct Flattener {
  double chord_tol, max_length;
  double band;
  std::vector<Segment>& out;

  void piece(std::vector<dvec4> ctrl, int depth) {
    const dvec3 a = project(ctrl.front()), b = project(ctrl.back());
    double deviation = 0.0;
    for (const dvec4& c : ctrl) deviation = std::max(deviation, distance_to_segment(project(c), a, b));
    const dvec3 e = glm::abs(b - a);
    const double longest = std::max({e.x, e.y, e.z});
    const bool slanted =
        e.x + e.y + e.z > 1.1 * longest && longest > max_length;  // its box would be mostly air
    if (depth == 0 || (deviation <= chord_tol && !slanted)) {
      out.push_back({a, b, deviation, band});
      return;
    }
    // De Casteljau at the middle.
    std::vector<dvec4> right(ctrl.size());
    std::vector<dvec4> work = ctrl;
    for (std::size_t level = 0; level < ctrl.size(); ++level) {
      ctrl[level] = work[0];
      right[ctrl.size() - 1 - level] = work[ctrl.size() - 1 - level];
      for (std::size_t i = 0; i + 1 < ctrl.size() - level; ++i) work[i] = 0.5 * (work[i] + work[i + 1]);
    }
    piece(std::move(ctrl), depth - 1);
    piece(std::move(right), depth - 1);
  }
};

}  // namespace

EdgeSieve::EdgeSieve(const nurbs::NurbsStore& store, std::int32_t prototype, double chord_tolerance) {
  const nurbs::Prototype& p = store.prototypes[prototype];
  const double size = p.bounds.empty() ? 1.0 : p.bounds.diagonal();
  chord_tolerance_ = chord_tolerance * size;
  std::vector<Segment> segments;
  for (std::int32_t index = p.edges.begin; index < p.edges.end; ++index) {
    const nurbs::Edge& edge = store.edges[index];
    if (edge.coedges.size() == 0) continue;
    max_slack_ = std::max(max_slack_, slack(edge));
    Flattener flattener{std::max(edge.band, chord_tolerance_), size / 24.0, edge.band, segments};
    const auto vertex = [&](int end) { return store.vertices[edge.vertex[end]].point; };
    dvec3 last = edge.vertex[0] >= 0 ? vertex(0) : dvec3(kNaN);
    const auto link = [&](const dvec3& next) {
      if (!std::isnan(last.x)) segments.push_back({last, next, 0.0, edge.band});
      last = next;
    };
    for (std::int32_t i = edge.pieces.begin; i < edge.pieces.end; ++i) {
      const nurbs::Range& r = store.edge_pieces[i].ctrl;
      if (r.size() == 0) continue;
      const dvec3 start = project(store.edge_ctrl_h[r.begin]);
      if (last != start) link(start);
      flattener.piece({store.edge_ctrl_h.begin() + r.begin, store.edge_ctrl_h.begin() + r.end}, 12);
      last = project(store.edge_ctrl_h[r.end - 1]);
    }
    if (edge.vertex[1] >= 0 && (last != vertex(1) || edge.pieces.size() == 0)) link(vertex(1));
  }

  // A ray seen in float may be off by the slack; along the ray, t matters up to slack(edge) away.
  std::vector<Box3> boxes;
  double radius = 0.0;
  for (const Segment& s : segments) {
    Box3 box;
    box.add(s.a), box.add(s.b);
    box.dilate(s.deviation + 4.0 * s.band);
    boxes.push_back(box);
    box_.add(box);
  }
  radius = 0.5 * box_.diagonal();
  for (Box3& box : boxes) box.dilate(2.0 * kCapsuleSlack * radius);
  if (!boxes.empty()) box_.dilate(2.0 * kCapsuleSlack * radius);
  bvh_ = build_bvh(boxes);
  for (const std::int32_t index : renumber_primitives(bvh_)) {
    const Segment& s = segments[index];
    Capsule c;
    for (int axis = 0; axis < 3; ++axis) {
      c.a[axis] = static_cast<float>(s.a[axis] - bvh_.center[axis]);
      c.b[axis] = static_cast<float>(s.b[axis] - bvh_.center[axis]);
    }
    c.radius = static_cast<float>((s.deviation + s.band) * (1.0 + 1e-6) + kCapsuleSlack * bvh_.radius);
    capsules_.push_back(c);
  }
}

std::uint64_t EdgeSieve::near(RayPacket& packet, std::uint64_t* nodes) const {
  struct Context {
    const EdgeSieve& sieve;
    RayPacket& packet;
    std::uint64_t near;
  } context{*this, packet, 0};
  traverse(
      bvh_, packet,
      [](void* p, std::int32_t capsule, std::uint64_t rays) {
        auto& c = *static_cast<Context*>(p);
        const std::uint64_t near = near_capsule(c.packet, c.sieve.capsules_[capsule], rays);
        c.near |= near;
        c.packet.live &= ~near;
      },
      &context, nodes);
  packet.live = 0;
  return context.near;
}

}  // namespace trimray::trace
