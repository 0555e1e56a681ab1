#include "core/nurbs/bounds.h"

#include <cmath>

#include "core/base/parallel.h"
#include "core/nurbs/bezier.h"
#include "core/nurbs/curve_form.h"

namespace trimray::nurbs {
namespace {

constexpr int kMaxHalvings = 40;
constexpr int kMaxParts = 4000;  // a face; what is left then counts with its control hull
constexpr int kOffsetGrid = 48;

bool within(const Box3& box, const Box3& part, double margin) {
  for (int i = 0; i < 3; ++i)
    if (part.lower[i] < box.lower[i] - margin || part.upper[i] > box.upper[i] + margin) return false;
  return true;
}

void halve(const dvec4* ctrl, std::ptrdiff_t stride, int degree, dvec4* left, dvec4* right,
           std::ptrdiff_t out_stride) {
  dvec4 d[kMaxDegree + 1];
  for (int i = 0; i <= degree; ++i) d[i] = ctrl[i * stride];
  for (int i = 0; i <= degree; ++i) {
    left[i * out_stride] = d[0];
    right[(degree - i) * out_stride] = d[degree - i];
    for (int k = 0; k + i < degree; ++k) d[k] = 0.5 * (d[k] + d[k + 1]);
  }
}

Box3 hull_of(std::span<const dvec4> ctrl) {
  Box3 box;
  for (const dvec4& h : ctrl) box.add(project(h));
  return box;
}

// Grows a box by a face: halves whatever may still reach out of the box of the points met so far.
class FaceBox {
 public:
  FaceBox(const NurbsStore& store, const TrimIndex& trims, std::int32_t face, const Transform& placement)
      : store_(store),
        trims_(trims),
        index_(face),
        face_(store.faces[face]),
        surface_(store.surfaces[face_.surface]),
        placement_(placement) {}

  Box3 run() {
    if (face_.status != FaceStatus::kOk) return {};
    if (face_.is_mesh()) return corners();
    BezierPatches patches = bezier_patches(store_, surface_);
    transform_ctrl(patches.ctrl_h, placement_);
    margin_ = kBoundsTol * hull_of(patches.ctrl_h).diagonal();
    edges();
    if (face_.loops.size() == 0) sides();
    if (surface_.kind == SurfaceKind::kOffset)
      samples();
    else if (surface_.kind != SurfaceKind::kPlane)  // a plane is the hull of its boundary
      for (std::size_t k = 0; k < patches.uv_face.size(); ++k) {
        const auto first = patches.ctrl_h.begin() + static_cast<std::ptrdiff_t>(k) * patches.points();
        patch({first, first + patches.points()}, patches.uv_face[k], 0);
      }
    return box_;
  }

 private:
  Box3 corners() {
    for (std::int32_t t = face_.triangles.begin; t < face_.triangles.end; ++t)
      for (const std::int32_t v : store_.mesh_triangles[t])
        box_.add(placement_.point(store_.mesh_vertices[v]));
    return box_;
  }

  void edges() {
    for (std::int32_t l = face_.loops.begin; l < face_.loops.end; ++l)
      for (std::int32_t c = store_.loops[l].coedges.begin; c < store_.loops[l].coedges.end; ++c) {
        const Edge& e = store_.edges[store_.coedges[c].edge];
        for (const std::int32_t v : e.vertex)
          if (!e.degenerate) box_.add(placement_.point(store_.vertices[v].point));
        for (std::int32_t p = e.pieces.begin; p < e.pieces.end; ++p) {
          const Range& r = store_.edge_pieces[p].ctrl;
          std::vector<dvec4> ctrl(store_.edge_ctrl_h.begin() + r.begin, store_.edge_ctrl_h.begin() + r.end);
          transform_ctrl(ctrl, placement_);
          curve(ctrl, 0);
        }
      }
  }

  // Without loops the boundary is the natural domain's.
  void sides() {
    const SurfaceView s = view(store_, surface_);
    for (int k = 0; k < 4; ++k) {
      const bool fixed_u = k < 2;
      const dvec2 end = k % 2 == 0 ? face_.uv_box.lower : face_.uv_box.upper;
      SplineCurve<dvec4> iso = iso_curve(s, fixed_u, fixed_u ? end.x : end.y);
      if (iso.map == ParamMap::kIdentity)
        iso = fixed_u ? respan_curve(iso, face_.uv_box.lower.y, face_.uv_box.upper.y)
                      : respan_curve(iso, face_.uv_box.lower.x, face_.uv_box.upper.x);
      transform_ctrl(iso.ctrl, placement_);
      const Pieces3 pieces = pieces_of(iso);
      for (const CurvePiece& p : pieces.list)
        curve({pieces.ctrl.begin() + p.ctrl.begin, pieces.ctrl.begin() + p.ctrl.end}, 0);
    }
  }

