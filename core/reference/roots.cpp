#include "core/reference/roots.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trimray::reference {
namespace {

constexpr int kMaxBoxes = 20000;       // of one piece: beyond it the line lies in the surface
constexpr double kMinWidth = 0x1p-50;  // of a box, of the unit square
constexpr double kRim = 1e-12;         // of the unit square: roots so far outside belong to the border

struct Job {
  Net net;
  dvec2 lower{0.0}, upper{1.0};
};

const dvec2& at(const Net& n, int i, int j) { return n.c[i * (n.q + 1) + j]; }

// Restricts one row of coefficients, count of them with a stride, to [0, x] or [x, 1].
void restrict_row(dvec2* row, int count, int stride, double x, bool upper_part) {
  if (upper_part) {
    for (int r = 1; r < count; ++r)
      for (int i = 0; i < count - r; ++i)
        row[i * stride] = (1.0 - x) * row[i * stride] + x * row[(i + 1) * stride];
  } else {
    for (int r = 1; r < count; ++r)
      for (int i = count - 1; i >= r; --i)
        row[i * stride] = (1.0 - x) * row[(i - 1) * stride] + x * row[i * stride];
  }
}

void restrict_net(Net& n, int axis, double x, bool upper_part) {
  if (axis == 0)
    for (int j = 0; j <= n.q; ++j) restrict_row(&n.c[j], n.p + 1, n.q + 1, x, upper_part);
  else
    for (int i = 0; i <= n.p; ++i) restrict_row(&n.c[i * (n.q + 1)], n.q + 1, 1, x, upper_part);
}

// The same polynomials over [-1/2, 3/2] of a box.
Net inflated(const Net& net) {
  Net n = net;
  for (int axis = 0; axis < 2; ++axis) {
    restrict_net(n, axis, 1.5, false);
    restrict_net(n, axis, -0.5 / 1.5, true);
  }
  return n;
}

// True when some line through the origin has all coefficients on one side, farther from it than noise:
// the values are convex combinations of the coefficients, so they cannot vanish.
bool excluded(const Net& n, double noise) {
  dvec2 lower(kInf), upper(-kInf);
  for (const dvec2& c : n.c) lower = glm::min(lower, c), upper = glm::max(upper, c);
  if (lower.x > noise || lower.y > noise || upper.x < -noise || upper.y < -noise) return true;

  // The widest empty sector as seen from the origin.
  std::vector<double> angles;
  for (const dvec2& c : n.c) {
    if (std::abs(c.x) <= noise && std::abs(c.y) <= noise) return false;
    angles.push_back(std::atan2(c.y, c.x));
  }
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + 2.0 * std::numbers::pi - angles.back(), middle = angles.front() - gap / 2;
  for (std::size_t i = 1; i < angles.size(); ++i)
    if (angles[i] - angles[i - 1] > gap) gap = angles[i] - angles[i - 1], middle = angles[i] - gap / 2;
  if (gap <= std::numbers::pi) return false;
  const dvec2 away(-std::cos(middle), -std::sin(middle));
  return std::all_of(n.c.begin(), n.c.end(), [&](const dvec2& c) { return glm::dot(c, away) > noise; });
}

// All coefficients within noise of a line through the origin: the piece is seen edge-on, or is a point on the
// ray.
bool edge_on(const Net& n, double noise) {
  dvec2 far(0.0);
  for (const dvec2& c : n.c)
    if (glm::dot(c, c) > glm::dot(far, far)) far = c;
  const double length = glm::length(far);
  if (length <= 2.0 * noise) return true;
  return std::all_of(n.c.begin(), n.c.end(),
                     [&](const dvec2& c) { return std::abs(far.x * c.y - far.y * c.x) <= noise * length; });
}

struct Value {
  dvec2 f, fx, fy;
};

Value value(const Net& net, double x, double y) {
  std::vector<dvec2> row(net.q + 1), f(net.p + 1), fy(net.p + 1);
  auto run = [](std::vector<dvec2>& r, double t, dvec2& point, dvec2& slope) {
    const int degree = static_cast<int>(r.size()) - 1;
    slope = dvec2(0.0);
    for (int k = 1; k <= degree; ++k) {
      if (k == degree) slope = double(degree) * (r[1] - r[0]);
      for (int i = 0; i <= degree - k; ++i) r[i] = (1.0 - t) * r[i] + t * r[i + 1];
    }
    point = r[0];
  };
  for (int i = 0; i <= net.p; ++i) {
    row.assign(net.c.begin() + i * (net.q + 1), net.c.begin() + (i + 1) * (net.q + 1));
    run(row, y, f[i], fy[i]);
  }
  Value v;
  dvec2 unused;
  run(f, x, v.f, v.fx);
  run(fy, x, v.fy, unused);
  return v;
}

enum class Verdict { kNone, kOne, kOpen };

// Judges the middle half of an inflated box. With T(x) = x - J(c)^-1 F(x) a contraction of rate rho <= 1/4 on
// the unit square in the maximum norm, a root in the square lies within rho / 2 of T(c). Either that
// neighbourhood misses the middle half, or it lies inside the square and T has exactly one fixed point there.
Verdict judge(const Net& big, dvec2& root) {
  const Value mid = value(big, 0.5, 0.5);
  const double det = mid.fx.x * mid.fy.y - mid.fx.y * mid.fy.x;
  if (!(std::abs(det) > 0.0)) return Verdict::kOpen;
  auto solve = [&](const dvec2& f) {
    return dvec2(mid.fy.y * f.x - mid.fy.x * f.y, mid.fx.x * f.y - mid.fx.y * f.x) / det;
  };
  dvec2 dev_x(0.0), dev_y(0.0);
  for (int i = 0; i < big.p; ++i)
    for (int j = 0; j <= big.q; ++j)
      dev_x =
          glm::max(dev_x, glm::abs(solve(double(big.p) * (at(big, i + 1, j) - at(big, i, j))) - dvec2(1, 0)));
  for (int i = 0; i <= big.p; ++i)
    for (int j = 0; j < big.q; ++j)
      dev_y =
          glm::max(dev_y, glm::abs(solve(double(big.q) * (at(big, i, j + 1) - at(big, i, j))) - dvec2(0, 1)));
  const double rho = std::max(dev_x.x + dev_y.x, dev_x.y + dev_y.y);
  if (!(rho <= 0.25)) return Verdict::kOpen;

  const dvec2 step = solve(mid.f);
  if (std::max(std::abs(step.x), std::abs(step.y)) > 0.25 + 0.5 * rho + 1e-9) return Verdict::kNone;
  root = dvec2(0.5) - step;
  for (int k = 0; k < 30; ++k) root -= solve(value(big, root.x, root.y).f);
  return Verdict::kOne;
}

// Halving along the axis that moves the coefficients most leaves a collapsed or constant direction whole.
int split_axis(const Net& n, const dvec2& width) {
  double along_x = 0.0, along_y = 0.0;
  for (int i = 0; i <= n.p; ++i)
    for (int j = 0; j <= n.q; ++j) {
      if (i < n.p) along_x = std::max(along_x, n.p * glm::length(at(n, i + 1, j) - at(n, i, j)));
      if (j < n.q) along_y = std::max(along_y, n.q * glm::length(at(n, i, j + 1) - at(n, i, j)));
    }
  if (width.x <= kMinWidth) return 1;
  if (width.y <= kMinWidth) return 0;
  return along_x >= along_y ? 0 : 1;
}

}  // namespace

