#include "core/tess/curvature_tree.h"

#include <algorithm>
#include <cmath>

namespace trimray::tess {

namespace {

// Halves a Bezier net at 1/2 along u or v (de Casteljau); both halves have the net's layout.
void halve_net(const std::vector<dvec4>& net, int p, int q, bool along_u, std::vector<dvec4>& lower,
               std::vector<dvec4>& upper) {
  lower.resize(net.size()), upper = net;
  const int row = q + 1, degree = along_u ? p : q, lines = along_u ? q + 1 : p + 1;
  const int step = along_u ? row : 1, line_step = along_u ? 1 : row;
  for (int l = 0; l < lines; ++l) {
    dvec4* c = upper.data() + l * line_step;
    dvec4* out = lower.data() + l * line_step;
    for (int k = 0; k <= degree; ++k) {
      out[k * step] = c[0];
      for (int i = 0; i + k < degree; ++i) c[i * step] = 0.5 * (c[i * step] + c[(i + 1) * step]);
    }
  }
}

// One line of a Bezier net over [t0, t1].
void restrict_line(dvec4* c, int degree, int step, double t0, double t1) {
  if (t1 < 1.0)
    for (int r = 1; r <= degree; ++r)
      for (int i = degree; i >= r; --i) c[i * step] = (1.0 - t1) * c[(i - 1) * step] + t1 * c[i * step];
  if (t0 > 0.0) {
    const double s = t0 / t1;
    for (int r = 1; r <= degree; ++r)
      for (int i = 0; i + r <= degree; ++i) c[i * step] = (1.0 - s) * c[i * step] + s * c[(i + 1) * step];
  }
}

void restrict_net(std::vector<dvec4>& net, int p, int q, dvec2 lower, dvec2 upper) {
  for (int i = 0; i <= p; ++i) restrict_line(net.data() + i * (q + 1), q, 1, lower.y, upper.y);
  for (int j = 0; j <= q; ++j) restrict_line(net.data() + j, p, q + 1, lower.x, upper.x);
}

// Surfaces are often called rational though all their weights are one.
bool weights_vary(const std::vector<dvec4>& ctrl_h) {
  for (const dvec4& h : ctrl_h)
    if (std::abs(h.w - ctrl_h.front().w) > 1e-14 * std::abs(ctrl_h.front().w)) return true;
  return false;
}

Box3 net_box(const std::vector<dvec4>& net) {
  Box3 box;
  for (const dvec4& h : net) box.add(dvec3(h.x, h.y, h.z) / h.w);
  return box;
}

}  // namespace

struct CurvatureTree::Builder {
  CurvatureTree& tree;
  const Chart& chart;
  const ToleranceField& tolerance;
  double angle;
  const nurbs::BezierPatches& patches;
  bool rational = false;

  // Inner points stand in staggered rows, whose triangles are nearly equilateral: these deviate by three
  // quarters of what half a cell would.
  static constexpr double kGridShare = 1.8;
  static constexpr int kMaxDepth = 24;
  static constexpr double kManyCells = 16.0;  // of a leaf over which the tolerance may vary
  static constexpr int kMaxCells = 4096;      // of a leaf, in one direction

