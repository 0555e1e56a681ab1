// Hand-made solids whose p-curves are off on purpose, and their roots by closed form.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "core/nurbs/link_edges.h"
#include "core/nurbs/make_store.h"
#include "core/nurbs/store.h"
#include "core/nurbs/surface.h"
#include "core/trace/ray.h"

namespace trimray::trace {

using nurbs::Range;

inline std::int32_t size_of(const auto& array) { return static_cast<std::int32_t>(array.size()); }

// Collects vertices, edges and faces; edges may be given once and used by any number of faces.
class SolidMaker {
 public:
  nurbs::NurbsStore store;
  double band = 1e-9;

  std::int32_t vertex(dvec3 p) {
    store.vertices.push_back({p, 0.0});
    return size_of(store.vertices) - 1;
  }

  // Homogeneous control points of each piece; none: a straight piece from vertex to vertex.
  std::int32_t edge(std::int32_t v0, std::int32_t v1, std::vector<std::vector<dvec4>> pieces = {},
                    double t1 = 1.0) {
    if (pieces.empty())
      pieces = {{dvec4(store.vertices[v0].point, 1.0), dvec4(store.vertices[v1].point, 1.0)}};
    nurbs::Edge e;
    e.vertex[0] = v0, e.vertex[1] = v1, e.band = band;
    e.pieces.begin = size_of(store.edge_pieces);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const std::int32_t begin = size_of(store.edge_ctrl_h);
      for (const dvec4& c : pieces[i]) store.edge_ctrl_h.push_back(c);
      const double n = static_cast<double>(pieces.size());
      store.edge_pieces.push_back({{begin, size_of(store.edge_ctrl_h)}, t1 * i / n, t1 * (i + 1) / n});
    }
    e.pieces.end = size_of(store.edge_pieces);
    store.edges.push_back(e);
    return size_of(store.edges) - 1;
  }

  struct Use {
    std::int32_t edge;
    bool reversed;
    std::vector<std::vector<dvec3>> pieces;  // in the loop's direction
  };

  std::int32_t face(const nurbs::SurfaceForm& form, bool reversed,
                    const std::vector<std::vector<Use>>& loops) {
    nurbs::Face f;
    f.surface = nurbs::append_surface(store, form);
    f.prototype = 0, f.shell = 0, f.reversed = reversed;
    f.loops.begin = size_of(store.loops);
    const std::int32_t index = size_of(store.faces);
    for (const auto& loop : loops) {
      const std::int32_t first = size_of(store.coedges);
      for (const Use& use : loop) {
        nurbs::CoEdge c;
        c.edge = use.edge, c.face = index, c.loop = size_of(store.loops), c.reversed = use.reversed;
        c.pieces.begin = size_of(store.trim_pieces);
        const nurbs::Range edge_pieces = store.edges[use.edge].pieces;
        const double t_end = edge_pieces.size() ? store.edge_pieces[edge_pieces.end - 1].t1 : 1.0;
        for (std::size_t i = 0; i < use.pieces.size(); ++i) {
          const std::int32_t begin = size_of(store.trim_ctrl_h);
          for (const dvec3& h : use.pieces[i]) {
            store.trim_ctrl_h.push_back(h);
            f.uv_box.add(dvec2(h.x, h.y) / h.z);
          }
          const double n = static_cast<double>(use.pieces.size());
          double t0 = t_end * i / n, t1 = t_end * (i + 1) / n;
          if (use.reversed) t0 = t_end - t0, t1 = t_end - t1;
          store.trim_pieces.push_back({{begin, size_of(store.trim_ctrl_h)}, t0, t1});
        }
        c.pieces.end = size_of(store.trim_pieces);
        store.coedges.push_back(c);
      }
      store.loops.push_back({index, {first, size_of(store.coedges)}});
    }
    f.loops.end = size_of(store.loops);
    store.faces.push_back(f);
    return index;
  }

