#include "core/trace/patch_offset.h"

#include <algorithm>
#include <cmath>

namespace trimray::trace {
namespace {

// A box this narrow, in patch parameters, is not split further.
constexpr double kMinWidth = 1.0 / (1 << 29);
constexpr int kMaxUnresolved = 64;
constexpr double kOverlap = 0.0625;  // of the width, on every side; see clipping.cpp

struct OffsetSearch {
  const Patch& patch;
  const dvec4* net;
  const Ray& ray;
  std::vector<PatchRoot>& roots;
  std::size_t first;
  dvec3 o{0.0};
  double t_shift = 0.0;

  OffsetSearch(const Patch& p, const dvec4* n, const Ray& r, std::vector<PatchRoot>& out)
      : patch(p), net(n), ray(r), roots(out), first(out.size()) {
    const dvec3 org = ray.org - patch.origin;
    t_shift = -glm::dot(org, ray.dir);
    o = org + t_shift * ray.dir;
  }

  // How far rounding of a point moves its parameters: much, beside a collapsed side.
  static dvec2 rounding(const OffsetJet& j) { return j.error / dvec2(glm::length(j.pu), glm::length(j.pv)); }

  // Newton with the true derivative; the answer is one full step from a point of the root grid.
  bool newton(dvec2 x, double max_step, PatchRoot& root) const {
    const auto step = [&](const dvec2& at, OffsetJet& j) {
      j = offset_jet(patch, net, at.x, at.y);
      const dvec3 g = glm::cross(j.p - o, ray.dir);
      const double den = glm::dot(glm::cross(j.pu, j.pv), ray.dir);
      return dvec2(glm::dot(g, j.pv), -glm::dot(g, j.pu)) / den;
    };
    OffsetJet j;
    bool converged = false;
    for (int k = 0; k < 4 * kMaxNewtonSteps && !converged; ++k) {
      const dvec2 d = step(x, j);
      if (!(std::fabs(d.x) < kInf && std::fabs(d.y) < kInf)) return false;
      const dvec2 noise = rounding(j);
      converged = std::fabs(d.x) <= 1e-8 + noise.x && std::fabs(d.y) <= 1e-8 + noise.y;
      x += glm::clamp(d, dvec2(-max_step), dvec2(max_step));
    }
    if (!converged) return false;
    x = glm::round(x / kRootGrid) * kRootGrid;
    const dvec2 d = step(x, j);
    const dvec2 limit = 4.0 * kRootGrid + 2.0 * rounding(j);
    if (!(std::fabs(d.x) <= limit.x && std::fabs(d.y) <= limit.y)) return false;
    const dvec3 p = j.p + j.pu * d.x + j.pv * d.y;
    dvec3 normal = j.normal;
    // Where the offset exceeds a radius of curvature its tangents turn over, and with them its normal.
    if (glm::dot(glm::cross(j.pu, j.pv), normal) < 0.0) normal = -normal;
    root = {x.x + d.x, x.y + d.y, t_shift + glm::dot(p - o, ray.dir), normal};
    return true;
  }

  void add(const PatchRoot& root) {
    const dvec2 same = 1e-10 + 4.0 * rounding(offset_jet(patch, net, root.u, root.v));
    for (std::size_t k = first; k < roots.size(); ++k)
      if (std::fabs(roots[k].u - root.u) <= same.x && std::fabs(roots[k].v - root.v) <= same.y &&
          glm::dot(roots[k].normal, ray.dir) * glm::dot(root.normal, ray.dir) > 0.0)
        return;
    roots.push_back(root);
  }

