// Small stores made by a program, without any file: for tests, samples and benchmarks.
#pragma once

#include <span>
#include <vector>

#include "core/nurbs/surface_form.h"

namespace trimray::nurbs {

// z_axis is the axis; x_axis any vector not parallel to it.
struct Frame3 {
  dvec3 location{0.0}, x_axis{1, 0, 0}, z_axis{0, 0, 1};
};

// Analytic surfaces with their natural domain (planes, cylinders and cones: +-1e3 along straight directions).
SurfaceForm make_plane(const Frame3& frame);
SurfaceForm make_cylinder(const Frame3& frame, double radius);
SurfaceForm make_cone(const Frame3& frame, double radius, double semi_angle);
SurfaceForm make_sphere(const Frame3& frame, double radius);
SurfaceForm make_torus(const Frame3& frame, double major_radius, double minor_radius);

// knots: flat and clamped. ctrl_h[iu * count_v + iv], count = knots - degree - 1.
SurfaceForm make_bspline(int degree_u, int degree_v, std::vector<double> knots_u, std::vector<double> knots_v,
                         std::vector<dvec4> ctrl_h);
// Over [0, 1]^2; (degree_u + 1) * (degree_v + 1) points.
SurfaceForm make_bezier(int degree_u, int degree_v, std::vector<dvec4> ctrl_h);

// The same surface with kind kBspline: tracers no longer see the closed form. uv_face stays the same (by
// the parameter map).
SurfaceForm as_nurbs(SurfaceForm form);

// The surface moved along its normal Su x Sv: kind kOffset.
SurfaceForm as_offset(SurfaceForm form, double offset);

// One face: a uv rectangle of a surface. Sides that meet around a full period share a seam edge, sides that
// collapse to a point have a degenerate edge. natural: no loops at all, the rectangle being the surface's
// domain.
struct FaceSpec {
  SurfaceForm surface;
  Box2 uv_box;
  bool reversed = false;
  bool natural = false;
};

// One prototype holding the faces, each a shell with edges of its own, and one instance at the origin.
NurbsStore make_store(std::span<const FaceSpec> faces);

// Ready-made single faces.
FaceSpec full_sphere(const Frame3& frame, double radius);
FaceSpec full_torus(const Frame3& frame, double major_radius, double minor_radius);
FaceSpec tube(const Frame3& frame, double radius, double z0, double z1);

}  // namespace trimray::nurbs
