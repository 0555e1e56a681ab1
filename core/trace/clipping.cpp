#include "core/trace/clipping.h"

#include <algorithm>
#include <cmath>

#include "core/nurbs/knot_vector.h"
#include "core/trace/certificate.h"
#include "core/trace/patch_net.h"

namespace trimray::trace {
namespace {

constexpr int kMaxNet = (nurbs::kMaxDegree + 1) * (nurbs::kMaxDegree + 1);

// Boxes are examined a little larger than they are, so that a root on the border between two of them lies
// well inside a proven region of both.
constexpr double kOverlap = 0.0625;  // of the width, on every side

// A box this narrow, in patch parameters, is not split further in that direction. At a collapsed side roots
// can be told apart at smaller distances from it.
constexpr double kMinWidth = 1.0 / (1 << 29);
constexpr double kMinWidthAtPole = kMinWidth / (1 << 13);

constexpr int kMaxUnresolved = 64;

struct ClipBox {
  SubDomain core;
};

dvec3 xyz(const dvec4& h) { return dvec3(h.x, h.y, h.z); }

// Smallest and largest value of the net along l exclude zero?
bool excludes(const dvec2* f, int count, const dvec2& l, double noise) {
  double lo = kInf, hi = -kInf;
  for (int k = 0; k < count; ++k) {
    const double x = glm::dot(f[k], l);
    lo = std::min(lo, x), hi = std::max(hi, x);
  }
  const double limit = noise * (std::fabs(l.x) + std::fabs(l.y));
  return lo > limit || hi < -limit;
}

// Does the whole net lie on the line through the origin that is normal to l?
bool on_line(const dvec2* f, int count, const dvec2& l, double noise) {
  const double limit = 4.0 * noise * (std::fabs(l.x) + std::fabs(l.y));
  for (int k = 0; k < count; ++k)
    if (!(std::fabs(glm::dot(f[k], l)) <= limit)) return false;
  return true;
}

class Search {
 public:
  Search(const Patch& patch, const PatchPool& pool, const LeafBound& leaf, const Ray& ray,
         std::vector<PatchRoot>& roots)
      : patch_(patch),
        pool_(pool),
        leaf_(leaf),
        ray_(ray),
        roots_(roots),
        du_(patch.degree_u),
        dv_(patch.degree_v),
        count_((du_ + 1) * (dv_ + 1)),
        first_(roots.size()) {
    project();
  }

  ClipStats run() {
    find_poles();
    ClipBox stack[256];
    int top = 0;
    stack[top++] = {{leaf_.mid_u - leaf_.half_u, leaf_.mid_u + leaf_.half_u, leaf_.mid_v - leaf_.half_v,
                     leaf_.mid_v + leaf_.half_v}};
    while (top > 0) {
      const ClipBox box = stack[--top];
      if (++stats_.boxes > kMaxClipBoxes) {
        stats_.exhausted = true;
        break;
      }
      ClipBox low = box, high = box;
      if (examine(box, low, high) && top + 2 <= 256) stack[top++] = high, stack[top++] = low;
    }
    // A tangent line leaves a few tiny boxes; more of them mean that the line lies in the surface.
    stats_.exhausted = stats_.exhausted || stats_.unresolved > kMaxUnresolved;
    return stats_;
  }