  enum class Verdict { kNone, kUnique, kOpen };
  Verdict judge(const SubDomain& wide, double& long_u, double& long_v) const;
};

// Is there no root on the box, at most one, or nothing to be said? Sets how far the enclosure reaches in u
// and v.
OffsetSearch::Verdict OffsetSearch::judge(const SubDomain& wide, double& long_u, double& long_v) const {
  const OffsetBox box = enclose_offset(patch, net, wide);
  const double u = 0.5 * (wide.u0 + wide.u1), v = 0.5 * (wide.v0 + wide.v1);
  const OffsetJet middle = offset_jet(patch, net, u, v);
  // Two directions across the line; one as near to the normal as can be: where the line grazes, the surface
  // is thin.
  dvec3 n1 = middle.normal - glm::dot(middle.normal, ray.dir) * ray.dir;
  if (!(glm::length(n1) > 1e-3))
    n1 = glm::cross(ray.dir, std::fabs(ray.dir.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0));
  n1 = glm::normalize(n1);
  const dvec3 n2 = glm::cross(ray.dir, n1);
  const double noise = 1e-14 * (patch.size + std::fabs(patch.offset) + glm::length(o));
  const dvec3 axes[2] = {n1, n2};
  const Interval reach{-std::fabs(patch.offset), std::fabs(patch.offset)};
  for (const dvec3& axis : axes) {
    const double at = glm::dot(axis, o - box.center);
    const dvec3 local = box.frame * axis;
    const Interval side = box.regular ? patch.offset * dot(local, box.normal) : reach;
    const Interval f = dot(local, box.base) + side - Interval{at - noise, at + noise};
    if (!f.has_zero()) return Verdict::kNone;
  }
  if (!box.regular) return Verdict::kOpen;
  const auto reach_of = [](const Interval3& a) {
    return std::max(std::max(a.x.magnitude(), a.y.magnitude()), a.z.magnitude());
  };
  long_u = reach_of(box.swapped ? box.py : box.px), long_v = reach_of(box.swapped ? box.px : box.py);
  const double error = noise + middle.error;
  for (const dvec3& axis : axes) {
    const dvec3 local = box.frame * axis;
    const double spread =
        0.5 * (dot(local, box.px).magnitude() + dot(local, box.py).magnitude()) * (1.0 + 1e-9);
    if (std::fabs(glm::dot(axis, middle.p - o)) > spread + error) return Verdict::kNone;
  }

  // The Jacobian across the line, preconditioned by its middle.
  const auto mid = [](const Interval3& a) {
    return 0.5 * dvec3(a.x.lo + a.x.hi, a.y.lo + a.y.hi, a.z.lo + a.z.hi);
  };
  const dvec3 cx = mid(box.px), cy = mid(box.py), l1 = box.frame * n1, l2 = box.frame * n2;
  const dvec2 a(glm::dot(l1, cx), glm::dot(l2, cx)), b(glm::dot(l1, cy), glm::dot(l2, cy));
  const double det = a.x * b.y - a.y * b.x;
  if (!(std::fabs(det) > 1e-12 * glm::length(a) * glm::length(b))) return Verdict::kOpen;
  const dvec3 row_x = (b.y * n1 - b.x * n2) / det, row_y = (a.x * n2 - a.y * n1) / det;
  const dvec3 local_x = box.frame * row_x, local_y = box.frame * row_y;
  const double xx = (dot(local_x, box.px) - Interval{1.0, 1.0}).magnitude(),
               xy = dot(local_x, box.py).magnitude();
  const double yx = dot(local_y, box.px).magnitude(),
               yy = (dot(local_y, box.py) - Interval{1.0, 1.0}).magnitude();
  // Linear bound from the middle: |row . (p - o)| there is at most the half widths' worth of the Jacobian.
  const double gx = glm::dot(row_x, middle.p - o), gy = glm::dot(row_y, middle.p - o);
  if (std::fabs(gx) - error * glm::length(row_x) > 0.5 * (1.0 + xx + xy) * (1.0 + 1e-9))
    return Verdict::kNone;
  if (std::fabs(gy) - error * glm::length(row_y) > 0.5 * (1.0 + yy + yx) * (1.0 + 1e-9))
    return Verdict::kNone;
  const bool unique = xx < 1.0 && yy < 1.0 && (1.0 - xx) * (1.0 - yy) > xy * yx * (1.0 + 1e-9);
  return unique ? Verdict::kUnique : Verdict::kOpen;
}

}  // namespace

ClipStats offset_roots(const Patch& patch, const PatchPool& pool, const LeafBound& leaf, const Ray& ray,
                       std::vector<PatchRoot>& roots) {
  const dvec4* net = pool.net.data() + patch.net;
  OffsetSearch search(patch, net, ray, roots);
  ClipStats stats;
  std::vector<SubDomain> stack{{leaf.mid_u - leaf.half_u, leaf.mid_u + leaf.half_u, leaf.mid_v - leaf.half_v,
                                leaf.mid_v + leaf.half_v}};
  while (!stack.empty()) {
    const SubDomain d = stack.back();
    stack.pop_back();
    if (++stats.boxes > kMaxOffsetBoxes) {
      stats.exhausted = true;
      break;
    }
    const double wu = d.u1 - d.u0, wv = d.v1 - d.v0;
    const SubDomain wide = widened(patch, d, kOverlap * wu, kOverlap * wv);
    double long_u = wu * leaf.half_v, long_v = wv * leaf.half_u;
    const OffsetSearch::Verdict verdict = search.judge(wide, long_u, long_v);
    if (verdict == OffsetSearch::Verdict::kNone) continue;
    PatchRoot root;
    if (verdict == OffsetSearch::Verdict::kUnique &&
        search.newton(dvec2(0.5 * (d.u0 + d.u1), 0.5 * (d.v0 + d.v1)), std::max(wu, wv), root) &&
        root.u >= wide.u0 && root.u <= wide.u1 && root.v >= wide.v0 && root.v <= wide.v1) {
      if (root.u >= d.u0 - kLeafSlack && root.u <= d.u1 + kLeafSlack && root.v >= d.v0 - kLeafSlack &&
          root.v <= d.v1 + kLeafSlack)
        search.add(root);
      continue;
    }
    if (wu <= kMinWidth && wv <= kMinWidth) {
      ++stats.unresolved;
      continue;
    }
    SubDomain low = d, high = d;
    if (wv <= kMinWidth || (wu > kMinWidth && long_u >= long_v))
      low.u1 = high.u0 = 0.5 * (d.u0 + d.u1);
    else
      low.v1 = high.v0 = 0.5 * (d.v0 + d.v1);
    stack.push_back(high), stack.push_back(low);
  }
  // A tangent line leaves a few tiny boxes; more of them mean that rounding hid what there was.
  stats.exhausted = stats.exhausted || stats.unresolved > kMaxUnresolved;
  return stats;
}

}  // namespace trimray::trace