  // The jump of the first derivative over the knot line between two patches, along u or v.
  Box3 kink(int first, int second, bool along_u) const {
    const int p = patches.degree_u, q = patches.degree_v, row = q + 1;
    const dvec4* a = patches.ctrl_h.data() + std::size_t(first) * patches.points();
    const dvec4* b = patches.ctrl_h.data() + std::size_t(second) * patches.points();
    const int d = along_u ? 0 : 1, degree = along_u ? p : q, lines = along_u ? q + 1 : p + 1;
    const int step = along_u ? row : 1, line_step = along_u ? 1 : row;
    const double ka = degree / patches.uv_face[first].extent()[d],
                 kb = degree / patches.uv_face[second].extent()[d];
    Box3 jump, places;
    double speed = 0.0;
    Interval weights{kInf, -kInf};
    for (int l = 0; l < lines; ++l) {
      const dvec4 at = b[l * line_step], before = a[(degree - 1) * step + l * line_step],
                  after = b[step + l * line_step];
      const dvec3 place = dvec3(at.x, at.y, at.z) / at.w;
      const auto relative = [&](const dvec4& h) { return (dvec3(h.x, h.y, h.z) - h.w * place) / at.w; };
      const dvec3 out = kb * relative(after), in = ka * -relative(before);
      jump.add(out - in), places.add(place);
      speed = std::max(speed, std::max(glm::length(out), glm::length(in)));
      const double w = kb * (after.w / at.w - 1.0) + ka * (before.w / at.w - 1.0);
      weights = {std::min(weights.lo, w), std::max(weights.hi, w)};
    }
    // The jump is the weighted mean of the points' own, if the weights' slopes jump alike all along the line.
    if (weights.hi - weights.lo > 1e-9 * (ka + kb))
      jump.dilate((weights.hi - weights.lo) * places.diagonal());
    return largest(jump) <= 1e-9 * speed ? Box3{} : jump;
  }

  void kinks(int u0, int u1, int v0, int v1, bool along_u, int at, Node& node) const {
    const int begin = along_u ? v0 : u0, end = along_u ? v1 : u1;
    for (int k = begin; k < end; ++k) {
      const int first = along_u ? (at - 1) * patches.spans_v + k : k * patches.spans_v + at - 1;
      const int second = along_u ? at * patches.spans_v + k : k * patches.spans_v + at;
      node.own.add(kink(first, second, along_u));
    }
    node.kinked = !node.own.empty();
    if (!node.kinked) return;
    const int d = along_u ? 0 : 1;
    node.jump[d].add(node.own), ++node.kinks[d];
    const Box2& box = patches.uv_face[along_u ? at * patches.spans_v + v0 : u0 * patches.spans_v + at];
    tree.kinks_[d].push_back(box.lower[d]);
  }

  int add(const Box2& box) {
    tree.nodes_.emplace_back().box = box;
    return static_cast<int>(tree.nodes_.size()) - 1;
  }

  // Patches [u0, u1) x [v0, v1).
  int patch_nodes(int u0, int u1, int v0, int v1) {
    const int first = u0 * patches.spans_v + v0;
    const int node =
        add({patches.uv_face[first].lower, patches.uv_face[(u1 - 1) * patches.spans_v + v1 - 1].upper});
    if (u1 - u0 == 1 && v1 - v0 == 1) {
      tree.nodes_[node].patch = first;
      tree.nodes_[node].second = range_of(tree.nodes_[node].box, net_of(first));
      return node;
    }
    const bool along_u = u1 - u0 >= v1 - v0;
    const int middle = along_u ? (u0 + u1) / 2 : (v0 + v1) / 2;
    const int a = along_u ? patch_nodes(u0, middle, v0, v1) : patch_nodes(u0, u1, v0, middle);
    const int b = along_u ? patch_nodes(middle, u1, v0, v1) : patch_nodes(u0, u1, middle, v1);
    join(node, a, b);
    kinks(u0, u1, v0, v1, along_u, middle, tree.nodes_[node]);
    return node;
  }

  std::vector<dvec4> net_of(int patch) const {
    const dvec4* begin = patches.ctrl_h.data() + std::size_t(patch) * patches.points();
    return {begin, begin + patches.points()};
  }

  DerivativeRange range_of(const Box2& box, const std::vector<dvec4>& net) const {
    return net.empty() ? closed_form_range(chart.surface(), box)
                       : patch_range(net.data(), patches.degree_u, patches.degree_v, box.extent(), rational);
  }

  void join(int node, int a, int b) {
    Node& both = tree.nodes_[node];
    both.second = {};
    for (const int child : {a, b}) {
      const Node& n = tree.nodes_[child];
      both.second.add(n.second);
      for (const int d : {0, 1}) both.jump[d].add(n.jump[d]), both.kinks[d] += n.kinks[d];
    }
    both.child[0] = a, both.child[1] = b;
  }

