#include "core/mass/face_integrals.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include "core/mass/gauss.h"
#include "core/mass/strips.h"

namespace trimray::mass {
namespace {

// Relative, of the whole face; and what rounding alone leaves between two rules.
constexpr double kWanted = 1e-13;
constexpr double kRounding = 2e-15;
constexpr double kUvRounding = 4e-16;
// A face is not taken to be smaller than this share of its strips, of which nothing else is left.
constexpr double kSliver = 1e-4;
// Parts that a face may be cut into beyond its strips. Reached where the area is not smooth within a patch.
constexpr int kMostCuts = 4000;
constexpr int kMostHalvings = 30;

struct Curve {
  dvec2 at, slope;  // by t
};

Curve curve_at(const Strips& strips, const Strip& s, double t) {
  if (s.degree == 1) return {s.from + t * (s.to - s.from), s.to - s.from};
  dvec3 d[nurbs::kMaxDegree + 1];
  std::copy_n(&strips.ctrl_h[s.ctrl], s.degree + 1, d);
  for (int n = s.degree; n > 1; --n)
    for (int i = 0; i < n; ++i) d[i] = (1.0 - t) * d[i] + t * d[i + 1];
  const dvec3 h = (1.0 - t) * d[0] + t * d[1], dh = double(s.degree) * (d[1] - d[0]);
  const dvec2 at = dvec2(h) / h.z;
  return {at, (dvec2(dh) - dh.z * at) / h.z};
}

// What rounding of uv does to a strip, relative: its sides are differences of coordinates that may be far
// from 0.
double uv_rounding(const Strip& s) {
  const auto lost = [](double a, double b) {
    const double size = std::abs(a - b);
    return size > 0.0 ? std::min(kUvRounding * std::max(std::abs(a), std::abs(b)) / size, 1.0) : 0.0;
  };
  const double end = std::abs(s.from.x - s.left) > std::abs(s.to.x - s.left) ? s.from.x : s.to.x;
  return lost(s.from.y, s.to.y) + lost(s.left, end);
}

// What evaluating the surface at rounded coordinates does, relative.
double far_uv(const nurbs::NurbsStore& store, std::int32_t face) {
  const Box2& box = store.faces[face].uv_box;
  const dvec2 middle = glm::abs(box.center()), size = box.extent();
  return size.x > 0.0 && size.y > 0.0 ? kUvRounding * std::max(middle.x / size.x, middle.y / size.y) : 0.0;
}

// A part of a strip, by t and by the share of the way from its left border.
struct Part {
  std::size_t strip = 0;
  dvec2 low{0.0}, high{1.0};
  int halvings = 0;
  Integrals value{}, error{};
  double excess = 0.0;  // the largest error as a multiple of what is wanted
};

bool is_before(const Part& a, const Part& b) {
  return std::tie(a.strip, a.low.x, a.low.y) < std::tie(b.strip, b.low.x, b.low.y);
}

class FaceIntegrator {
 public:
  FaceIntegrator(const nurbs::NurbsStore& store, std::int32_t face, dvec3 origin, double reach,
                 const dmat3* cofactor)
      : surface_(store, store.surfaces[store.faces[face].surface]),
        strips_(cut_strips(store, face)),
        origin_(origin),
        cofactor_(cofactor),
        largest_(largest_integrals(reach)),
        rounding_(kRounding * (1.0 + glm::length(origin) / reach) + far_uv(store, face)) {}

  FaceIntegrals run(bool reversed) {
    double area = 0.0, strips = 0.0;
    parts_.resize(strips_.strips.size());
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      parts_[i].strip = i;
      parts_[i].value = rule(parts_[i], 0, 0);
      area += strips_.strips[i].weight * signed_area(parts_[i]);
      strips += std::abs(strips_.strips[i].weight) * parts_[i].value[kArea];
    }
    area_ = std::max(std::abs(area), kSliver * strips);
    for (Part& p : parts_) refine(p, 1);
    const auto less = [](const Part& a, const Part& b) {
      return a.excess != b.excess ? a.excess < b.excess : is_before(a, b);
    };
    std::make_heap(parts_.begin(), parts_.end(), less);
    for (int cuts = 0; cuts < kMostCuts && !parts_.empty() && parts_.front().excess > 1.0; ++cuts) {
      std::pop_heap(parts_.begin(), parts_.end(), less);
      Part a = parts_.back();
      if (a.halvings >= kMostHalvings) {  // a point that stays rough: what is left there is told
        a.excess = 0.0;
        parts_.back() = a;
        std::push_heap(parts_.begin(), parts_.end(), less);
        continue;
      }
      Part b = a;
      const int axis = rougher_axis(a);
      a.high[axis] = b.low[axis] = 0.5 * (a.low[axis] + a.high[axis]);
      ++a.halvings, ++b.halvings;
      for (Part* p : {&a, &b}) p->value = rule(*p, 0, 0), refine(*p, 1);
      parts_.back() = a;
      std::push_heap(parts_.begin(), parts_.end(), less);
      parts_.push_back(b);
      std::push_heap(parts_.begin(), parts_.end(), less);
    }
    return total(reversed);
  }