  nurbs::NurbsStore finish() {
    nurbs::Prototype p;
    p.faces = {0, size_of(store.faces)}, p.edges = {0, size_of(store.edges)};
    p.vertices = {0, size_of(store.vertices)}, p.shells = {0, 1};
    for (const auto& v : store.vertices) p.bounds.add(v.point);
    for (const auto& h : store.edge_ctrl_h) p.bounds.add(dvec3(h) / h.w);
    nurbs::link_edges(store);
    store.shells.push_back({0, p.faces, true});
    store.prototypes.push_back(p);
    store.instances.emplace_back().prototype = 0;
    return store;
  }
};

// A polyhedron: each face's vertices counterclockwise from outside. Every p-curve end is moved by up to
// `noise` in any direction; every second face is stored reversed, with its surface's normal inwards.
inline nurbs::NurbsStore polyhedron(const std::vector<dvec3>& points,
                                    const std::vector<std::vector<int>>& faces, double noise,
                                    std::mt19937_64& rng) {
  SolidMaker maker;
  maker.band = std::max(4.0 * noise, 1e-8);
  std::uniform_real_distribution<double> off(-noise, noise);
  for (const dvec3& p : points) maker.vertex(p);
  std::map<std::pair<int, int>, std::int32_t> edges;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::vector<int>& ring = faces[f];
    const dvec3 a = points[ring[0]], b = points[ring[1]], c = points[ring[2]];
    const bool reversed = f % 2;
    const dvec3 normal = glm::normalize(glm::cross(b - a, c - a)) * (reversed ? -1.0 : 1.0);
    const nurbs::SurfaceForm plane = nurbs::make_plane({a, b - a, normal});
    const auto uv = [&](int v) {
      const dvec3 d = points[v] - plane.surface.location;
      return dvec3(glm::dot(d, plane.surface.x_axis) + off(rng), glm::dot(d, plane.surface.y_axis) + off(rng),
                   1.0);
    };
    std::vector<SolidMaker::Use> loop;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      // Loops run counterclockwise about Su x Sv.
      int v0 = ring[i], v1 = ring[(i + 1) % ring.size()];
      if (reversed) v0 = ring[ring.size() - 1 - i], v1 = ring[(2 * ring.size() - 2 - i) % ring.size()];
      const auto key = std::minmax(v0, v1);
      auto at = edges.find(key);
      if (at == edges.end()) at = edges.emplace(key, maker.edge(v0, v1)).first;
      loop.push_back({at->second, maker.store.edges[at->second].vertex[0] != v0, {{uv(v0), uv(v1)}}});
    }
    maker.face(plane, reversed, {loop});
  }
  return maker.finish();
}

inline nurbs::NurbsStore box_solid(dvec3 lower, dvec3 upper, double noise, std::mt19937_64& rng) {
  std::vector<dvec3> points;
  for (int i = 0; i < 8; ++i)
    points.push_back({i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
  return polyhedron(points,
                    {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}},
                    noise, rng);
}

// A circle of radius r at height z, from (r, 0, z), as four rational quadratics; scaled, for p-curves too.
inline std::vector<std::vector<dvec4>> circle_pieces(double r, double z) {
  const double h = std::sqrt(0.5);
  const dvec2 c[9] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
  std::vector<std::vector<dvec4>> pieces;
  for (int q = 0; q < 4; ++q)
    pieces.push_back({dvec4(r * c[2 * q].x, r * c[2 * q].y, z, 1),
                      h * dvec4(r * c[2 * q + 1].x, r * c[2 * q + 1].y, z, 1),
                      dvec4(r * c[2 * q + 2].x, r * c[2 * q + 2].y, z, 1)});
  return pieces;
}

// A cylinder about z with caps: the caps' circles are smaller than the edges by `gap`, the side is lower by
// gap at both ends, its seam's p-curves are off by gap / radius.
inline nurbs::NurbsStore capped_cylinder(double radius, double height, double gap) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  SolidMaker maker;
  maker.band = std::max(4.0 * std::abs(gap), 1e-8);
  const std::int32_t v0 = maker.vertex({radius, 0, 0}), v1 = maker.vertex({radius, 0, height});
  const std::int32_t bottom = maker.edge(v0, v0, circle_pieces(radius, 0), kTurn);
  const std::int32_t top = maker.edge(v1, v1, circle_pieces(radius, height), kTurn);
  const std::int32_t seam = maker.edge(v0, v1);
  const auto line = [](dvec2 a, dvec2 b) {
    return std::vector<std::vector<dvec3>>{{dvec3(a, 1), dvec3(b, 1)}};
  };
  const double u0 = gap / radius, u1 = kTurn - gap / radius, z0 = gap, z1 = height - gap;
  maker.face(nurbs::make_cylinder({}, radius), false,
             {{{bottom, false, line({u0, z0}, {u1, z0})},
               {seam, false, line({u1, z0}, {u1, z1})},
               {top, true, line({u1, z1}, {u0, z1})},
               {seam, true, line({u0, z1}, {u0, z0})}}});
  std::vector<std::vector<dvec3>> circle, turned;
  for (const auto& piece : circle_pieces(radius - gap, 0)) {
    std::vector<dvec3> p;
    for (const dvec4& h : piece) p.push_back({h.x, h.y, h.w});
    circle.push_back(p);
    turned.insert(turned.begin(), std::vector<dvec3>(p.rbegin(), p.rend()));
  }
  maker.face(nurbs::make_plane({{0, 0, height}}), false, {{{top, false, circle}}});
  // The lower cap: its plane looks up, so the face is reversed; loops run counterclockwise about Su x Sv.
  maker.face(nurbs::make_plane({}), true, {{{bottom, false, circle}}});
  return maker.finish();
}