  // Is the tolerance that holds all over the node much smaller than what some part of it needs?
  bool varies(const Box2& box, const Box3& place) const {
    const double least = tolerance.at(place);
    for (const dvec2 at : {dvec2(0.5, 0.5), dvec2(0, 0), dvec2(1, 0), dvec2(0, 1), dvec2(1, 1)}) {
      Box3 point;
      point.add(chart.point(box.lower + at * box.extent()));
      if (tolerance.at(point) > 2.0 * least) return true;
    }
    return false;
  }

  // A regular grid over the node where its bounds are tight enough, or else over its halves. net: of the
  // node, which is a part of one patch; empty for closed forms.
  void choose(int node, std::vector<dvec4> net, int depth) {
    const Box2 box = tree.nodes_[node].box;
    const dvec2 e = box.extent();
    const Node& here = tree.nodes_[node];
    const DerivativeRange second = here.second;
    const nurbs::SurfacePoint middle = chart.at(box.center());
    const dvec3 cross = glm::cross(middle.du, middle.dv);
    const double length = glm::length(cross);
    const dvec3 n = length > 0.0 ? cross / length : dvec3(0.0);
    const auto size = [&](const Box3& b, double scale, double& loose) {
      const double half = scale * glm::dot(glm::abs(n), 0.5 * b.extent());
      loose += half;
      return length > 0.0 ? scale * std::abs(glm::dot(n, b.center())) + half : scale * largest(b);
    };
    double loose_u = 0.0, loose_v = 0.0, loose_uv = 0.0;
    double a = size(second.uu, e.x * e.x, loose_u), c = size(second.vv, e.y * e.y, loose_v);
    const double b = size(second.uv, e.x * e.y, loose_uv);
    if (here.kinks[0] > 0) a += 2.0 * here.kinks[0] * along(n, here.jump[0]).magnitude() * e.x;
    if (here.kinks[1] > 0) c += 2.0 * here.kinks[1] * along(n, here.jump[1]).magnitude() * e.y;
    Box3 place;
    place.add(middle.p);
    if (net.empty())
      place.dilate(0.5 * (second.su * e.x + second.sv * e.y));
    else
      place = net_box(net);
    const double limit = 8.0 * kGridShare * tolerance.at(place);
    GridLeaf leaf{box, 1, 1};
    const double total = a + 2.0 * b + c, loose = loose_u + 2.0 * loose_uv + loose_v;
    const double turn_u = second.su > 0.0 ? a / (second.su * e.x) : 0.0,
                 turn_v = second.sv > 0.0 ? c / (second.sv * e.y) : 0.0;
    if (!(total <= limit) || turn_u > angle || turn_v > angle)
      choose_counts(a, b, c, limit, turn_u, turn_v, leaf);
    const double cells = double(leaf.count_u) * leaf.count_v;
    const double share = cells > 64 ? 0.1 : cells > 8 ? 0.2 : cells > 2 ? 0.35 : 0.5;
    const bool rough = cells > 1.0 && !(loose <= share * total);
    if (depth < kMaxDepth && (rough || (cells > kManyCells && varies(box, place)))) {
      const bool several = tree.nodes_[node].child[0] >= 0;
      if (several) {
        for (const int k : {0, 1}) {
          const int child = tree.nodes_[node].child[k], patch = tree.nodes_[child].patch;
          choose(child, patch >= 0 ? net_of(patch) : std::vector<dvec4>(), depth);
        }
      } else {
        halve(node, a >= c, net, depth);
      }
      return;
    }
    tree.leaves_.push_back(leaf);
  }