  void curve(const std::vector<dvec4>& ctrl, int depth) {
    box_.add(project(ctrl.front())), box_.add(project(ctrl.back()));
    if (depth == kMaxHalvings || within(box_, hull_of(ctrl), margin_)) return;
    std::vector<dvec4> left(ctrl.size()), right(ctrl.size());
    halve(ctrl.data(), 1, static_cast<int>(ctrl.size()) - 1, left.data(), right.data(), 1);
    curve(left, depth + 1);
    curve(right, depth + 1);
  }

  bool inside(dvec2 uv) const {
    const Box2& b = face_.uv_box;
    return b.contains(uv) && (face_.iso_rectangle || trims_.inside(index_, uv));
  }

  double middle(const Range& knots, ParamMap map, double a, double b) const {
    return face_from_nurbs(
        store_, knots, map,
        0.5 * (nurbs_from_face(store_, knots, map, a) + nurbs_from_face(store_, knots, map, b)));
  }

  // ctrl: (degree_u + 1) x (degree_v + 1); uv: what it covers.
  void patch(std::vector<dvec4> ctrl, const Box2& uv, int depth) {
    const Box2& need = face_.uv_box;
    if (uv.lower.x > need.upper.x || uv.lower.y > need.upper.y || uv.upper.x < need.lower.x ||
        uv.upper.y < need.lower.y)
      return;
    const int pv = surface_.degree_v + 1, pu = surface_.degree_u + 1;
    const Box3 hull = hull_of(ctrl);
    if (!can_grow(ctrl, hull)) return;
    if (!face_.iso_rectangle && depth > 0 && trims_.coverage(index_, uv) == Coverage::kOutside) return;
    for (const int i : {0, pu - 1})
      for (const int j : {0, pv - 1})
        if (inside({i ? uv.upper.x : uv.lower.x, j ? uv.upper.y : uv.lower.y}))
          box_.add(project(ctrl[i * pv + j]));
    if (!can_grow(ctrl, hull)) return;
    if (depth == kMaxHalvings || ++parts_ > kMaxParts) return box_.add(hull);
    // Halve across the direction that bends or spans more.
    double along_u = 0.0, along_v = 0.0;
    for (int j = 0; j < pv; ++j) along_u = std::max(along_u, bend(&ctrl[j], pv, pu));
    for (int i = 0; i < pu; ++i) along_v = std::max(along_v, bend(&ctrl[i * pv], 1, pv));
    const bool split_u = along_u != along_v ? along_u > along_v : depth % 2 == 0;
    std::vector<dvec4> low(ctrl.size()), high(ctrl.size());
    Box2 uv_low = uv, uv_high = uv;
    if (split_u) {
      for (int j = 0; j < pv; ++j) halve(&ctrl[j], pv, pu - 1, &low[j], &high[j], pv);
      uv_low.upper.x = uv_high.lower.x = middle(surface_.knots_u, surface_.map_u, uv.lower.x, uv.upper.x);
    } else {
      for (int i = 0; i < pu; ++i) halve(&ctrl[i * pv], 1, pv - 1, &low[i * pv], &high[i * pv], 1);
      uv_low.upper.y = uv_high.lower.y = middle(surface_.knots_v, surface_.map_v, uv.lower.y, uv.upper.y);
    }
    patch(std::move(low), uv_low, depth + 1);
    patch(std::move(high), uv_high, depth + 1);
  }

  // May a point inside the part, away from the face's boundary, lie beyond the box? Only along an axis whose
  // coordinate is not monotone in u or in v.
  bool can_grow(const std::vector<dvec4>& ctrl, const Box3& hull) const {
    for (int axis = 0; axis < 3; ++axis) {
      const bool out =
          hull.lower[axis] < box_.lower[axis] - margin_ || hull.upper[axis] > box_.upper[axis] + margin_;
      if (out && !monotone(ctrl, hull, axis, true) && !monotone(ctrl, hull, axis, false)) return true;
    }
    return false;
  }

