#include "core/tess/view_tolerance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace trimray::tess {

namespace {

// The largest singular value: the root of the largest eigenvalue of m^T m, in closed form (Smith:
// "Eigenvalues of a symmetric 3 x 3 matrix", Communications of the ACM 4, 1961).
double largest_stretch(const dmat3& m) {
  const dmat3 a = glm::transpose(m) * m;
  const double mean = (a[0][0] + a[1][1] + a[2][2]) / 3.0;
  const dmat3 b = a - dmat3(mean);
  double size2 = 0.0;
  for (int i = 0; i < 3; ++i) size2 += glm::dot(b[i], b[i]);
  const double p = std::sqrt(size2 / 6.0);
  double largest = mean;
  if (p > 0.0) {
    const double half_det = std::clamp(0.5 * glm::determinant(b / p), -1.0, 1.0);
    largest += 2.0 * p * std::cos(std::acos(half_det) / 3.0);
  }
  return std::max(std::sqrt(largest) * (1.0 + 1e-12), 1e-300);
}

// mm: what rounding may move a corner by.
double rounding(const Box3& box) { return 1e-9 * (box.diagonal() + glm::length(box.center())); }

}  // namespace

ViewTolerance::ViewTolerance(const view::Camera& c, const ViewLimits& limits, const Transform& placement)
    : perspective_(c.perspective), near_(limits.near), stretch_(largest_stretch(placement.linear)) {
  // A surface may reach over the border of its triangle's neighbourhood by the deviation; a pixel more is for
  // filters.
  const double rim = 1.0 + limits.deviation_px + limits.guard_px;
  const double x = (0.5 * c.width_px + rim) * c.pixel, y = (0.5 * c.height_px + rim) * c.pixel;
  const auto in_prototype = [&](const dvec3& n, double d) {
    return Affine{glm::transpose(placement.linear) * n, glm::dot(n, placement.translation) + d};
  };
  const auto beside = [&](const dvec3& across, double half) {
    const dvec3 n = perspective_ ? glm::normalize(across - half * c.forward) : across;
    return in_prototype(n, -glm::dot(n, c.eye) - (perspective_ ? 0.0 : half));
  };
  planes_ = {beside(c.right, x), beside(-c.right, x), beside(c.up, y), beside(-c.up, y),
             in_prototype(-c.forward, glm::dot(c.forward, c.eye))};
  depth_ = in_prototype(c.forward, -glm::dot(c.forward, c.eye));
  // A shift by s at depth z and tangent r from the axis is seen as s sqrt(1 + r^2) / (z - s) at most.
  const double wanted = limits.deviation_px * c.pixel;
  share_ = perspective_ ? wanted / (std::sqrt(1.0 + x * x + y * y) + wanted) : wanted;
}

double ViewTolerance::allowed(double depth) const {
  return (perspective_ ? share_ * std::max(depth, near_) : share_) / stretch_;
}

double ViewTolerance::beyond(const Box3& box) const {
  double most = -kInf;
  for (const Affine& plane : planes_) most = std::max(most, plane.least(box));
  return most;
}

double ViewTolerance::at(const Box3& box) const {
  if (box.empty()) return kInf;
  return std::max(allowed(depth_.least(box)), beyond(box) / stretch_);
}

double ViewTolerance::most(const Box3& box) const { return allowed(depth_.most(box)); }

bool ViewTolerance::inside(const Box3& box) const {
  return std::all_of(planes_.begin(), planes_.end(), [&](const Affine& p) { return p.most(box) <= 0.0; });
}

double ViewTolerance::share(const Box3& box) const {
  if (inside(box)) return 1.0;
  constexpr int kSide = 8;
  int seen = 0;
  for (int k = 0; k < kSide * kSide * kSide; ++k) {
    const dvec3 cell(k % kSide + 0.5, k / kSide % kSide + 0.5, k / kSide / kSide + 0.5);
    const dvec3 p = box.lower + cell / double(kSide) * box.extent();
    seen += std::all_of(planes_.begin(), planes_.end(), [&](const Affine& s) { return s(p) <= 0.0; });
  }
  return double(seen) / (kSide * kSide * kSide);
}

std::vector<dvec3> ViewTolerance::corners(const Box3& box, const Affine& cut) const {
  std::vector<Affine> sides(planes_.begin(), planes_.end());
  sides.push_back(cut);
  for (int d = 0; d < 3; ++d) {
    dvec3 n(0.0);
    n[d] = 1.0;
    sides.push_back({n, -box.upper[d]}), sides.push_back({-n, box.lower[d]});
  }
  const double near = rounding(box);
  std::vector<dvec3> found;
  for (std::size_t i = 0; i < sides.size(); ++i)
    for (std::size_t j = i + 1; j < sides.size(); ++j)
      for (std::size_t k = j + 1; k < sides.size(); ++k) {
        const dvec3 a = sides[i].n, b = sides[j].n, c = sides[k].n;
        const double det = glm::dot(a, glm::cross(b, c));
        if (!(std::abs(det) > 1e-12 * glm::length(a) * glm::length(b) * glm::length(c))) continue;
        const dvec3 p =
            -(sides[i].d * glm::cross(b, c) + sides[j].d * glm::cross(c, a) + sides[k].d * glm::cross(a, b)) /
            det;
        if (std::all_of(sides.begin(), sides.end(),
                        [&](const Affine& s) { return s(p) <= near * glm::length(s.n); }))
          found.push_back(p);
      }
  return found;
}

bool ViewTolerance::serves(const ViewTolerance& other, const Box3& box, double finer) const {
  // What the other one sees of the box is a convex body, cut where its tolerance stops to shrink towards the
  // eye: in either part that is affine. Being within planes, and wanting no more than an affine function, is
  // decided at the corners, since the tolerance here is convex.
  const Affine far{-other.depth_.n, other.near_ - other.depth_.d};
  const Affine near{other.depth_.n, other.depth_.d - other.near_};
  double finest = kInf;
  const Affine none;
  const std::vector<Affine> cuts = other.perspective_ ? std::vector{far, near} : std::vector{none};
  for (const Affine& cut : cuts) {
    for (const dvec3& p : other.corners(box, cut)) {
      const double own = allowed(depth_(p)), wanted = other.allowed(other.depth_(p));
      if (!(own <= wanted * (1.0 + 1e-9))) return false;
      // The rim has room for a thousandth of the deviation, which is what rounding may take.
      for (const Affine& plane : planes_)
        if (plane(p) > (1e-3 * own + rounding(box)) * stretch_) return false;
      finest = std::min(finest, wanted / own);
    }
  }
  return finest <= finer;
}

}  // namespace trimray::tess