  void halve(int node, bool along_u, const std::vector<dvec4>& net, int depth) {
    Box2 lower = tree.nodes_[node].box, upper = lower;
    const int d = along_u ? 0 : 1, patch = tree.nodes_[node].patch;
    lower.upper[d] = upper.lower[d] = 0.5 * (lower.lower[d] + lower.upper[d]);
    std::vector<dvec4> lower_net, upper_net;
    if (!net.empty()) halve_net(net, patches.degree_u, patches.degree_v, along_u, lower_net, upper_net);
    const int a = add(lower), b = add(upper);
    tree.nodes_[a].patch = tree.nodes_[b].patch = patch;
    tree.nodes_[a].second = range_of(lower, lower_net);
    tree.nodes_[b].second = range_of(upper, upper_net);
    join(node, a, b);
    choose(a, std::move(lower_net), depth + 1);
    choose(b, std::move(upper_net), depth + 1);
  }

  // The fewest cells with a / ku^2 + 2 b / (ku kv) + c / kv^2 <= limit.
  void choose_counts(double a, double b, double c, double limit, double turn_u, double turn_v,
                     GridLeaf& leaf) const {
    const auto count = [](double x) {
      if (!(x > 1.0)) return 1;
      return static_cast<int>(std::ceil(std::min(x, double(kMaxCells)) - 1e-9));
    };
    int least_u = 1, least_v = 1;
    if (angle < kInf) least_u = count(turn_u / angle), least_v = count(turn_v / angle);
    const double root_a = std::sqrt(a), root_c = std::sqrt(c);
    // Where one direction is flat it needs no lines of its own; what the mixed term costs goes to both.
    double ku, kv;
    if (root_c < 0.05 * root_a + 1e-300 && b * b < 0.01 * a * limit)
      ku = std::sqrt(a / limit) * 1.1, kv = 1.0;
    else if (root_a < 0.05 * root_c && b * b < 0.01 * c * limit)
      kv = std::sqrt(c / limit) * 1.1, ku = 1.0;
    else {
      const double lean = std::max(root_a, 1e-3 * root_c), upright = std::max(root_c, 1e-3 * root_a);
      const double s =
          std::sqrt((a / (lean * lean) + 2.0 * b / (lean * upright) + c / (upright * upright)) / limit);
      ku = lean * s, kv = upright * s;
    }
    leaf.count_u = std::max(least_u, count(ku)), leaf.count_v = std::max(least_v, count(kv));
    // Rounding up one direction may let the other have fewer.
    const auto holds = [&](double x, double y) {
      return a / (x * x) + 2.0 * b / (x * y) + c / (y * y) <= limit;
    };
    while (leaf.count_v > least_v && holds(leaf.count_u, leaf.count_v - 1)) --leaf.count_v;
    while (leaf.count_u > least_u && holds(leaf.count_u - 1, leaf.count_v)) --leaf.count_u;
  }
};

CurvatureTree::CurvatureTree(const nurbs::NurbsStore& store, const Chart& chart, const Box2& box,
                             const ToleranceField& tolerance, double angle)
    : surface_(chart.surface()) {
  Builder b{*this, chart, tolerance, angle, patches_};
  if (chart.closed_form()) {
    const int root = b.add(box);
    nodes_[root].second = closed_form_range(surface_, box);
    b.choose(root, {}, 0);
    return;
  }
  patches_ = nurbs::bezier_patches(store, surface_);
  b.rational = rational_ = weights_vary(patches_.ctrl_h);
  if (!rational_)
    for (dvec4& h : patches_.ctrl_h) h /= h.w;
  // The patches that the face touches.
  const nurbs::BezierPatches& p = patches_;
  int u0 = 0, u1 = p.spans_u, v0 = 0, v1 = p.spans_v;
  while (u0 + 1 < u1 && p.uv_face[u0 * p.spans_v].upper.x <= box.lower.x) ++u0;
  while (u1 - 1 > u0 && p.uv_face[(u1 - 1) * p.spans_v].lower.x >= box.upper.x) --u1;
  while (v0 + 1 < v1 && p.uv_face[v0].upper.y <= box.lower.y) ++v0;
  while (v1 - 1 > v0 && p.uv_face[v1 - 1].lower.y >= box.upper.y) --v1;
  const int root = b.patch_nodes(u0, u1, v0, v1);
  for (auto& lines : kinks_)
    std::sort(lines.begin(), lines.end()), lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  b.choose(root, nodes_[root].patch >= 0 ? b.net_of(nodes_[root].patch) : std::vector<dvec4>(), 0);
}

CurvatureRange CurvatureTree::over(const Box2& box, bool sharp) const {
  CurvatureRange r;
  gather(0, box, sharp, r);
  return r;
}

void CurvatureTree::gather(int index, const Box2& box, bool sharp, CurvatureRange& out) const {
  const Node& node = nodes_[index];
  const bool covered = glm::all(glm::lessThanEqual(box.lower, node.box.lower)) &&
                       glm::all(glm::lessThanEqual(node.box.upper, box.upper));
  if (covered) {
    out.second.add(node.second);
    for (const int d : {0, 1})
      if (node.kinks[d] > 0) out.kink.add(0.5 * box.extent()[d] * node.jump[d]), out.kinks += node.kinks[d];
    return;
  }
  if (node.child[0] < 0) {
    out.second.add(sharp ? part_of_leaf(node, box) : node.second);
    return;
  }
  // Outside of the root the nearest leaves' polynomials go on.
  const Box2& a = nodes_[node.child[0]].box;
  const int d = nodes_[node.child[1]].box.lower.x > a.lower.x ? 0 : 1;
  const bool lower = box.lower[d]<a.upper[d], upper = box.upper[d]> a.upper[d];
  if (lower || !upper) gather(node.child[0], box, sharp, out);
  if (upper) gather(node.child[1], box, sharp, out);
  // A kink on this very line; those inside the halves came with them.
  if (!lower || !upper || !node.kinked) return;
  const double x = a.upper[d];
  out.kink.add(std::min(x - box.lower[d], box.upper[d] - x) * node.own), ++out.kinks;
}

double CurvatureTree::kink_between(int d, double a, double b) const {
  double best = kNaN;
  for (const double x : kinks_[d])
    if (x > std::min(a, b) && x < std::max(a, b) &&
        !(std::abs(x - 0.5 * (a + b)) >= std::abs(best - 0.5 * (a + b))))
      best = x;
  return best;
}

// Sharper than the leaf's own range, since a triangle is mostly smaller.
DerivativeRange CurvatureTree::part_of_leaf(const Node& leaf, const Box2& box) const {
  Box2 part{glm::max(box.lower, leaf.box.lower), glm::min(box.upper, leaf.box.upper)};
  const dvec2 whole = leaf.box.extent();
  // Differences over the smallest parts would be rounding alone; parts outside of the leaf are at its border.
  constexpr double kLeast = 1e-3, kMostly = 0.7;
  for (const int d : {0, 1}) {
    const double least = kLeast * whole[d];
    part.lower[d] = std::clamp(std::min(part.lower[d], part.upper[d] - least), leaf.box.lower[d],
                               leaf.box.upper[d] - least);
    part.upper[d] = std::clamp(part.upper[d], part.lower[d] + least, leaf.box.upper[d]);
  }
  const dvec2 e = part.extent();
  if (e.x > kMostly * whole.x && e.y > kMostly * whole.y) return leaf.second;
  if (leaf.patch < 0) return closed_form_range(surface_, part);
  const Box2& patch = patches_.uv_face[leaf.patch];
  thread_local std::vector<dvec4> net;
  const dvec4* begin = patches_.ctrl_h.data() + std::size_t(leaf.patch) * patches_.points();
  net.assign(begin, begin + patches_.points());
  restrict_net(net, patches_.degree_u, patches_.degree_v, (part.lower - patch.lower) / patch.extent(),
               (part.upper - patch.lower) / patch.extent());
  return patch_range(net.data(), patches_.degree_u, patches_.degree_v, e, rational_);
}

}  // namespace trimray::tess
