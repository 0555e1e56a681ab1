// Points of one smooth patch of a surface, quickly along lines of constant v.
#pragma once

#include <vector>

#include "core/nurbs/bezier.h"
#include "core/nurbs/knot_vector.h"
#include "core/nurbs/surface_form.h"

namespace trimray::mass {

// Where a surface may not be smooth: lines of constant u and of constant v, ascending, in uv_face. Between
// two neighbours, and beyond the outer ones, its integrands are analytic but for what poles do to the area.
struct SmoothCells {
  std::vector<double> u, v;
};
// box: of uv_face, for which they are wanted.
SmoothCells smooth_cells(const nurbs::NurbsStore& store, const nurbs::Surface& surface, const Box2& box);

// The surface of one face, ready to be evaluated cell by cell.
class SurfacePatches {
 public:
  SurfacePatches(const nurbs::NurbsStore& store, const nurbs::Surface& surface);

 private:
  friend class SurfaceRow;
  nurbs::SurfaceView view_;
  bool direct_;  // by its formula or definition, else by its patches
  nurbs::BezierPatches patches_;
};

// The points with one v in the patch around `inside`, a point in uv_face, whichever turn of a periodic
// surface it lies in. The patch continues beyond its own borders.
class SurfaceRow {
 public:
  SurfaceRow(const SurfacePatches& surface, dvec2 inside);
  void set_v(double v);
  nurbs::SurfacePoint at(double u) const;

 private:
  const SurfacePatches& surface_;
  Box2 box_;                     // of the patch
  const dvec4* ctrl_ = nullptr;  // of the patch
  dvec2 turn_{0.0};              // from uv_face to the patch, whole periods
  double v_ = 0.0;
  dvec4 row_[nurbs::kMaxDegree + 1];     // control points of the curve v = v_ ...
  dvec4 across_[nurbs::kMaxDegree + 1];  // ... and of its derivative by v
};

}  // namespace trimray::mass
