#include "core/trace/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace trimray::trace {
namespace {

constexpr int kBins = 16;
constexpr int kBalancedDepth = 36;  // deeper, ranges are halved by count: at most 27 more levels

struct FloatBox {
  glm::vec3 lower{std::numeric_limits<float>::infinity()}, upper{-std::numeric_limits<float>::infinity()};
  void add(const FloatBox& b) { lower = glm::min(lower, b.lower), upper = glm::max(upper, b.upper); }
  glm::vec3 twice_center() const { return lower + upper; }
  float area() const {
    const glm::vec3 e = glm::max(upper - lower, glm::vec3(0.0f));
    return e.x * e.y + e.y * e.z + e.z * e.x;
  }
};

float round_down(double x) {
  const float f = static_cast<float>(x);
  return f > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float round_up(double x) { return -round_down(-x); }

// Nodes of the binary tree; the wide tree is read off it.
struct BinaryNode {
  FloatBox box;
  std::int32_t left = -1, right = -1;  // node, or ~primitive
};

struct Builder {
  std::vector<FloatBox> boxes;
  std::vector<std::int32_t> order;
  std::vector<BinaryNode> nodes;

  // Splits order[begin, end) in two by the cheapest of kBins - 1 planes on each axis; returns the middle.
  std::int32_t split(std::int32_t begin, std::int32_t end, int depth) {
    FloatBox centers;
    for (std::int32_t i = begin; i < end; ++i) {
      const glm::vec3 c = boxes[order[i]].twice_center();
      centers.add({c, c});
    }
    const glm::vec3 extent = centers.upper - centers.lower;
    const std::int32_t half = begin + (end - begin) / 2;
    const int widest = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    if (depth >= kBalancedDepth || end - begin == 2 || !(extent[widest] > 0.0f))
      return by_median(begin, half, end, widest);
    float best_cost = std::numeric_limits<float>::infinity();
    int best_axis = widest, best_bin = -1;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(extent[axis] > 0.0f)) continue;
      const auto [cost, bin] = cheapest_plane(begin, end, axis, centers.lower[axis], kBins / extent[axis]);
      if (cost < best_cost) best_cost = cost, best_axis = axis, best_bin = bin;
    }
    if (best_bin < 0) return by_median(begin, half, end, widest);
    const float origin = centers.lower[best_axis], scale = kBins / extent[best_axis];
    const auto middle = std::stable_partition(
        order.begin() + begin, order.begin() + end,
        [&](std::int32_t i) { return bin_of(boxes[i].twice_center()[best_axis], origin, scale) < best_bin; });
    const auto m = static_cast<std::int32_t>(middle - order.begin());
    return m == begin || m == end ? by_median(begin, half, end, widest) : m;
  }

  static int bin_of(float center, float origin, float scale) {
    return std::min(kBins - 1, static_cast<int>((center - origin) * scale));
  }

  std::pair<float, int> cheapest_plane(std::int32_t begin, std::int32_t end, int axis, float origin,
                                       float scale) const {
    std::array<FloatBox, kBins> bins;
    std::array<std::int32_t, kBins> counts{};
    for (std::int32_t i = begin; i < end; ++i) {
      const FloatBox& box = boxes[order[i]];
      const int bin = bin_of(box.twice_center()[axis], origin, scale);
      bins[bin].add(box);
      ++counts[bin];
    }
    std::array<float, kBins> right_cost{};
    FloatBox box;
    std::int32_t count = 0;
    for (int b = kBins - 1; b > 0; --b) {
      box.add(bins[b]), count += counts[b];
      right_cost[b] =
          count == 0 ? std::numeric_limits<float>::infinity() : box.area() * static_cast<float>(count);
    }
    box = {}, count = 0;
    std::pair<float, int> best{std::numeric_limits<float>::infinity(), -1};
    for (int b = 1; b < kBins; ++b) {
      box.add(bins[b - 1]), count += counts[b - 1];
      if (count == 0) continue;
      const float cost = box.area() * static_cast<float>(count) + right_cost[b];
      if (cost < best.first) best = {cost, b};
    }
    return best;
  }

  std::int32_t by_median(std::int32_t begin, std::int32_t half, std::int32_t end, int axis) {
    std::stable_sort(order.begin() + begin, order.begin() + end, [&](std::int32_t a, std::int32_t b) {
      return boxes[a].twice_center()[axis] < boxes[b].twice_center()[axis];
    });
    return half;
  }

