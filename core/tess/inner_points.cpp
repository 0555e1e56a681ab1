#include "core/tess/inner_points.h"

#include <algorithm>
#include <cmath>

namespace trimray::tess {
namespace {

// The polygon's sides by rows of constant v.
class Rows {
 public:
  explicit Rows(const FacePolygon& polygon) : box_(polygon.box) {
    for (const auto& loop : polygon.loops)
      for (std::size_t i = 0; i < loop.size(); ++i)
        sides_.push_back({loop[i].p, loop[(i + 1) % loop.size()].p});
    const int count = std::clamp(static_cast<int>(sides_.size()) / 2, 1, 1024);
    rows_.resize(count);
    height_ = std::max(box_.extent().y, 1e-300) / count;
    for (std::size_t i = 0; i < sides_.size(); ++i) {
      const auto [lo, hi] = std::minmax(sides_[i].a.y, sides_[i].b.y);
      for (int r = row(lo); r <= row(hi); ++r) rows_[r].push_back(static_cast<int>(i));
    }
  }

  // Inside by the even-odd rule, and no side nearer than reach in the norm of points divided by cell.
  bool takes(dvec2 p, dvec2 cell, double reach) const {
    for (int r = row(p.y - reach * cell.y); r <= row(p.y + reach * cell.y); ++r)
      for (const int i : rows_[r])
        if (near((sides_[i].a - p) / cell, (sides_[i].b - p) / cell, reach)) return false;
    bool inside = false;
    for (const int i : rows_[row(p.y)]) {
      const dvec2 a = sides_[i].a, b = sides_[i].b;
      if ((a.y > p.y) == (b.y > p.y)) continue;
      if (p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
    }
    return inside;
  }

 private:
  struct Side {
    dvec2 a, b;
  };

  int row(double v) const {
    const double r = (v - box_.lower.y) / height_;
    return static_cast<int>(std::clamp(r, 0.0, static_cast<double>(rows_.size() - 1)));
  }

  static bool near(dvec2 a, dvec2 b, double reach) {
    const dvec2 d = b - a;
    const double length2 = glm::dot(d, d);
    const double t = length2 > 0.0 ? std::clamp(-glm::dot(a, d) / length2, 0.0, 1.0) : 0.0;
    const dvec2 foot = a + t * d;
    return glm::dot(foot, foot) < reach * reach;
  }

  Box2 box_;
  double height_ = 1.0;
  std::vector<Side> sides_;
  std::vector<std::vector<int>> rows_;
};

}  // namespace

std::vector<dvec2> inner_points(const CurvatureTree& tree, const FacePolygon& polygon) {
  constexpr double kReach = 0.4;  // of a cell
  std::vector<dvec2> points;
  bool any = tree.leaves().size() > 1;
  for (const GridLeaf& leaf : tree.leaves()) any = any || leaf.count_u > 1 || leaf.count_v > 1;
  if (!any) return points;
  const Rows rows(polygon);
  const dvec2 least = 1e-9 * polygon.box.extent();
  for (const GridLeaf& leaf : tree.leaves()) {
    const dvec2 cell = leaf.box.extent() / dvec2(leaf.count_u, leaf.count_v);
    // A leaf's lower and left borders are its own, but where they are the face's.
    const int first_u = leaf.box.lower.x > polygon.box.lower.x + least.x ? 0 : 1;
    const int first_v = leaf.box.lower.y > polygon.box.lower.y + least.y ? 0 : 1;
    for (int j = first_v; j < leaf.count_v; ++j)
      for (int i = first_u; i < leaf.count_u; ++i) {
        const double stagger = leaf.count_u > 1 && leaf.count_v > 1 && (j & 1) ? 0.5 : 0.0;
        const dvec2 p = leaf.box.lower + cell * dvec2(i + stagger, j);
        if (rows.takes(p, cell, kReach)) points.push_back(p);
      }
  }
  return points;
}

}  // namespace trimray::tess
