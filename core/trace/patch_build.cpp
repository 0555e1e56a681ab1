#include "core/trace/patch_build.h"

#include <algorithm>
#include <cmath>

#include "core/nurbs/knot_vector.h"
#include "core/nurbs/spline.h"
#include "core/nurbs/surface.h"
#include "core/trace/patch_cut.h"

namespace trimray::trace {
namespace {

constexpr int kMaxNet = (nurbs::kMaxDegree + 1) * (nurbs::kMaxDegree + 1);

// Control points of the power basis in (x - 1/2) from Bernstein ones, in long double.
void to_power(const dvec4* c, int n, std::ptrdiff_t stride, dvec4* out) {
  long double d[kMaxPowerDegree + 1], result[kMaxPowerDegree + 1];
  for (int k = 0; k < 4; ++k) {
    // Taylor coefficients at 1/2: de Casteljau at 1/2 leaves, on its k-th level, the k-th differences' mean.
    for (int order = 0; order <= n; ++order) {
      for (int i = 0; i <= n; ++i) d[i] = c[i * stride][k];
      for (int r = 0; r < order; ++r)
        for (int i = 0; i + r < n; ++i) d[i] = d[i + 1] - d[i];
      for (int r = order; r < n; ++r)
        for (int i = 0; i + r < n; ++i) d[i] = 0.5L * (d[i] + d[i + 1]);
      long double factor = 1.0L;
      for (int r = 0; r < order; ++r) factor = factor * (n - r) / (r + 1);
      result[order] = factor * d[0];
    }
    for (int i = 0; i <= n; ++i) out[i * stride][k] = static_cast<double>(result[i]);
  }
}

void append_coefficients(const Patch& patch, PatchPool& pool) {
  const int du = patch.degree_u, dv = patch.degree_v, count = (du + 1) * (dv + 1);
  dvec4 points[kMaxNet];
  std::copy_n(pool.net.data() + patch.net, count, points);
  if (patch.power) {
    for (int i = 0; i <= du; ++i) to_power(points + i * (dv + 1), dv, 1, points + i * (dv + 1));
    for (int j = 0; j <= dv; ++j) to_power(points + j, du, dv + 1, points + j);
  }
  for (int k = 0; k < count; ++k)
    for (int c = 0; c < 4; ++c) pool.coef.push_back(points[k][c]);
}

// Sides whose control points all lie at one place.
std::uint8_t collapsed_sides(const dvec4* net, int du, int dv, double size) {
  std::uint8_t sides = 0;
  const auto one_point = [&](int first, int stride, int n) {
    const dvec3 p = nurbs::project(net[first]);
    for (int i = 1; i <= n; ++i)
      if (glm::length(nurbs::project(net[first + i * stride]) - p) > 1e-12 * size) return false;
    return true;
  };
  if (one_point(0, 1, dv)) sides |= kSideU0;
  if (one_point(du * (dv + 1), 1, dv)) sides |= kSideU1;
  if (one_point(0, dv + 1, du)) sides |= kSideV0;
  if (one_point(dv, dv + 1, du)) sides |= kSideV1;
  return sides;
}

// The tree of leaves by cells of equal size, about two a leaf: the leaf that a cell lies in, or the part of
// the tree that cuts it.
void append_leaf_cells(std::int32_t root, std::size_t leaves, Patch& patch, PatchPool& pool) {
  int log = 0;
  while ((std::size_t{1} << log) < 2 * leaves && leaves > 1) ++log;
  const int log_u = log / 2, log_v = log - log_u, count_u = 1 << log_u, count_v = 1 << log_v;
  patch.log_u = static_cast<std::uint8_t>(log_u), patch.log_v = static_cast<std::uint8_t>(log_v);
  patch.cells = static_cast<std::int32_t>(pool.leaf_cells.size());
  for (int i = 0; i < count_u; ++i)
    for (int j = 0; j < count_v; ++j) {
      std::int32_t place = root;
      while (place >= 0) {
        const LeafSplit& split = pool.splits[place];
        const double k = split.in_u ? i : j, count = split.in_u ? count_u : count_v;
        if (k / count < split.at && (k + 1.0) / count > split.at) break;
        place = split.child[k / count >= split.at];
      }
      pool.leaf_cells.push_back(place);
    }
}

// Patch::bend, bend_uu and bend_vv.
void set_bend(Patch& patch, const dvec4* net) {
  const int du = patch.degree_u, dv = patch.degree_v, row = dv + 1;
  const auto size = [&](const dvec4& d) {
    return glm::length(dvec3(d.x, d.y, d.z)) + std::fabs(d.w) * patch.size;
  };
  double uu = 0.0, uv = 0.0, vv = 0.0;
  for (int i = 0; i <= du; ++i)
    for (int j = 0; j <= dv; ++j) {
      const dvec4* p = net + i * row + j;
      if (i + 2 <= du) uu = std::max(uu, size((p[2 * row] - p[row]) - (p[row] - p[0])));
      if (j + 2 <= dv) vv = std::max(vv, size((p[2] - p[1]) - (p[1] - p[0])));
      if (i < du && j < dv) uv = std::max(uv, size((p[row + 1] - p[row]) - (p[1] - p[0])));
    }
  patch.bend_uu = 0.5 * du * (du - 1) * uu, patch.bend_vv = 0.5 * dv * (dv - 1) * vv;
  patch.bend = patch.bend_uu + du * dv * uv + patch.bend_vv;
}

// Diagonal of a surface's control points, mm.
double surface_size(const nurbs::NurbsStore& store, const nurbs::Surface& surface) {
  Box3 hull;
  for (std::int32_t k = surface.ctrl.begin; k < surface.ctrl.end; ++k)
    hull.add(nurbs::project(store.ctrl_h[k]));
  return hull.diagonal();
}

// One direction's spans that meet [lo, hi] of uv_face; the first and last reach beyond the knots if needed.
struct SpanPart {
  int span;
  ParamCurve map;
  double lower;      // uv_face, where it begins
  ParamCurve tight;  // cut back to the knots: where the widened part has a weight that is not positive
};

std::vector<SpanPart> parts_between(std::span<const double> knots, int degree, nurbs::ParamMap map, double lo,
                                    double hi) {
  std::vector<SpanPart> parts;
  const int count = static_cast<int>(knots.size()) - degree - 1;
  int first = degree, last = count - 1;
  while (first < last && !(knots[first] < knots[first + 1])) ++first;
  while (last > first && !(knots[last] < knots[last + 1])) --last;
  for (int k = first; k <= last; ++k) {
    const double a = knots[k], b = knots[k + 1];
    if (!(a < b)) continue;
    const double u0 = k == first ? lo : std::max(a, lo), u1 = k == last ? hi : std::min(b, hi);
    if (!(u0 < u1)) continue;
    const double s0 = nurbs::map_parameter(map, a, b, u0).s, s1 = nurbs::map_parameter(map, a, b, u1).s;
    const double t0 = std::clamp(s0, a, b), t1 = std::clamp(s1, a, b);
    const ParamCurve wide{map, s0, s1 - s0, a, b - a};
    parts.push_back({k, wide, u0, t0 < t1 ? ParamCurve{map, t0, t1 - t0, a, b - a} : wide});
  }
  return parts;
}

// How far uv_box must be widened on its four sides (u0, u1, v0, v1) so that the surface reaches margin_mm
// beyond it. Nothing beyond a side that collapses to a point: the surface would turn back over itself.
struct Margins {
  double side[4] = {0.0, 0.0, 0.0, 0.0};
};

Margins uv_margins(const nurbs::NurbsStore& store, const nurbs::Surface& surface, const Box2& box,
                   double margin_mm) {
  constexpr int kSamples = 9;
  Margins margins;
  // Whether a side collapses is asked of the base: an offset's tangents mean nothing there.
  nurbs::Surface base = surface;
  if (surface.kind == nurbs::SurfaceKind::kOffset)
    base.kind = nurbs::SurfaceKind::kBspline, base.offset = 0.0;
  const double longest[2] = {glm::length(nurbs::evaluate(store, base, box.center()).du),
                             glm::length(nurbs::evaluate(store, base, box.center()).dv)};
  for (int side = 0; side < 4; ++side) {
    const int across = side / 2, along = 1 - across;
    double across_max = 0.0, along_max = 0.0, speed[kSamples];
    for (int k = 0; k < kSamples; ++k) {
      dvec2 uv;
      uv[across] = side % 2 == 0 ? box.lower[across] : box.upper[across];
      uv[along] = glm::mix(box.lower[along], box.upper[along], k / (kSamples - 1.0));
      const nurbs::SurfacePoint p = nurbs::evaluate(store, base, uv);
      speed[k] = glm::length(across == 0 ? p.du : p.dv);
      along_max = std::max(along_max, glm::length(across == 0 ? p.dv : p.du));
      if (surface.kind == nurbs::SurfaceKind::kOffset) {
        const nurbs::SurfacePoint moved = nurbs::evaluate(store, surface, uv);
        const double moved_speed = glm::length(across == 0 ? moved.du : moved.dv);
        if (moved_speed < speed[k]) speed[k] = moved_speed;
      }
      across_max = std::max(across_max, speed[k]);
    }
    if (!(along_max > 1e-9 * longest[along]) || !(across_max > 0.0)) continue;
    double slowest = across_max;
    for (double v : speed)
      if (v > 1e-3 * across_max) slowest = std::min(slowest, v);
    const double width = box.upper[across] - box.lower[across];
    margins.side[side] = std::min(margin_mm / slowest + 1e-9 * width, width);
  }
  return margins;
}

// The Bezier pieces of one surface.
class SpanCutter {
 public:
  SpanCutter(const nurbs::NurbsStore& store, const nurbs::Surface& surface)
      : surface_(surface),
        du_(surface.degree_u),
        dv_(surface.degree_v),
        knots_u_(store.knots.data() + surface.knots_u.begin, surface.knots_u.size()),
        knots_v_(store.knots.data() + surface.knots_v.begin, surface.knots_v.size()),
        ctrl_(store.ctrl_h.data() + surface.ctrl.begin),
        rows_(static_cast<std::size_t>(du_ + 1) * surface.count_v) {}

