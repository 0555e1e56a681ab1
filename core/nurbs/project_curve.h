// Curves in space brought onto a surface, for faces whose file gives no p-curve; and distances to curves.
#pragma once

#include <optional>

#include "core/nurbs/curve_form.h"
#include "core/nurbs/surface_form.h"

namespace trimray::nurbs {

// Exact: the path dropped along the normal onto a plane, in its uv.
Pieces2 project_on_plane(const Pieces3& path, const Surface& plane);

// Closest uv near a guess; Gauss-Newton.
dvec2 closest_uv(const SurfaceView& surface, dvec3 point, dvec2 guess);

// Piecewise cubics through the closest uv of the path's points; empty when the path leaves the surface by
// more than reach (mm).
std::optional<Pieces2> project_on_surface(const Pieces3& path, const SurfaceView& surface, double reach);

// Distance of a point to a path, to about a hundredth: locally from a parameter, and over all pieces when
// that is above good_enough. A result below good_enough may be too large.
double path_distance(const Pieces3& path, dvec3 point, double t, double good_enough);

// A point of the path at t of [t0, t1], linear within each piece (for rational pieces only roughly the edge's
// own parameter).
dvec3 path_point(const Pieces3& path, double t);

}  // namespace trimray::nurbs
