#include "core/nurbs/make_store.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/tolerance.h"
#include "core/nurbs/bounds.h"
#include "core/nurbs/link_edges.h"

namespace trimray::nurbs {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kFar = 1e3;  // mm, half length of the natural domain along straight directions

SurfaceForm analytic(SurfaceKind kind, const Frame3& frame) {
  SurfaceForm form;
  Surface& f = form.surface;
  f.kind = kind;
  f.location = frame.location;
  f.z_axis = glm::normalize(frame.z_axis);
  f.x_axis = glm::normalize(frame.x_axis - glm::dot(frame.x_axis, f.z_axis) * f.z_axis);
  f.y_axis = glm::cross(f.z_axis, f.x_axis);
  if (kind != SurfaceKind::kPlane) f.periodic_u = true, f.period_u = kTurn;
  return form;
}

SurfaceForm with_domain(SurfaceForm form, dvec2 lower, dvec2 upper) {
  set_closed_form_nurbs(form, {lower, upper});
  return form;
}

// Builds one face after the other into a store.
class Maker {
 public:
  NurbsStore store;

  void add(FaceSpec spec) {
    if (!spec.natural) trim_straight(spec);
    const std::int32_t index = static_cast<std::int32_t>(store.faces.size());
    Face face;
    face.surface = append_surface(store, spec.surface);
    face.prototype = 0, face.shape = index + 1;
    face.shell = static_cast<std::int32_t>(store.shells.size());
    face.reversed = spec.reversed, face.uv_box = spec.uv_box, face.iso_rectangle = true;
    face.loops = {static_cast<std::int32_t>(store.loops.size()),
                  static_cast<std::int32_t>(store.loops.size())};
    bool closed = false;
    if (!spec.natural) {
      closed = add_rectangle(spec, index);
      face.loops.end = face.loops.begin + 1;
    }
    store.faces.push_back(face);
    store.shells.push_back({0, {index, index + 1}, closed});
    bounds_.add(hull_bounds(view(spec.surface), spec.uv_box));
  }

  NurbsStore finish() {
    Prototype p;
    const auto whole = [](const auto& array) { return Range{0, static_cast<std::int32_t>(array.size())}; };
    p.faces = whole(store.faces), p.edges = whole(store.edges);
    p.vertices = whole(store.vertices), p.shells = whole(store.shells);
    p.bounds = bounds_;
    const double reach = glm::length(glm::max(glm::abs(bounds_.lower), glm::abs(bounds_.upper)));
    for (Edge& e : store.edges) e.band = std::max(kMinBand * bounds_.diagonal(), 1e-14 * reach);
    link_edges(store);
    store.prototypes.push_back(p);
    store.instances.push_back({});
    store.instances.back().prototype = 0;
    store.meta = "{}";
    return std::move(store);
  }

 private:
  // Keeps little more than the rectangle of the long natural domain of straight directions.
  static void trim_straight(FaceSpec& spec) {
    const Surface& f = spec.surface.surface;
    if (f.kind == SurfaceKind::kBezier || f.x_axis == dvec3(0.0)) return;
    Box2 domain = f.domain;
    for (int d = 0; d < 2; ++d) {
      if ((d == 0 ? f.map_u : f.map_v) != ParamMap::kIdentity) continue;
      const double margin = 0.01 * (spec.uv_box.upper[d] - spec.uv_box.lower[d]);
      domain.lower[d] = spec.uv_box.lower[d] - margin, domain.upper[d] = spec.uv_box.upper[d] + margin;
    }
    respan_surface(spec.surface, domain);
  }

  // Index of a vertex of the current face at the point, new if there is none.
  std::int32_t vertex(dvec3 p, double scale) {
    for (std::size_t i = first_vertex_; i < store.vertices.size(); ++i)
      if (glm::distance(store.vertices[i].point, p) <= 1e-12 * scale) return static_cast<std::int32_t>(i);
    store.vertices.push_back({p, 0.0});
    return static_cast<std::int32_t>(store.vertices.size()) - 1;
  }

