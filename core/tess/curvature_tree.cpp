#include "core/tess/curvature_tree.h"

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
  static constexpr double kGridShare = 1.05;
  static constexpr int kMaxDepth = 24;
  static constexpr int kMaxCells = 4096;  // of a leaf, in one direction

  // The jump of the first derivative over the knot line between two patches, along u or v.
  Box3 kink(int first, int second, bool along_u) const {
    const int p = patches.degree_u, q = patches.degree_v, row = q + 1;
    const dvec4* a = patches.ctrl_h.data() + std::size_t(first) * patches.points();
    const dvec4* b = patches.ctrl_h.data() + std::size_t(second) * patches.points();
    const double da = along_u ? patches.uv_face[first].extent().x : patches.uv_face[first].extent().y;
    const double db = along_u ? patches.uv_face[second].extent().x : patches.uv_face[second].extent().y;
    const int degree = along_u ? p : q, lines = along_u ? q + 1 : p + 1, step = along_u ? row : 1,
              line_step = along_u ? 1 : row;
    Box3 jump;
    double speed = 0.0;
    for (int l = 0; l < lines; ++l) {
      const dvec4 at = b[l * line_step], before = a[(degree - 1) * step + l * line_step],
                  after = b[step + l * line_step];
      const dvec3 origin = dvec3(at.x, at.y, at.z) / at.w;
      const auto relative = [&](const dvec4& h) { return (dvec3(h.x, h.y, h.z) - h.w * origin) / at.w; };
      const dvec3 out = double(degree) / db * relative(after), in = double(degree) / da * -relative(before);
      jump.add(out - in);
      speed = std::max(speed, std::max(glm::length(out), glm::length(in)));
    }
    // Weights at the line vary: the hull holds up to their ratio; kinks are rare, so no more care is taken.
    if (largest(jump) <= 1e-9 * speed) return {};
    return rational ? Interval{0.5, 2.0} * jump : jump;
  }

  void kinks(int u0, int u1, int v0, int v1, bool along_u, int at, CurvatureRange& r) const {
    const int begin = along_u ? v0 : u0, end = along_u ? v1 : u1;
    Box3 all;
    for (int k = begin; k < end; ++k) {
      const int first = along_u ? (at - 1) * patches.spans_v + k : k * patches.spans_v + at - 1;
      const int second = along_u ? at * patches.spans_v + k : k * patches.spans_v + at;
      all.add(kink(first, second, along_u));
    }
    if (all.empty()) return;
    (along_u ? r.kink_u : r.kink_v).add(all);
    ++(along_u ? r.kinks_u : r.kinks_v);
  }

  int add(const Box2& box) {
    tree.nodes_.push_back({box, {}, {-1, -1}});
    return static_cast<int>(tree.nodes_.size()) - 1;
  }

  // Patches [u0, u1) x [v0, v1).
  int patch_nodes(int u0, int u1, int v0, int v1) {
    const int first = u0 * patches.spans_v + v0;
    const int node =
        add({patches.uv_face[first].lower, patches.uv_face[(u1 - 1) * patches.spans_v + v1 - 1].upper});
    if (u1 - u0 == 1 && v1 - v0 == 1) {
      tree.nodes_[node].patch = first;
      tree.nodes_[node].range.second = range_of(tree.nodes_[node].box, net_of(first));
      return node;
    }
    const bool along_u = u1 - u0 >= v1 - v0;
    const int middle = along_u ? (u0 + u1) / 2 : (v0 + v1) / 2;
    const int a = along_u ? patch_nodes(u0, middle, v0, v1) : patch_nodes(u0, u1, v0, middle);
    const int b = along_u ? patch_nodes(middle, u1, v0, v1) : patch_nodes(u0, u1, middle, v1);
    join(node, a, b);
    kinks(u0, u1, v0, v1, along_u, middle, tree.nodes_[node].range);
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
    CurvatureRange both = tree.nodes_[a].range;
    both.add(tree.nodes_[b].range);
    tree.nodes_[node].range = both;
    tree.nodes_[node].child[0] = a, tree.nodes_[node].child[1] = b;
  }

  // A regular grid over the node where its bounds are tight enough, or else over its halves. net: of the
  // node, which is a part of one patch; empty for closed forms.
  void choose(int node, std::vector<dvec4> net, int depth) {
    const Box2 box = tree.nodes_[node].box;
    const dvec2 e = box.extent();
    const CurvatureRange& range = tree.nodes_[node].range;
    const DerivativeRange second = range.second;
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
    if (range.kinks_u > 0) a += 2.0 * range.kinks_u * along(n, range.kink_u).magnitude() * e.x;
    if (range.kinks_v > 0) c += 2.0 * range.kinks_v * along(n, range.kink_v).magnitude() * e.y;
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
    if (cells > 1.0 && !(loose <= share * total) && depth < kMaxDepth) {
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
    tree.nodes_[a].range.second = range_of(lower, lower_net);
    tree.nodes_[b].range.second = range_of(upper, upper_net);
    join(node, a, b);
    choose(a, std::move(lower_net), depth + 1);
    choose(b, std::move(upper_net), depth + 1);
  }

  // The fewest cells with a / ku^2 + 2 b / (ku kv) + c / kv^2 <= limit.
  void choose_counts(double a, double b, double c, double limit, double turn_u, double turn_v,
                     GridLeaf& leaf) const {
    const auto count = [](double x) {
      return std::clamp(static_cast<int>(std::ceil(std::min(x, double(kMaxCells)) - 1e-9)), 1, kMaxCells);
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
    nodes_[root].range.second = closed_form_range(surface_, box);
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
    out.add(node.range);
    return;
  }
  if (node.child[0] < 0) {
    out.second.add(sharp ? part_of_leaf(node, box) : node.range.second);
    return;
  }
  // Outside of the root the nearest leaves' polynomials go on.
  const Box2& a = nodes_[node.child[0]].box;
  const int d = nodes_[node.child[1]].box.lower.x > a.lower.x ? 0 : 1;
  const bool lower = box.lower[d]<a.upper[d], upper = box.upper[d]> a.upper[d];
  if (lower || !upper) gather(node.child[0], box, sharp, out);
  if (upper) gather(node.child[1], box, sharp, out);
  if (lower && upper) {
    // A kink on this very line; those inside the halves came with them.
    if (node.range.kinks_u + node.range.kinks_v == 0) return;
    const Node &x = nodes_[node.child[0]], &y = nodes_[node.child[1]];
    const int own_u = node.range.kinks_u - x.range.kinks_u - y.range.kinks_u;
    const int own_v = node.range.kinks_v - x.range.kinks_v - y.range.kinks_v;
    if (own_u > 0) out.kink_u.add(node.range.kink_u), out.kinks_u += own_u;
    if (own_v > 0) out.kink_v.add(node.range.kink_v), out.kinks_v += own_v;
  }
}

// Sharper than the leaf's own range, since a triangle is mostly smaller.
DerivativeRange CurvatureTree::part_of_leaf(const Node& leaf, const Box2& box) const {
  const Box2 part{glm::max(box.lower, leaf.box.lower), glm::min(box.upper, leaf.box.upper)};
  const dvec2 e = part.extent(), whole = leaf.box.extent();
  constexpr double kMostly = 0.7;
  if (!(e.x > 0.0 && e.y > 0.0) || (e.x > kMostly * whole.x && e.y > kMostly * whole.y))
    return leaf.range.second;
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