bool common_roots(const Net& net, double noise, std::vector<dvec2>& roots) {
  std::vector<Job> jobs(1);
  jobs[0].net = net;
  bool decided = true;
  for (int boxes = 0; !jobs.empty(); ++boxes) {
    if (boxes >= kMaxBoxes) return false;
    Job job = std::move(jobs.back());
    jobs.pop_back();
    if (excluded(job.net, noise)) continue;
    const dvec2 width = job.upper - job.lower;
    dvec2 root;
    const Verdict verdict = judge(inflated(job.net), root);
    if (verdict == Verdict::kNone) continue;
    if (verdict == Verdict::kOne) {
      const dvec2 x = job.lower + width * (2.0 * root - 0.5);
      const dvec2 rim(kRim);
      if (glm::all(glm::greaterThanEqual(x, job.lower - rim)) &&
          glm::all(glm::lessThanEqual(x, job.upper + rim)))
        roots.push_back(x);
      continue;
    }
    if (edge_on(job.net, noise) || (width.x <= kMinWidth && width.y <= kMinWidth)) {
      decided = false;
      continue;
    }
    const int axis = split_axis(job.net, width);
    const double middle = 0.5 * (job.lower[axis] + job.upper[axis]);
    Job high = job;
    restrict_net(job.net, axis, 0.5, false);
    restrict_net(high.net, axis, 0.5, true);
    job.upper[axis] = middle, high.lower[axis] = middle;
    jobs.push_back(std::move(high));
    jobs.push_back(std::move(job));
  }
  return decided;
}

}  // namespace trimray::reference