// All crossings of the line with the whole plane, cylinder, cone or sphere of a face.
inline std::vector<Root> closed_form_roots(const nurbs::NurbsStore& store, std::int32_t face,
                                           const Ray& ray) {
  const nurbs::Face& f = store.faces[face];
  const nurbs::Surface& s = store.surfaces[f.surface];
  const dvec3 d = ray.org - s.location;
  const dvec3 o{glm::dot(d, s.x_axis), glm::dot(d, s.y_axis), glm::dot(d, s.z_axis)};
  const dvec3 w{glm::dot(ray.dir, s.x_axis), glm::dot(ray.dir, s.y_axis), glm::dot(ray.dir, s.z_axis)};
  const bool plane = s.kind == nurbs::SurfaceKind::kPlane, sphere = s.kind == nurbs::SurfaceKind::kSphere;
  const double slope = s.kind == nurbs::SurfaceKind::kCone ? std::tan(s.semi_angle) : 0.0;
  std::vector<double> ts;
  if (plane) {
    if (w.z != 0.0) ts.push_back(-o.z / w.z);
  } else {
    // x^2 + y^2 = (r1 + slope z)^2, for the sphere x^2 + y^2 + z^2 = r1^2.
    const double radius = s.r1 + slope * o.z, growth = slope * w.z;
    const double a = sphere ? glm::dot(w, w) : w.x * w.x + w.y * w.y - growth * growth;
    const double b = sphere ? glm::dot(o, w) : o.x * w.x + o.y * w.y - radius * growth;
    const double c = sphere ? glm::dot(o, o) - s.r1 * s.r1 : o.x * o.x + o.y * o.y - radius * radius;
    const double root = b * b - a * c;
    if (a != 0.0 && root > 0.0) {
      const double q = -(b + std::copysign(std::sqrt(root), b));
      ts = {q / a, c / q};
    }
  }
  std::vector<Root> roots;
  for (double t : ts) {
    const dvec3 p = o + t * w;
    const double across = s.r1 + slope * p.z < 0.0 ? -1.0 : 1.0;  // beyond a cone's apex
    Root r;
    r.t = t, r.face = face;
    const double u = std::atan2(across * p.y, across * p.x);
    r.uv_face = plane    ? dvec2(p)
                : sphere ? dvec2(u, std::asin(std::clamp(p.z / s.r1, -1.0, 1.0)))
                         : dvec2(u, p.z / std::cos(s.semi_angle));
    const nurbs::SurfacePoint at = nurbs::evaluate(store, s, r.uv_face);
    r.normal = glm::normalize(glm::cross(at.du, at.dv)) * (f.reversed ? -1.0 : 1.0);
    r.sign = glm::dot(r.normal, ray.dir) > 0.0 ? 1 : -1;
    roots.push_back(r);
  }
  return roots;
}

}  // namespace trimray::trace