 private:
  // The distance net over the whole patch: coordinates of P - w o in two directions across the ray.
  void project() {
    const dvec3 org = ray_.org - patch_.origin;
    const dvec3 o = org - glm::dot(org, ray_.dir) * ray_.dir;
    const dvec3 d = ray_.dir;
    const dvec3 away = std::fabs(d.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
    const dvec3 n1 = glm::normalize(glm::cross(d, away)), n2 = glm::cross(d, n1);
    const dvec4* net = pool_.net.data() + patch_.net;
    double max_w = 0.0;
    for (int k = 0; k < count_; ++k) {
      const dvec3 p = xyz(net[k]) - net[k].w * o;
      whole_[k] = dvec2(glm::dot(p, n1), glm::dot(p, n2));
      max_w = std::max(max_w, net[k].w);
    }
    noise_ = 4e-16 * max_w * (patch_.size + glm::length(o));
    o_ = o, t_shift_ = -glm::dot(org, d);
  }

  // True when the box must be split into low and high.
  bool examine(const ClipBox& box, ClipBox& low, ClipBox& high) {
    const SubDomain& c = box.core;
    const double wu = c.u1 - c.u0, wv = c.v1 - c.v0;
    for (int k = 0; k < pole_count_; ++k)
      if (near_side({c.u0, c.v0}, poles_found_[k].side) && near_side({c.u1, c.v1}, poles_found_[k].side))
        return false;
    const SubDomain wide{c.u0 - kOverlap * wu, c.u1 + kOverlap * wu, c.v0 - kOverlap * wv,
                         c.v1 + kOverlap * wv};
    dvec2 f[kMaxNet];
    std::copy(whole_, whole_ + count_, f);
    restrict_net(f, du_, dv_, wide.u0, wide.u1, wide.v0, wide.v1);

    const dvec2 f00 = f[0], f01 = f[dv_], f10 = f[du_ * (dv_ + 1)], f11 = f[count_ - 1];
    const dvec2 a = 0.5 * ((f10 - f00) + (f11 - f01)), b = 0.5 * ((f01 - f00) + (f11 - f10));
    const auto across = [](const dvec2& x) { return dvec2(-x.y, x.x); };
    if (excludes(f, count_, dvec2(1, 0), noise_) || excludes(f, count_, dvec2(0, 1), noise_) ||
        excludes(f, count_, across(a), noise_) || excludes(f, count_, across(b), noise_) ||
        excludes(f, count_, a, noise_) || excludes(f, count_, b, noise_))
      return false;

    if (unique(f, a, b) && settle(c, wide, f, a, b)) return false;

    // A flat part seen edge on: the line lies in it, and crosses it nowhere.
    const dvec2 longer = glm::dot(a, a) > glm::dot(b, b) ? a : b;
    if (longer != dvec2(0.0) && on_line(f, count_, across(longer), noise_)) {
      ++stats_.unresolved;
      return false;
    }
    // Split where the net is longer.
    double long_u = 0.0, long_v = 0.0;
    for (int j = 0; j <= dv_; ++j) {
      double sum = 0.0;
      for (int i = 0; i < du_; ++i) sum += glm::length(f[(i + 1) * (dv_ + 1) + j] - f[i * (dv_ + 1) + j]);
      long_u = std::max(long_u, sum);
    }
    for (int i = 0; i <= du_; ++i) {
      double sum = 0.0;
      for (int j = 0; j < dv_; ++j) sum += glm::length(f[i * (dv_ + 1) + j + 1] - f[i * (dv_ + 1) + j]);
      long_v = std::max(long_v, sum);
    }
    const double min_width = patch_.poles != 0 ? kMinWidthAtPole : kMinWidth;
    const bool can_u = wu > min_width, can_v = wv > min_width;
    if ((!can_u && !can_v) || std::max(long_u, long_v) <= noise_) {
      ++stats_.unresolved;
      return false;
    }
    const bool in_u = can_u && (!can_v || long_u > long_v);
    if (in_u)
      low.core.u1 = high.core.u0 = 0.5 * (c.u0 + c.u1);
    else
      low.core.v1 = high.core.v0 = 0.5 * (c.v0 + c.v1);
    return true;
  }

  // At most one root: the Jacobian, preconditioned by the middle's, keeps an H-matrix over the whole box.
  bool unique(const dvec2* f, const dvec2& a, const dvec2& b) const {
    const double det = a.x * b.y - a.y * b.x;
    if (!(std::fabs(det) > 1e-12 * glm::length(a) * glm::length(b))) return false;
    const dvec2 row_u = dvec2(b.y, -b.x) / det, row_v = dvec2(-a.y, a.x) / det;
    double uu = 0.0, uv = 0.0, vu = 0.0, vv = 0.0;  // largest entries of (inverse * Jacobian - identity)
    for (int i = 0; i < du_; ++i)
      for (int j = 0; j <= dv_; ++j) {
        const dvec2 d = static_cast<double>(du_) * (f[(i + 1) * (dv_ + 1) + j] - f[i * (dv_ + 1) + j]);
        uu = std::max(uu, std::fabs(glm::dot(row_u, d) - 1.0));
        vu = std::max(vu, std::fabs(glm::dot(row_v, d)));
      }
    for (int i = 0; i <= du_; ++i)
      for (int j = 0; j < dv_; ++j) {
        const dvec2 d = static_cast<double>(dv_) * (f[i * (dv_ + 1) + j + 1] - f[i * (dv_ + 1) + j]);
        uv = std::max(uv, std::fabs(glm::dot(row_u, d)));
        vv = std::max(vv, std::fabs(glm::dot(row_v, d) - 1.0));
      }
    return uu < 1.0 && vv < 1.0 && (1.0 - uu) * (1.0 - vv) > uv * vu * (1.0 + 1e-9);
  }

  // With at most one root in `wide`, Newton finds it or shows that it is elsewhere. False: split on.
  bool settle(const SubDomain& core, const SubDomain& wide, const dvec2* f, const dvec2& a, const dvec2& b) {
    const double det = a.x * b.y - a.y * b.x;
    dvec2 mean(0.0);
    for (int k = 0; k < count_; ++k) mean += f[k];
    mean /= count_;
    dvec2 x = dvec2(0.5) - dvec2(mean.x * b.y - mean.y * b.x, a.x * mean.y - a.y * mean.x) / det;
    x = glm::clamp(x, dvec2(0.0), dvec2(1.0));
    const dvec2 start(glm::mix(wide.u0, wide.u1, x.x), glm::mix(wide.v0, wide.v1, x.y));
    PatchRoot root;
    const double max_step = 0.5 * std::max(wide.u1 - wide.u0, wide.v1 - wide.v0);
    if (!polish(patch_, pool_.coef.data() + patch_.coef, ray_, start, max_step, root)) return false;
    if (!(root.u >= wide.u0 && root.u <= wide.u1 && root.v >= wide.v0 && root.v <= wide.v1)) return false;
    if (root.u >= core.u0 - kLeafSlack && root.u <= core.u1 + kLeafSlack && root.v >= core.v0 - kLeafSlack &&
        root.v <= core.v1 + kLeafSlack)
      add(root);
    return true;
  }

  // The same root from two boxes counts once.
  void add(const PatchRoot& root) {
    for (int k = 0; k < pole_count_; ++k)
      if (near_side({root.u, root.v}, poles_found_[k].side)) return;
    for (std::size_t k = first_; k < roots_.size(); ++k) {
      const PatchRoot& r = roots_[k];
      if (std::fabs(r.u - root.u) <= 1e-10 && std::fabs(r.v - root.v) <= 1e-10 &&
          glm::dot(r.normal, ray_.dir) * glm::dot(root.normal, ray_.dir) > 0.0)
        return;
    }
    roots_.push_back(root);
  }

  // A collapsed side that the line meets; the parameters next to it are the one root's.
  struct Pole {
    std::uint8_t side = 0;
  };

  static bool near_side(const dvec2& x, std::uint8_t side) {
    const double distance = side == kSideU0   ? x.x
                            : side == kSideU1 ? 1.0 - x.x
                            : side == kSideV0 ? x.y
                                              : 1.0 - x.y;
    return std::fabs(distance) < 1e-7;
  }

  // A line through a collapsed side's point meets it at every parameter along the side: one root, reported
  // here; boxes that have shrunk onto the side are dropped.
  void find_poles() {
    const double u0 = leaf_.mid_u - leaf_.half_u, u1 = leaf_.mid_u + leaf_.half_u;
    const double v0 = leaf_.mid_v - leaf_.half_v, v1 = leaf_.mid_v + leaf_.half_v;
    const int row = dv_ + 1;
    if ((patch_.poles & kSideU0) && u0 <= kLeafSlack) pole(kSideU0, 0, row, 1, dv_, {0.0, leaf_.mid_v});
    if ((patch_.poles & kSideU1) && u1 >= 1.0 - kLeafSlack)
      pole(kSideU1, du_ * row, -row, 1, dv_, {1.0, leaf_.mid_v});
    if ((patch_.poles & kSideV0) && v0 <= kLeafSlack) pole(kSideV0, 0, 1, row, du_, {leaf_.mid_u, 0.0});
    if ((patch_.poles & kSideV1) && v1 >= 1.0 - kLeafSlack)
      pole(kSideV1, dv_, -1, row, du_, {leaf_.mid_u, 1.0});
  }

  // first: index of the side's first control point; inward, along: index steps; n: degree along the side.
  void pole(std::uint8_t side, int first, int inward, int along, int n, dvec2 at) {
    const dvec4* net = pool_.net.data() + patch_.net;
    const dvec3 p = xyz(net[first]) / net[first].w;
    const double distance = glm::length(glm::cross(p - o_, ray_.dir));
    if (!(distance <= patch_.pole_reach)) return;
    // S = p + e G(x) / w + O(e^2), e the distance from the side: the limit normal is +-G x G'.
    dvec3 g[nurbs::kMaxDegree + 1];
    for (dvec3& x : g) x = dvec3(0.0);
    for (int i = 0; i <= n; ++i) {
      const dvec4& h = net[first + i * along + inward];
      g[i] = xyz(h) - h.w * p;
    }
    const bool side_u = side == kSideU0 || side == kSideU1;
    const double x = side_u ? at.y : at.x;
    for (int r = 1; r < n; ++r)
      for (int i = 0; i + r <= n; ++i) g[i] = (1.0 - x) * g[i] + x * g[i + 1];
    const dvec3 tangent = n > 0 ? g[1] - g[0] : dvec3(0.0), value = (1.0 - x) * g[0] + x * g[1];
    dvec3 normal = glm::cross(value, tangent);                 // S_e x S_x for small e
    if (!side_u) normal = -normal;                             // S_u is along the side
    if (side == kSideU1 || side == kSideV1) normal = -normal;  // e runs against the parameter
    const double length = glm::length(normal);
    if (!(length > 0.0)) return;
    normal /= length;
    // The tangent plane there, unless the line grazes it.
    const double slope = glm::dot(normal, ray_.dir), straight = glm::dot(p - o_, ray_.dir);
    const double t = std::fabs(slope) > 1e-6 ? glm::dot(p - o_, normal) / slope : straight;
    poles_found_[pole_count_++] = {side};
    roots_.push_back({at.x, at.y, t_shift_ + t, normal});
  }

  const Patch& patch_;
  const PatchPool& pool_;
  const LeafBound& leaf_;
  const Ray& ray_;
  std::vector<PatchRoot>& roots_;
  const int du_, dv_, count_;
  const std::size_t first_;
  ClipStats stats_;
  dvec2 whole_[kMaxNet];
  double noise_ = 0.0, t_shift_ = 0.0;
  dvec3 o_{0.0};
  Pole poles_found_[4];
  int pole_count_ = 0;
};

}  // namespace

ClipStats clip_roots(const Patch& patch, const PatchPool& pool, const LeafBound& leaf, const Ray& ray,
                     std::vector<PatchRoot>& roots) {
  return Search(patch, pool, leaf, ray, roots).run();
}

}  // namespace trimray::trace