 private:
  // By a rule along the curve and another across. Area without sign; the strip's weight left out.
  Integrals rule(const Part& part, int along, int across) {
    const Strip& strip = strips_.strips[part.strip];
    const GaussRule ts = gauss_rule(along), xs = gauss_rule(across);
    const dvec2 size = part.high - part.low;
    SurfaceRow row(surface_, strip.inside + strips_.origin);
    Integrals sum{};
    for (std::size_t i = 0; i < ts.node.size(); ++i) {
      const Curve c = curve_at(strips_, strip, part.low.x + size.x * ts.node[i]);
      const double width = c.at.x - strip.left, step = size.x * ts.weight[i] * c.slope.y * width * size.y;
      if (step == 0.0) continue;
      row.set_v(c.at.y + strips_.origin.y);
      for (std::size_t j = 0; j < xs.node.size(); ++j) {
        const nurbs::SurfacePoint p =
            row.at(strip.left + (part.low.y + size.y * xs.node[j]) * width + strips_.origin.x);
        dvec3 normal = glm::cross(p.du, p.dv);
        if (cofactor_ != nullptr) normal = *cofactor_ * normal;
        add_integrand(p.p - origin_, normal, step * xs.weight[j], sum);
      }
    }
    return sum;
  }

  // The area with the sign of dv.
  double signed_area(const Part& part) const {
    const Strip& s = strips_.strips[part.strip];
    return s.to.y < s.from.y ? -part.value[kArea] : part.value[kArea];
  }

  // Raises the rules until two agree.
  void refine(Part& part, int first) {
    for (int r = first; r < kRules; ++r) {
      const Integrals next = rule(part, r, r);
      judge(part, next);
      part.value = next;
      if (part.excess <= 1.0) return;
    }
  }

  void judge(Part& part, const Integrals& next) const {
    part.excess = 0.0;
    const double rounding = rounding_ + uv_rounding(strips_.strips[part.strip]);
    const double share = next[kArea] + area_ / static_cast<double>(strips_.strips.size());
    for (int k = 0; k < kIntegrals; ++k) {
      part.error[k] = std::abs(next[k] - part.value[k]);
      const double allowed =
          largest_[k] * (kWanted * std::min(share, area_) + rounding * next[kArea]) + kTiniest;
      part.excess = std::max(part.excess, part.error[k] / allowed);
      if (!std::isfinite(part.error[k])) part.error[k] = kInf, part.excess = kInf;
    }
  }

  // Along which direction a low rule is worse.
  int rougher_axis(const Part& part) {
    const Integrals along = rule(part, kRules - 2, kRules - 1), across = rule(part, kRules - 1, kRules - 2);
    double worst[2] = {0.0, 0.0};
    for (int k = 0; k < kIntegrals; ++k) {
      worst[0] = std::max(worst[0], std::abs(along[k] - part.value[k]) / largest_[k]);
      worst[1] = std::max(worst[1], std::abs(across[k] - part.value[k]) / largest_[k]);
    }
    return worst[0] >= worst[1] ? 0 : 1;
  }

  FaceIntegrals total(bool reversed) {
    // In an order that heaps do not know.
    std::sort(parts_.begin(), parts_.end(), is_before);
    IntegralSums value, error;
    double lost = 0.0;
    for (const Part& p : parts_) {
      const Strip& strip = strips_.strips[p.strip];
      const double weight = strip.weight;
      Integrals signed_value = p.value;
      signed_value[kArea] = signed_area(p);
      value.add(signed_value, weight);
      error.add(p.error, std::abs(weight));
      lost += std::abs(weight) * p.value[kArea] * (rounding_ + uv_rounding(strip));
    }
    FaceIntegrals r{value.value(), error.value()};
    for (int k = 0; k < kIntegrals; ++k) r.error[k] += largest_[k] * lost;
    if (reversed)
      for (int k = kVolume; k < kIntegrals; ++k) r.value[k] = -r.value[k];
    return r;
  }

  static constexpr double kTiniest = 1e-300;

  SurfacePatches surface_;
  Strips strips_;
  dvec3 origin_;
  const dmat3* cofactor_;
  Integrals largest_;
  double rounding_;
  double area_ = 0.0;
  std::vector<Part> parts_;
};

}  // namespace

FaceIntegrals integrate_face(const nurbs::NurbsStore& store, std::int32_t face, dvec3 origin, double reach,
                             const dmat3* cofactor) {
  return FaceIntegrator(store, face, origin, std::max(reach, 1e-150), cofactor)
      .run(store.faces[face].reversed);
}

}  // namespace trimray::mass