  // With g = N - c w the derivative of N / w has the sign of g' - (g / w) w', and |g / w| is at most half the
  // hull.
  bool monotone(const std::vector<dvec4>& ctrl, const Box3& hull, int axis, bool along_u) const {
    const int pv = surface_.degree_v + 1, pu = surface_.degree_u + 1;
    const double c = hull.center()[axis], half = 0.5 * hull.extent()[axis];
    double least = kInf, most = -kInf, weight = 0.0;
    for (int i = 0; i + (along_u ? 1 : 0) < pu; ++i)
      for (int j = 0; j + (along_u ? 0 : 1) < pv; ++j) {
        const dvec4 d = ctrl[(i + (along_u ? 1 : 0)) * pv + j + (along_u ? 0 : 1)] - ctrl[i * pv + j];
        const double g = d[axis] - c * d.w;
        least = std::min(least, g), most = std::max(most, g), weight = std::max(weight, std::abs(d.w));
      }
    return least > half * weight || most < -half * weight;
  }

  // How far a row of control points is from its chord; a straight row that sticks out counts a little.
  static double bend(const dvec4* row, std::ptrdiff_t stride, int count) {
    const dvec3 a = project(row[0]), b = project(row[(count - 1) * stride]);
    double worst = 1e-3 * glm::distance(a, b);
    for (int i = 1; i + 1 < count; ++i)
      worst =
          std::max(worst, glm::distance(project(row[i * stride]), a + (b - a) * (double(i) / (count - 1))));
    return worst;
  }

  void samples() {
    const SurfaceView s = view(store_, surface_);
    for (int i = 0; i <= kOffsetGrid; ++i)
      for (int j = 0; j <= kOffsetGrid; ++j) {
        const dvec2 uv = face_.uv_box.lower + face_.uv_box.extent() * dvec2(i, j) / double(kOffsetGrid);
        if (inside(uv)) box_.add(placement_.point(evaluate_point(s, uv)));
      }
  }

  const NurbsStore& store_;
  const TrimIndex& trims_;
  std::int32_t index_;
  const Face& face_;
  const Surface& surface_;
  const Transform& placement_;
  double margin_ = 0.0;
  int parts_ = 0;
  Box3 box_;
};

}  // namespace

Box3 hull_bounds(const SurfaceView& view, const Box2& uv_face) {
  const Surface& f = *view.surface;
  const auto mapped = [](std::span<const double> knots, int degree, ParamMap map, double u) {
    const int span = find_span(knots, degree, u);
    return map_parameter(map, knots[span], knots[span + 1], u).s;
  };
  const Respan u =
      plan_respan(view.knots_u, f.degree_u, mapped(view.knots_u, f.degree_u, f.map_u, uv_face.lower.x),
                  mapped(view.knots_u, f.degree_u, f.map_u, uv_face.upper.x));
  const Respan v =
      plan_respan(view.knots_v, f.degree_v, mapped(view.knots_v, f.degree_v, f.map_v, uv_face.lower.y),
                  mapped(view.knots_v, f.degree_v, f.map_v, uv_face.upper.y));
  std::vector<dvec4> rows(static_cast<std::size_t>(f.count_u) * v.count()), column(u.count());
  for (int i = 0; i < f.count_u; ++i)
    apply_respan(v, view.knots_v, f.degree_v, view.ctrl_h + std::ptrdiff_t(i) * f.count_v, 1,
                 &rows[std::size_t(i) * v.count()], 1);
  Box3 box;
  for (int j = 0; j < v.count(); ++j) {
    apply_respan(u, view.knots_u, f.degree_u, &rows[j], v.count(), column.data(), 1);
    for (const dvec4& h : column) box.add(project(h));
  }
  if (box.empty()) return box;
  // Rounding of the insertion, a few ulps of the coordinates.
  const double reach = glm::length(glm::max(glm::abs(box.lower), glm::abs(box.upper)));
  box.dilate(std::abs(f.offset) + 1e-14 * reach);
  return box;
}

Box3 face_bounds(const NurbsStore& store, const TrimIndex& trims, std::int32_t face,
                 const Transform& placement) {
  return FaceBox(store, trims, face, placement).run();
}

Box3 model_bounds(const NurbsStore& store, const TrimIndex& trims, int threads) {
  struct Item {
    std::int32_t face, instance;
  };
  std::vector<Item> items;
  for (std::size_t n = 0; n < store.instances.size(); ++n) {
    const Range& faces = store.prototypes[store.instances[n].prototype].faces;
    for (std::int32_t f = faces.begin; f < faces.end; ++f) items.push_back({f, static_cast<std::int32_t>(n)});
  }
  std::vector<Box3> boxes(items.size());
  parallel_ranges(items.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      boxes[i] = face_bounds(store, trims, items[i].face, store.instances[items[i].instance].placement);
  });
  Box3 all;
  for (const Box3& b : boxes) all.add(b);
  return all;
}

}  // namespace trimray::nurbs
