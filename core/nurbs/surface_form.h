// A surface outside a store: while it is built, or for one that is made by a program.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/nurbs/spline.h"
#include "core/nurbs/surface.h"

namespace trimray::nurbs {

// surface's ranges are meaningless until append_surface.
struct SurfaceForm {
  Surface surface;
  std::vector<double> knots_u, knots_v;  // flat, clamped
  std::vector<dvec4> ctrl_h;             // [iu * count_v + iv]
  std::optional<Conic> conic;            // the curve that a sweep moves, where it is one
};

// A surface wherever its arrays lie.
struct SurfaceView {
  const Surface* surface = nullptr;
  std::span<const double> knots_u, knots_v;
  const dvec4* ctrl_h = nullptr;
};
SurfaceView view(const SurfaceForm& form);
SurfaceView view(const NurbsStore& store, const Surface& surface);

SurfacePoint evaluate(const SurfaceView& view, dvec2 uv_face);
SurfacePoint evaluate_nurbs(const SurfaceView& view, dvec2 uv_face);
// The point alone, for those who ask often.
dvec3 evaluate_point(const SurfaceView& view, dvec2 uv_face);

// Copies the arrays to the store's ends and returns the new surface's index.
std::int32_t append_surface(NurbsStore& store, const SurfaceForm& form);

// Exact bases of conic spans over [a, b]: homogeneous (cos, sin, w) and (cosh, sinh, w), degree 2, inner
// knots double, with their parameter map. Spans are at most 100 degrees (hyperbola: 1) wide.
SplineCurve<dvec3> circle_basis(double a, double b);
SplineCurve<dvec3> hyperbola_basis(double a, double b);

// Is the kind one of plane, cylinder, cone, sphere, torus?
bool has_closed_form(SurfaceKind kind);

// Fills the exact NURBS form of a plane ... torus from its frame and radii, over domain; kind, frame and
// radii are set.
void set_closed_form_nurbs(SurfaceForm& form, const Box2& domain);

// Tensor forms: a profile (r, z, w; homogeneous) turned about the frame's z; a curve turned about an axis;
// a curve moved along a direction. The curve's parameter is u for the extrusion and v for the turned ones.
void set_extrusion_nurbs(SurfaceForm& form, const SplineCurve<dvec4>& curve, dvec3 direction, double v0,
                         double v1);
void set_revolution_nurbs(SurfaceForm& form, const SplineCurve<dvec4>& curve, dvec3 location, dvec3 axis,
                          double u0, double u1);

// The part of a spline surface over domain (the end spans continue outside the natural one).
void respan_surface(SurfaceForm& form, const Box2& domain);

// The iso-curve u = at (or v = at) of the NURBS form, parametrized by the other coordinate of uv_face.
SplineCurve<dvec4> iso_curve(const SurfaceView& view, bool fixed_u, double at);

}  // namespace trimray::nurbs
