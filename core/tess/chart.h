// Chart: the plane in which a face is triangulated.
//
// For surfaces with a closed form, and wherever the parameter map is the identity, this is uv_face. Others
// are rational between their knots only in the parameters of their NURBS form, so these are taken.
#pragma once

#include "core/nurbs/surface_form.h"

namespace trimray::tess {

class Chart {
 public:
  Chart(const nurbs::NurbsStore& store, const nurbs::Surface& surface);

  const nurbs::Surface& surface() const { return *surface_; }
  bool closed_form() const { return closed_form_; }

  dvec2 from_face(dvec2 uv_face) const;
  dvec2 to_face(dvec2 p) const;

  // Point and derivatives with respect to the chart.
  nurbs::SurfacePoint at(dvec2 p) const;
  dvec3 point(dvec2 p) const;

  // The foot of a point near the surface: p with S(p) nearest to it, sought from a guess that is near it. In
  // a direction in which the surface collapses (a pole) the guess is kept.
  dvec2 project(const dvec3& point, dvec2 guess) const;

 private:
  dvec2 project_closed_form(const dvec3& point, dvec2 guess) const;
  dvec2 project_newton(const dvec3& point, dvec2 guess) const;

  const nurbs::NurbsStore* store_;
  const nurbs::Surface* surface_;
  nurbs::SurfaceView view_;
  bool closed_form_ = false, mapped_ = false;
  dvec2 extent_{1.0};  // of the domain, where finite
};

}  // namespace trimray::tess