  // An edge along a side of the rectangle, in the direction of the growing parameter.
  std::int32_t side(const SurfaceForm& form, bool fixed_u, double at, double t0, double t1, double scale) {
    const SurfaceView s = view(form);
    const auto uv = [&](double t) { return fixed_u ? dvec2(at, t) : dvec2(t, at); };
    Edge e;
    e.tolerance = 1e-7;
    double spread = 0.0;
    const dvec3 start = evaluate(s, uv(t0)).p, stop = evaluate(s, uv(t1)).p;
    for (int i = 1; i <= 8; ++i)
      spread = std::max(spread, glm::distance(start, evaluate(s, uv(t0 + (t1 - t0) * i / 8)).p));
    e.vertex[0] = vertex(start, scale), e.vertex[1] = vertex(stop, scale);
    e.degenerate = spread <= 1e-12 * scale;
    e.pieces = {static_cast<std::int32_t>(store.edge_pieces.size()),
                static_cast<std::int32_t>(store.edge_pieces.size())};
    if (!e.degenerate) {
      SplineCurve<dvec4> iso = iso_curve(s, fixed_u, at);
      const auto s_of = [&](double t) {
        const int span = find_span(iso.knots, iso.degree, t);
        return map_parameter(iso.map, iso.knots[span], iso.knots[span + 1], t).s;
      };
      // Ends inside a span are at mapped parameters; t0 and t1 of the pieces stay those of uv_face.
      iso = respan_curve(iso, s_of(t0), s_of(t1));
      std::vector<dvec4> points;
      append_bezier<dvec4>(iso.knots, iso.degree, iso.ctrl.data(), 1, points);
      std::vector<double> ts = distinct_knots(iso.knots, iso.degree);
      ts.front() = t0, ts.back() = t1;
      for (std::size_t k = 0; k + 1 < ts.size(); ++k) {
        const std::int32_t begin = static_cast<std::int32_t>(store.edge_ctrl_h.size());
        const auto from = points.begin() + static_cast<std::ptrdiff_t>(k) * (iso.degree + 1);
        store.edge_ctrl_h.insert(store.edge_ctrl_h.end(), from, from + iso.degree + 1);
        store.edge_pieces.push_back({{begin, begin + iso.degree + 1}, ts[k], ts[k + 1]});
      }
      e.pieces.end = static_cast<std::int32_t>(store.edge_pieces.size());
    }
    store.edges.push_back(e);
    return static_cast<std::int32_t>(store.edges.size()) - 1;
  }

  void coedge(std::int32_t edge, std::int32_t face, dvec2 from, dvec2 to, bool reversed, bool seam, double t0,
              double t1) {
    CoEdge c;
    c.edge = edge, c.face = face, c.reversed = reversed, c.seam = seam;
    c.loop = static_cast<std::int32_t>(store.loops.size());
    c.pieces.begin = static_cast<std::int32_t>(store.trim_pieces.size());
    c.pieces.end = c.pieces.begin + 1;
    const std::int32_t begin = static_cast<std::int32_t>(store.trim_ctrl_h.size());
    store.trim_ctrl_h.emplace_back(from, 1.0);
    store.trim_ctrl_h.emplace_back(to, 1.0);
    store.trim_pieces.push_back({{begin, begin + 2}, t0, t1});
    store.coedges.push_back(c);
  }

  // The loop bottom, right, top, left. Returns whether the edges pair up: a closed surface.
  bool add_rectangle(const FaceSpec& spec, std::int32_t face) {
    first_vertex_ = store.vertices.size();
    const SurfaceForm& form = spec.surface;
    const dvec2 lo = spec.uv_box.lower, hi = spec.uv_box.upper;
    const double scale = hull_bounds(view(form), spec.uv_box).diagonal();
    const auto around = [](double width, double period) {
      return period > 0.0 && std::abs(width - period) < 1e-12 * period;
    };
    const bool seam_u = around(hi.x - lo.x, form.surface.period_u),
               seam_v = around(hi.y - lo.y, form.surface.period_v);
    const std::int32_t bottom = side(form, false, lo.y, lo.x, hi.x, scale);
    const std::int32_t right = side(form, true, hi.x, lo.y, hi.y, scale);
    const std::int32_t top = seam_v ? bottom : side(form, false, hi.y, lo.x, hi.x, scale);
    const std::int32_t left = seam_u ? right : side(form, true, lo.x, lo.y, hi.y, scale);
    const std::int32_t first = static_cast<std::int32_t>(store.coedges.size());
    coedge(bottom, face, lo, {hi.x, lo.y}, false, seam_v, lo.x, hi.x);
    coedge(right, face, {hi.x, lo.y}, hi, false, seam_u, lo.y, hi.y);
    coedge(top, face, hi, {lo.x, hi.y}, true, seam_v, hi.x, lo.x);
    coedge(left, face, {lo.x, hi.y}, lo, true, seam_u, hi.y, lo.y);
    store.loops.push_back({face, {first, first + 4}});
    const auto paired = [&](std::int32_t edge, bool seam) { return seam || store.edges[edge].degenerate; };
    return paired(bottom, seam_v) && paired(top, seam_v) && paired(right, seam_u) && paired(left, seam_u);
  }