  std::span<const double> knots_u() const { return knots_u_; }
  std::span<const double> knots_v() const { return knots_v_; }

  // The rows of control points over one part in u, for the pieces to come.
  void choose_u(int span, const ParamCurve& map) {
    for (int i = 0; i <= du_; ++i) {
      arguments(map, du_, i);
      for (int j = 0; j < surface_.count_v; ++j)
        rows_[i * surface_.count_v + j] =
            nurbs::blossom(knots_u_.data(), du_, span, ctrl_ + j, surface_.count_v, x_);
    }
  }

  const dvec4* piece(int span, const ParamCurve& map) {
    for (int j = 0; j <= dv_; ++j) {
      arguments(map, dv_, j);
      for (int i = 0; i <= du_; ++i)
        net_[i * (dv_ + 1) + j] =
            nurbs::blossom(knots_v_.data(), dv_, span, rows_.data() + i * surface_.count_v, 1, x_);
    }
    return net_;
  }

 private:
  void arguments(const ParamCurve& map, int degree, int i) {
    for (int k = 0; k < degree; ++k) x_[k] = k < degree - i ? map.s0 : map.s0 + map.ds;
  }

  const nurbs::Surface& surface_;
  const int du_, dv_;
  const std::span<const double> knots_u_, knots_v_;
  const dvec4* const ctrl_;
  std::vector<dvec4> rows_;
  double x_[nurbs::kMaxDegree];
  dvec4 net_[kMaxNet];
};

// Cells whose patch is missing take the one before them, the first ones the one behind.
void fill_gaps(std::span<std::int32_t> cells) {
  std::int32_t last = -1;
  for (std::int32_t& cell : cells) last = cell = cell < 0 ? last : cell;
  for (std::size_t k = cells.size(); k-- > 0;) last = cells[k] = cells[k] < 0 ? last : cells[k];
}

void append_spans(const nurbs::NurbsStore& store, std::int32_t face, const Box2& box,
                  const LeafDetail& detail, PatchPool& pool) {
  const nurbs::Face& f = store.faces[face];
  const nurbs::Surface& surface = store.surfaces[f.surface];
  SpanCutter cutter(store, surface);
  const auto parts_u =
      parts_between(cutter.knots_u(), surface.degree_u, surface.map_u, box.lower.x, box.upper.x);
  const auto parts_v =
      parts_between(cutter.knots_v(), surface.degree_v, surface.map_v, box.lower.y, box.upper.y);
  PatchGrid grid{static_cast<std::int32_t>(parts_u.size()), static_cast<std::int32_t>(parts_v.size()),
                 static_cast<std::int64_t>(pool.breaks.size()), static_cast<std::int64_t>(pool.cells.size())};
  for (const auto* parts : {&parts_u, &parts_v})
    for (std::size_t k = 1; k < parts->size(); ++k) pool.breaks.push_back((*parts)[k].lower);
  const double flat_mm = detail.flatness < kInf ? detail.flatness * surface_size(store, surface) : kInf;
  // Offsets have no search in lanes for what the proof leaves open.
  const double sine = surface.offset == 0.0 ? detail.sine : std::min(detail.sine, LeafDetail{}.sine);
  const auto share = [&](const std::vector<SpanPart>& parts) {
    const int count = static_cast<int>(parts.size());
    return (detail.parts + count - 1) / count;
  };
  for (const SpanPart& pu : parts_u) {
    cutter.choose_u(pu.span, pu.map);
    for (const SpanPart& pv : parts_v) {
      const auto append = [&](const ParamCurve& u, const ParamCurve& v) {
        return append_patch({face, surface.degree_u, surface.degree_v, cutter.piece(pv.span, v),
                             surface.offset, f.reversed, u, v, share(parts_u), share(parts_v), flat_mm, sine},
                            pool);
      };
      pool.cells.push_back(static_cast<std::int32_t>(pool.patches.size()));
      if (append(pu.map, pv.map)) continue;
      // Weights may turn negative beyond the knots: then without the margin, first in one direction.
      bool done = append(pu.map, pv.tight);
      if (!done) {
        cutter.choose_u(pu.span, pu.tight);
        done = append(pu.tight, pv.map) || append(pu.tight, pv.tight);
        cutter.choose_u(pu.span, pu.map);
      }
      if (!done) ++pool.refused, pool.cells.back() = -1;
    }
  }
  fill_gaps(std::span(pool.cells).subspan(grid.cells));
  pool.grids.push_back(grid);
}

}  // namespace

void append_face(const nurbs::NurbsStore& store, std::int32_t face, double margin_mm,
                 const LeafDetail& detail, PatchPool& pool) {
  const nurbs::Face& f = store.faces[face];
  if (f.status != nurbs::FaceStatus::kOk || f.surface < 0 || f.uv_box.empty()) return;
  const nurbs::Surface& surface = store.surfaces[f.surface];
  if (surface.degree_u < 1 || surface.degree_v < 1 || surface.degree_u > nurbs::kMaxDegree ||
      surface.degree_v > nurbs::kMaxDegree)
    return;
  const Margins m = uv_margins(store, surface, f.uv_box, margin_mm);
  Box2 box = f.uv_box;
  box.lower -= dvec2(m.side[0], m.side[2]);
  box.upper += dvec2(m.side[1], m.side[3]);
  const std::size_t first = pool.patches.size();
  append_spans(store, face, box, detail, pool);
  double size = 0.0;
  for (std::size_t k = first; k < pool.patches.size(); ++k) size = std::max(size, pool.patches[k].size);
  for (std::size_t k = first; k < pool.patches.size(); ++k) pool.patches[k].pole_reach = kPoleReach * size;
}

void append_pool(const PatchPool& b, PatchPool& a) {
  const auto net = static_cast<std::int64_t>(a.net.size()), coef = static_cast<std::int64_t>(a.coef.size());
  const auto patch = static_cast<std::int32_t>(a.patches.size());
  const auto leaf = static_cast<std::int32_t>(a.leaves.size());
  const auto splits = static_cast<std::int32_t>(a.splits.size());
  const auto cells = static_cast<std::int32_t>(a.leaf_cells.size());
  const auto moved = [&](std::int32_t child) { return child >= 0 ? child + splits : child - leaf; };
  for (Patch p : b.patches) {
    p.net += net, p.coef += coef, p.cells += cells;
    a.patches.push_back(p);
  }
  for (const std::int32_t cell : b.leaf_cells) a.leaf_cells.push_back(moved(cell));
  for (const LeafSplit& s : b.splits)
    a.splits.push_back({s.at, s.in_u, {moved(s.child[0]), moved(s.child[1])}});
  for (PatchGrid g : b.grids) {
    g.breaks += static_cast<std::int64_t>(a.breaks.size());
    g.cells += static_cast<std::int64_t>(a.cells.size());
    a.grids.push_back(g);
  }
  a.breaks.insert(a.breaks.end(), b.breaks.begin(), b.breaks.end());
  for (const std::int32_t cell : b.cells) a.cells.push_back(cell < 0 ? cell : cell + patch);
  for (PatchLeaf l : b.leaves) {
    l.patch += patch, l.sub += leaf;
    a.leaves.push_back(l);
  }
  a.net.insert(a.net.end(), b.net.begin(), b.net.end());
  a.coef.insert(a.coef.end(), b.coef.begin(), b.coef.end());
  a.bounds.insert(a.bounds.end(), b.bounds.begin(), b.bounds.end());
  a.refused += b.refused;
}

double ParamCurve::to_face(double x) const {
  const double s = std::fma(x, ds, s0);
  return map == nurbs::ParamMap::kIdentity ? s : nurbs::unmap_parameter(map, a, a + d, s);
}

double ParamCurve::from_face(double u) const {
  const double s = map == nurbs::ParamMap::kIdentity ? u : nurbs::map_parameter(map, a, a + d, u).s;
  return (s - s0) / ds;
}

bool append_patch(const PatchInput& input, PatchPool& pool) {
  const int du = input.degree_u, dv = input.degree_v, count = (du + 1) * (dv + 1);
  Box3 hull;
  double w0 = input.net[0].w;
  Patch patch;
  for (int k = 0; k < count; ++k) {
    if (!(input.net[k].w > 0.0)) return false;
    hull.add(nurbs::project(input.net[k]));
    patch.rational = patch.rational || input.net[k].w != w0;
  }
  patch.face = input.face;
  patch.degree_u = static_cast<std::uint8_t>(du), patch.degree_v = static_cast<std::uint8_t>(dv);
  patch.power = du <= kMaxPowerDegree && dv <= kMaxPowerDegree;
  patch.reversed = input.reversed, patch.offset = input.offset;
  patch.size = hull.diagonal(), patch.origin = hull.center();
  patch.u = input.u, patch.v = input.v;
  patch.net = static_cast<std::int64_t>(pool.net.size());
  patch.coef = static_cast<std::int64_t>(pool.coef.size());
  for (int k = 0; k < count; ++k) {
    const dvec4 h = input.net[k] / w0;
    const dvec3 p = nurbs::project(input.net[k]) - patch.origin;
    pool.net.push_back(dvec4(p * h.w, h.w));
    patch.max_weight = std::max(patch.max_weight, h.w);
  }
  patch.poles = collapsed_sides(pool.net.data() + patch.net, du, dv, patch.size);
  set_bend(patch, pool.net.data() + patch.net);
  append_coefficients(patch, pool);
  const auto index = static_cast<std::int32_t>(pool.patches.size());
  pool.patches.push_back(patch);
  const std::size_t first = pool.leaves.size();
  const std::int32_t root = cut_patch(index, input, pool);
  append_leaf_cells(root, pool.leaves.size() - first, pool.patches[index], pool);
  return true;
}

}  // namespace trimray::trace
