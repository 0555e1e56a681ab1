#include "core/reference/trim.h"

#include <algorithm>
#include <cmath>

#include "core/reference/winding.h"

namespace trimray::reference {
namespace {

dvec2 affine(const dvec3& h) { return dvec2(h) / h.z; }

// Twice the area between a curve and an axis: the integral of u dv - v du in parts, sampled.
void add_area(const std::vector<dvec3>& curve, double& u_dv, double& v_du) {
  constexpr int kSamples = 32;
  dvec2 last = affine(curve.front());
  for (int k = 1; k <= kSamples; ++k) {
    std::vector<dvec3> c = curve;
    const double t = double(k) / kSamples;
    for (std::size_t r = 1; r < curve.size(); ++r)
      for (std::size_t i = 0; i + r < curve.size(); ++i) c[i] = (1.0 - t) * c[i] + t * c[i + 1];
    const dvec2 here = affine(c[0]);
    u_dv += 0.5 * (here.x + last.x) * (here.y - last.y);
    v_du += 0.5 * (here.y + last.y) * (here.x - last.x);
    last = here;
  }
}

}  // namespace

TrimLoops::TrimLoops(const nurbs::NurbsStore& store, std::int32_t face) {
  const nurbs::Face& f = store.faces[face];
  const nurbs::Surface& s = store.surfaces[f.surface];
  box_ = f.uv_box;
  rectangle_ = f.iso_rectangle || f.loops.size() == 0;
  if (s.periodic_u) period_.x = s.period_u;
  if (s.periodic_v) period_.y = s.period_v;
  bool around_v = false;
  for (std::int32_t l = f.loops.begin; l < f.loops.end; ++l) {
    std::vector<std::vector<dvec3>> loop;
    const nurbs::Range coedges = store.loops[l].coedges;
    bool poles = coedges.size() > 0;
    for (std::int32_t c = coedges.begin; c < coedges.end; ++c)
      poles = poles && store.edges[store.coedges[c].edge].degenerate;
    copied_ = copied_ || poles;
    for (std::int32_t c = coedges.begin; c < coedges.end; ++c) {
      const nurbs::Range pieces = store.coedges[c].pieces;
      for (std::int32_t k = pieces.begin; k < pieces.end; ++k) {
        const nurbs::Range ctrl = store.trim_pieces[k].ctrl;
        loop.emplace_back(store.trim_ctrl_h.begin() + ctrl.begin, store.trim_ctrl_h.begin() + ctrl.end);
      }
    }
    const std::size_t count = loop.size();
    for (std::size_t k = 0; k < count; ++k) {
      const dvec3 from = loop[k].back(), to = loop[(k + 1) % count].front();
      const dvec2 jump = glm::abs(affine(to) - affine(from));
      const bool jump_u = period_.x > 0.0 && jump.x > 0.5 * period_.x;
      const bool jump_v = period_.y > 0.0 && jump.y > 0.5 * period_.y;
      upward_ = upward_ || jump_u, around_v = around_v || jump_v;
      if (!jump_u && !jump_v) loop.push_back({from, to});
    }
    for (std::vector<dvec3>& curve : loop) curves_.push_back(std::move(curve));
  }
  double u_dv = 0.0, v_du = 0.0;
  for (const std::vector<dvec3>& curve : curves_) add_area(curve, u_dv, v_du);
  const double area = upward_ ? -v_du : around_v ? u_dv : u_dv - v_du;
  orientation_ = area < 0.0 ? -1 : 1;
}

int TrimLoops::crossings(dvec2 uv) const {
  int sum = 0;
  std::vector<dvec2> c;
  for (const std::vector<dvec3>& curve : curves_) {
    c.clear();
    for (const dvec3& h : curve) {
      const dvec2 d = dvec2(h) - h.z * uv;
      c.push_back(upward_ ? dvec2(d.y, d.x) : d);
    }
    sum += half_line_crossings(c);
  }
  return sum;
}

bool TrimLoops::inside(dvec2 uv) const {
  int sum = 0;
  bool in_box = false;
  for (int ku = period_.x > 0.0 ? -1 : 0; ku <= (period_.x > 0.0 ? 1 : 0); ++ku)
    for (int kv = period_.y > 0.0 ? -1 : 0; kv <= (period_.y > 0.0 ? 1 : 0); ++kv) {
      const dvec2 image = uv + dvec2(ku, kv) * period_;
      const bool here = box_.contains(image);
      if (!rectangle_ && (!copied_ || (here && !in_box))) sum += crossings(image);
      in_box = in_box || here;
    }
  return rectangle_ ? in_box : sum % 2 != 0;
}

}  // namespace trimray::reference