  std::size_t first_vertex_ = 0;
  Box3 bounds_;
};

}  // namespace

SurfaceForm make_plane(const Frame3& frame) {
  return with_domain(analytic(SurfaceKind::kPlane, frame), dvec2(-kFar), dvec2(kFar));
}

SurfaceForm make_cylinder(const Frame3& frame, double radius) {
  SurfaceForm form = analytic(SurfaceKind::kCylinder, frame);
  form.surface.r1 = radius;
  return with_domain(std::move(form), {0.0, -kFar}, {kTurn, kFar});
}

SurfaceForm make_cone(const Frame3& frame, double radius, double semi_angle) {
  SurfaceForm form = analytic(SurfaceKind::kCone, frame);
  form.surface.r1 = radius, form.surface.semi_angle = semi_angle;
  return with_domain(std::move(form), {0.0, -kFar}, {kTurn, kFar});
}

SurfaceForm make_sphere(const Frame3& frame, double radius) {
  SurfaceForm form = analytic(SurfaceKind::kSphere, frame);
  form.surface.r1 = radius;
  return with_domain(std::move(form), {0.0, -kTurn / 4}, {kTurn, kTurn / 4});
}

SurfaceForm make_torus(const Frame3& frame, double major_radius, double minor_radius) {
  SurfaceForm form = analytic(SurfaceKind::kTorus, frame);
  form.surface.r1 = major_radius, form.surface.r2 = minor_radius;
  form.surface.periodic_v = true, form.surface.period_v = kTurn;
  return with_domain(std::move(form), {0.0, 0.0}, {kTurn, kTurn});
}

SurfaceForm make_bspline(int degree_u, int degree_v, std::vector<double> knots_u, std::vector<double> knots_v,
                         std::vector<dvec4> ctrl_h) {
  SurfaceForm form;
  Surface& f = form.surface;
  f.kind = SurfaceKind::kBspline;
  f.degree_u = degree_u, f.degree_v = degree_v;
  f.count_u = static_cast<std::int32_t>(knots_u.size()) - degree_u - 1;
  f.count_v = static_cast<std::int32_t>(knots_v.size()) - degree_v - 1;
  f.domain.lower = {knots_u.front(), knots_v.front()};
  f.domain.upper = {knots_u.back(), knots_v.back()};
  for (const dvec4& h : ctrl_h) f.rational = f.rational || h.w != 1.0;
  form.knots_u = std::move(knots_u), form.knots_v = std::move(knots_v);
  form.ctrl_h = std::move(ctrl_h);
  return form;
}

SurfaceForm make_bezier(int degree_u, int degree_v, std::vector<dvec4> ctrl_h) {
  const auto knots = [](int degree) {
    std::vector<double> k(degree + 1, 0.0);
    k.insert(k.end(), degree + 1, 1.0);
    return k;
  };
  SurfaceForm form = make_bspline(degree_u, degree_v, knots(degree_u), knots(degree_v), std::move(ctrl_h));
  form.surface.kind = SurfaceKind::kBezier;
  return form;
}

SurfaceForm as_nurbs(SurfaceForm form) {
  form.surface.kind = SurfaceKind::kBspline;
  return form;
}

SurfaceForm as_offset(SurfaceForm form, double offset) {
  form.surface.kind = SurfaceKind::kOffset;
  form.surface.offset = offset;
  return form;
}

NurbsStore make_store(std::span<const FaceSpec> faces) {
  Maker maker;
  for (const FaceSpec& f : faces) maker.add(f);
  return maker.finish();
}

FaceSpec full_sphere(const Frame3& frame, double radius) {
  return {make_sphere(frame, radius), {{0.0, -kTurn / 4}, {kTurn, kTurn / 4}}};
}

FaceSpec full_torus(const Frame3& frame, double major_radius, double minor_radius) {
  return {make_torus(frame, major_radius, minor_radius), {{0.0, 0.0}, {kTurn, kTurn}}};
}

FaceSpec tube(const Frame3& frame, double radius, double z0, double z1) {
  return {make_cylinder(frame, radius), {{0.0, z0}, {kTurn, z1}}};
}

}  // namespace trimray::nurbs
