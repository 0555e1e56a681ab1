#include "core/reference/face.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/reference/fit.h"
#include "core/reference/roots.h"

namespace trimray::reference {
namespace {

constexpr double kExtendMost = 0.02;  // of the uv_box: beyond it an extrapolated spline means nothing
constexpr int kMaxOffsetDepth = 6;
constexpr double kSame = 1e-10;    // of the face's size: crossings of one direction so close are one
constexpr double kFitTol = 1e-10;  // of the face's size, approximation of offset surfaces

Vec3 affine(const Vec4& h) { return Vec3(h) / h.w; }

// Piece of the whole region around one parameter pair, for measuring only.
PatchPoint probe(const nurbs::NurbsStore& store, const nurbs::Surface& s, double su, double sv,
                 const Vec3& origin) {
  const std::span<const double> ku(&store.knots[s.knots_u.begin], s.knots_u.size());
  const std::span<const double> kv(&store.knots[s.knots_v.begin], s.knots_v.size());
  const std::vector<Span> us = spans_over(ku, s.degree_u, -1e300, 1e300),
                          vs = spans_over(kv, s.degree_v, -1e300, 1e300);
  auto pick = [](std::vector<Span> spans, std::span<const double> knots, double x) {
    Span best = spans.front();
    for (const Span& span : spans)
      if (x >= knots[span.index]) best = span;
    best.lower = knots[best.index], best.upper = knots[best.index + 1];
    return best;
  };
  const Span u = pick(us, ku, su), v = pick(vs, kv, sv);
  return evaluate(extract(store, s, u, v, origin), (su - u.lower) / (u.upper - u.lower),
                  (sv - v.lower) / (v.upper - v.lower));
}

// How far the region reaches beyond one side of the uv_box, so that margin mm are covered there. A side
// that is one point (pole, apex) ends the surface.
double extension(const nurbs::NurbsStore& store, const nurbs::Surface& s, const Box2& box, int axis,
                 bool upper, double margin, double size, const Vec3& origin) {
  const std::span<const double> ku(&store.knots[s.knots_u.begin], s.knots_u.size());
  const std::span<const double> kv(&store.knots[s.knots_v.begin], s.knots_v.size());
  const double width = box.upper[axis] - box.lower[axis];
  constexpr int kSamples = 8;
  double slowest = kInf, spread = 0.0;
  Vec3 first(0);
  for (int k = 0; k <= kSamples; ++k) {
    auto at = [&](double along) {
      dvec2 uv = box.lower + (box.upper - box.lower) * (double(k) / kSamples);
      uv[axis] = along;
      return affine(probe(store, s, to_nurbs(ku, s.map_u, uv.x), to_nurbs(kv, s.map_v, uv.y), origin).h);
    };
    const double end = upper ? box.upper[axis] : box.lower[axis], step = 1e-3 * width * (upper ? -1.0 : 1.0);
    const Vec3 rim = at(end);
    if (k == 0) first = rim;
    spread = std::max(spread, double(glm::length(rim - first)));
    slowest = std::min(slowest, double(glm::length(rim - at(end + step))) / std::abs(step));
  }
  if (spread <= 1e-9 * size) return 0.0;
  return std::min(kExtendMost * width, margin / std::max(slowest, 1e-300));
}

Box2 search_region(const nurbs::NurbsStore& store, const nurbs::Face& face, const nurbs::Surface& s,
                   double margin, double size, const Vec3& origin) {
  Box2 box = face.uv_box;
  const bool periodic[2] = {s.periodic_u, s.periodic_v};
  const double period[2] = {s.period_u, s.period_v};
  const Box2 trims = box;
  for (int axis = 0; axis < 2; ++axis) {
    box.lower[axis] -= extension(store, s, trims, axis, false, margin, size, origin);
    box.upper[axis] += extension(store, s, trims, axis, true, margin, size, origin);
    if (periodic[axis] && box.upper[axis] - box.lower[axis] > period[axis]) {
      const double middle = 0.5 * (trims.lower[axis] + trims.upper[axis]);
      box.lower[axis] = middle - 0.5 * period[axis], box.upper[axis] = middle + 0.5 * period[axis];
    }
  }
  // Latitudes end at the poles.
  if (s.kind == nurbs::SurfaceKind::kSphere) {
    box.lower.y = std::max(box.lower.y, -0.5 * std::numbers::pi);
    box.upper.y = std::min(box.upper.y, 0.5 * std::numbers::pi);
  }
  return box;
}

}  // namespace

Box3 rough_box(const nurbs::NurbsStore& store, std::int32_t face, double margin) {
  const nurbs::Surface& s = store.surfaces[store.faces[face].surface];
  Box3 box;
  for (std::int32_t k = s.ctrl.begin; k < s.ctrl.end; ++k)
    if (store.ctrl_h[k].w > 0.0) box.add(dvec3(store.ctrl_h[k]) / store.ctrl_h[k].w);
  box.dilate(2.0 * margin + std::abs(s.offset) + kExtendMost * 4.0 * box.diagonal());
  return box;
}

FaceModel::FaceModel(const nurbs::NurbsStore& store, std::int32_t face, double margin)
    : face_(face), trims_(store, face) {
  const nurbs::Face& f = store.faces[face];
  const nurbs::Surface& s = store.surfaces[f.surface];
  reversed_ = f.reversed, offset_ = s.offset, map_u_ = s.map_u, map_v_ = s.map_v;
  knots_u_.assign(store.knots.begin() + s.knots_u.begin, store.knots.begin() + s.knots_u.end);
  knots_v_.assign(store.knots.begin() + s.knots_v.begin, store.knots.begin() + s.knots_v.end);
  if (s.periodic_u) period_.x = s.period_u;
  if (s.periodic_v) period_.y = s.period_v;
  middle_ = f.uv_box.center(), range_ = f.uv_box.extent();
  Box3 hull;
  for (std::int32_t k = s.ctrl.begin; k < s.ctrl.end; ++k)
    if (store.ctrl_h[k].w > 0.0) hull.add(dvec3(store.ctrl_h[k]) / store.ctrl_h[k].w);
  if (hull.empty() || f.uv_box.empty()) return;
  origin_ = Vec3(hull.center());
  size_ = hull.diagonal();

  const Box2 region = search_region(store, f, s, margin, size_, origin_);
  const std::vector<Span> us = spans_over(knots_u_, s.degree_u, to_nurbs(knots_u_, map_u_, region.lower.x),
                                          to_nurbs(knots_u_, map_u_, region.upper.x));
  const std::vector<Span> vs = spans_over(knots_v_, s.degree_v, to_nurbs(knots_v_, map_v_, region.lower.y),
                                          to_nurbs(knots_v_, map_v_, region.upper.y));
  for (const Span& u : us)
    for (const Span& v : vs) {
      Patch patch = extract(store, s, u, v, origin_);
      if (offset_ == 0.0) {
        pieces_.push_back({std::move(patch), {}, -1});
      } else {
        base_.push_back(std::move(patch));
        add_offset_pieces(base_.back(), static_cast<int>(base_.size()) - 1, {dvec2(0.0), dvec2(1.0)}, 0);
      }
    }
  for (Piece& piece : pieces_) {
    for (const Vec4& h : piece.shape.ctrl) {
      if (h.w > 0)
        piece.box.add(dvec3(affine(h)));
      else
        piece.box = {dvec3(-1e30), dvec3(1e30)};
    }
    piece.box.dilate(1e-9 * size_);
    box_.add(piece.box);
  }
  box_.lower += dvec3(origin_), box_.upper += dvec3(origin_);
}

Vec3 FaceModel::offset_point(const Patch& patch, Real x, Real y) const {
  struct Base {
    Vec3 p, normal;
    Real length;
  };
  auto base = [&](Real u, Real v) {
    const PatchPoint e = evaluate(patch, u, v);
    Base b;
    b.p = affine(e.h);
    b.normal =
        glm::cross(Vec3(e.hx) - b.p * e.hx.w, Vec3(e.hy) - b.p * e.hy.w) * (e.h.w > 0 ? Real(1) : Real(-1));
    b.length = glm::length(b.normal);
    return b;
  };
  const Base here = base(x, y);
  if (here.length > 1e-10 * size_ * size_) return here.p + Real(offset_) / here.length * here.normal;

  // On a collapsed side the normal is a limit: extrapolated (error of third order) from three points inside.
  const Real h = 1e-4L, dx = x < 0.5L ? h : -h, dy = y < 0.5L ? h : -h;
  auto unit = [&](int k) {
    const Base b = base(x + k * dx, y + k * dy);
    return b.length > 0 ? b.normal / b.length : Vec3(0);
  };
  return here.p + Real(offset_) * glm::normalize(Real(3) * unit(1) - Real(3) * unit(2) + unit(3));
}

void FaceModel::add_offset_pieces(const Patch& patch, int base, Box2 part, int depth) {
  auto shape_of = [&](const Box2& b) {
    return [this, &patch, b](Real x, Real y) {
      return offset_point(patch, b.lower.x + x * (b.upper.x - b.lower.x),
                          b.lower.y + y * (b.upper.y - b.lower.y));
    };
  };
  Piece piece;
  const double error = fit(shape_of(part), piece.shape);
  if (error > kFitTol * size_ && depth < kMaxOffsetDepth) {
    const dvec2 c = part.center();
    for (int k = 0; k < 4; ++k) {
      Box2 quarter = part;
      (k & 1 ? quarter.lower.x : quarter.upper.x) = c.x;
      (k & 2 ? quarter.lower.y : quarter.upper.y) = c.y;
      add_offset_pieces(patch, base, quarter, depth + 1);
    }
    return;
  }
  piece.base = base;
  piece.x0 = part.lower.x, piece.x1 = part.upper.x, piece.y0 = part.lower.y, piece.y1 = part.upper.y;
  piece.shape.s0 = patch.s0 + piece.x0 * (patch.s1 - patch.s0),
  piece.shape.s1 = patch.s0 + piece.x1 * (patch.s1 - patch.s0);
  piece.shape.t0 = patch.t0 + piece.y0 * (patch.t1 - patch.t0),
  piece.shape.t1 = patch.t0 + piece.y1 * (patch.t1 - patch.t0);
  pieces_.push_back(std::move(piece));
}

FaceModel::Point FaceModel::point(const Piece& piece, Real x, Real y) const {
  const PatchPoint e = evaluate(piece.shape, x, y);
  Point out;
  out.p = affine(e.h);
  out.dx = (Vec3(e.hx) - out.p * e.hx.w) / e.h.w, out.dy = (Vec3(e.hy) - out.p * e.hy.w) / e.h.w;
  out.normal = glm::cross(out.dx, out.dy);
  if (piece.base >= 0)
    out.p = offset_point(base_[piece.base], piece.x0 + x * (piece.x1 - piece.x0),
                         piece.y0 + y * (piece.y1 - piece.y0));
  return out;
}

FaceModel::Point FaceModel::at(dvec2 uv) const {
  const double s = to_nurbs(knots_u_, map_u_, uv.x), t = to_nurbs(knots_v_, map_v_, uv.y);
  const Piece* best = nullptr;
  double miss = kInf;
  for (const Piece& piece : pieces_) {
    const Patch& a = piece.shape;
    const double d = std::max({a.s0 - s, s - a.s1, 0.0}) + std::max({a.t0 - t, t - a.t1, 0.0});
    if (d < miss) miss = d, best = &piece;
  }
  if (!best) return {};
  const Patch& a = best->shape;
  Point out = point(*best, (s - a.s0) / (a.s1 - a.s0), (t - a.t0) / (a.t1 - a.t0));
  out.p += origin_;
  return out;
}

bool FaceModel::search(const Line& line, const Vec3& shift, std::vector<trace::Root>& out) const {
  // The origin moves along the line to where it is nearest to the face.
  const Vec3 from = line.org - origin_;
  const Real along = -glm::dot(from, line.dir);
  const Vec3 near = from + along * line.dir + shift;
  Line local = line;
  local.org = near;

  bool decided = true;
  std::vector<dvec2> found;
  for (const Piece& piece : pieces_) {
    if (!local.meets(piece.box, double(glm::length(shift)))) continue;
    Net net{piece.shape.p, piece.shape.q, {}};
    double scale = 0.0;
    for (const Vec4& h : piece.shape.ctrl) {
      net.c.push_back(dvec2(local.project(h)));
      scale = std::max({scale, std::abs(net.c.back().x), std::abs(net.c.back().y)});
    }
    found.clear();
    decided = common_roots(net, 1e-15 * scale, found) && decided;
    for (const dvec2& guess : found) {
      Real x = guess.x, y = guess.y;
      for (int k = 0; k < 12; ++k) {
        const Point e = point(piece, x, y);
        const Vec3 r = e.p - near;
        const Real f = glm::dot(line.n1, r), g = glm::dot(line.n2, r);
        const Real fx = glm::dot(line.n1, e.dx), fy = glm::dot(line.n1, e.dy);
        const Real gx = glm::dot(line.n2, e.dx), gy = glm::dot(line.n2, e.dy);
        const Real det = fx * gy - fy * gx;
        if (det == 0) break;
        const Real dx = (gy * f - fy * g) / det, dy = (fx * g - gx * f) / det;
        if (!(std::abs(x - dx - guess.x) + std::abs(y - dy - guess.y) < 1e-4L)) break;
        x -= dx, y -= dy;
        if (std::abs(dx) + std::abs(dy) < 1e-17L) break;
      }
      const Point e = point(piece, x, y);
      trace::Root root;
      root.face = face_;
      root.t = double(glm::dot(line.dir, e.p - near) + along);
      const Vec3 normal = glm::normalize(reversed_ ? -e.normal : e.normal);
      root.normal = dvec3(normal);
      root.sign = glm::dot(normal, line.dir) > 0 ? 1 : -1;
      const Patch& s = piece.shape;
      root.uv_face = dvec2(to_face(knots_u_, map_u_, double(s.s0 + x * (s.s1 - s.s0))),
                           to_face(knots_v_, map_v_, double(s.t0 + y * (s.t1 - s.t0))));
      out.push_back(root);
    }
  }
  return decided;
}

void FaceModel::roots(const Line& line, std::vector<trace::Root>& out) const {
  if (pieces_.empty() || !line.meets(box_, 0.0)) return;
  std::vector<trace::Root> roots;
  bool decided = search(line, Vec3(0), roots);
  Real step = 0;
  if (!decided) {
    // Tangent, edge-on, or through a pole: a line a hair beside it tells which.
    constexpr Real kTurn[3][2] = {{0.83L, 0.55L}, {-0.61L, 0.79L}, {0.27L, -0.96L}};
    for (int k = 0; k < 3 && !decided; ++k) {
      roots.clear();
      step = size_ * (k == 0 ? 1e-12L : k == 1 ? 1e-11L : 1e-10L);
      decided = search(line, step * (kTurn[k][0] * line.n1 + kTurn[k][1] * line.n2), roots);
    }
  }
  std::sort(roots.begin(), roots.end(), [](const trace::Root& a, const trace::Root& b) { return a.t < b.t; });
  for (trace::Root& r : roots) r.inside = trims_.inside(r.uv_face);

  // The same root from two pieces or from both sides of a seam; and the two halves of a tangent one, which
  // only the shift has parted.
  auto apart = [&](const trace::Root& a, const trace::Root& b) {
    dvec2 d = glm::abs(a.uv_face - b.uv_face);
    for (int axis = 0; axis < 2; ++axis) {
      if (period_[axis] > 0.0) d[axis] = std::min(d[axis], std::abs(d[axis] - period_[axis]));
      d[axis] /= std::max(range_[axis], 1e-300);
    }
    return std::max(d.x, d.y);
  };
  const double tangent_t = 4.0 * std::sqrt(double(step) * size_),
               tangent_uv = 4.0 * std::sqrt(double(step) / std::max(size_, 1e-300));
  std::vector<char> dropped(roots.size(), 0);
  for (std::size_t a = 0; a < roots.size(); ++a)
    for (std::size_t b = a + 1; b < roots.size() && !dropped[a]; ++b) {
      if (dropped[b]) continue;
      const double dt = roots[b].t - roots[a].t;
      if (roots[a].sign == roots[b].sign && dt <= kSame * size_) dropped[roots[a].inside ? b : a] = 1;
      if (roots[a].sign != roots[b].sign && step > 0 && dt <= tangent_t &&
          apart(roots[a], roots[b]) <= tangent_uv)
        dropped[a] = dropped[b] = 1;
    }
  for (std::size_t k = 0; k < roots.size(); ++k)
    if (!dropped[k]) out.push_back(roots[k]);
}

}  // namespace trimray::reference