  std::int32_t build(std::int32_t begin, std::int32_t end, int depth) {
    if (end - begin == 1) return ~order[begin];
    const auto index = static_cast<std::int32_t>(nodes.size());
    nodes.emplace_back();
    FloatBox box;
    for (std::int32_t i = begin; i < end; ++i) box.add(boxes[order[i]]);
    const std::int32_t middle = split(begin, end, depth);
    const std::int32_t left = build(begin, middle, depth + 1), right = build(middle, end, depth + 1);
    nodes[index] = {box, left, right};
    return index;
  }

  const FloatBox& box_of(std::int32_t child) const { return child < 0 ? boxes[~child] : nodes[child].box; }

  // Opens the largest binary children until the wide node is full.
  std::int32_t widen(std::int32_t binary, std::vector<BvhNode>& out) const {
    std::int32_t children[kBvhWidth] = {nodes[binary].left, nodes[binary].right};
    int count = 2;
    while (count < kBvhWidth) {
      int largest = -1;
      for (int i = 0; i < count; ++i)
        if (children[i] >= 0 &&
            (largest < 0 || box_of(children[i]).area() > box_of(children[largest]).area()))
          largest = i;
      if (largest < 0) break;
      const std::int32_t opened = children[largest];
      children[largest] = nodes[opened].left;
      children[count++] = nodes[opened].right;
    }
    const auto index = static_cast<std::int32_t>(out.size());
    out.emplace_back();
    fill(out[index], children, count);
    for (int i = 0; i < count; ++i) {
      const std::int32_t child = children[i] < 0 ? children[i] : widen(children[i], out);
      out[index].child[i] = child;
    }
    return index;
  }

  void fill(BvhNode& node, const std::int32_t* children, int count) const {
    node.count = count;
    for (int i = 0; i < kBvhWidth; ++i) {
      const FloatBox box = i < count ? box_of(children[i]) : FloatBox{};
      for (int axis = 0; axis < 3; ++axis)
        node.lower[axis][i] = box.lower[axis], node.upper[axis][i] = box.upper[axis];
      node.child[i] = i < count ? children[i] : 0;
    }
  }
};

}  // namespace

Bvh build_bvh(std::span<const Box3> boxes) {
  Bvh bvh;
  Box3 all;
  for (const Box3& box : boxes)
    if (!box.empty()) all.add(box);
  if (all.empty()) return bvh;
  bvh.center = all.center();
  bvh.radius = 0.5 * all.diagonal();
  bvh.dilation = kRayDilation * bvh.radius;
  bvh.radius += 4.0 * bvh.dilation;
  Builder builder;
  builder.boxes.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].empty()) continue;
    builder.order.push_back(static_cast<std::int32_t>(i));
    for (int axis = 0; axis < 3; ++axis) {
      builder.boxes[i].lower[axis] = round_down(boxes[i].lower[axis] - bvh.center[axis] - bvh.dilation);
      builder.boxes[i].upper[axis] = round_up(boxes[i].upper[axis] - bvh.center[axis] + bvh.dilation);
    }
  }
  builder.nodes.reserve(builder.order.size());
  const auto count = static_cast<std::int32_t>(builder.order.size());
  if (count == 1) {
    bvh.nodes.emplace_back();
    const std::int32_t only = ~builder.order[0];
    builder.fill(bvh.nodes[0], &only, 1);
    return bvh;
  }
  builder.build(0, count, 0);
  bvh.nodes.reserve(count / 2 + 1);
  builder.widen(0, bvh.nodes);
  return bvh;
}

std::vector<std::int32_t> renumber_primitives(Bvh& bvh) {
  std::vector<std::int32_t> old;
  for (BvhNode& node : bvh.nodes)
    for (int i = 0; i < node.count; ++i) {
      if (node.child[i] >= 0) continue;
      old.push_back(~node.child[i]);
      node.child[i] = ~static_cast<std::int32_t>(old.size() - 1);
    }
  bvh.below.assign(bvh.nodes.size(), 0);
  for (std::size_t n = bvh.nodes.size(); n-- > 0;)  // children stand behind their parents
    for (int i = 0; i < bvh.nodes[n].count; ++i) {
      const std::int32_t child = bvh.nodes[n].child[i];
      bvh.below[n] += child < 0 ? 1 : bvh.below[child];
    }
  return old;
}

}  // namespace trimray::trace
