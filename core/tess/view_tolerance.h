// How far a mesh may be from its surface so that a camera sees it off by a few hundredths of a pixel only.
#pragma once

#include <array>
#include <vector>

#include "core/tess/tolerance_field.h"
#include "core/view/camera.h"

namespace trimray::tess {

// What a picture asks of the mesh of one instance.
struct ViewLimits {
  double deviation_px = 0.3;  // > 0
  double near = 1e-3;     // mm, world, > 0: what is nearer to the eye is taken to be this far (perspective)
  double guard_px = 0.0;  // rim around the picture in which the mesh must be as good as within it
};

// In the picture (its guard and a rim of a pixel more included) at(box) is the length in the prototype that
// nowhere in the box is seen longer than deviation_px. Beyond the picture it is the distance from the
// picture's frustum, where that is longer: a triangle that is not farther than this from its surface cannot
// hide that the surface reaches into the picture.
class ViewTolerance final : public ToleranceField {
 public:
  // placement: prototype -> world, any affine one.
  ViewTolerance(const view::Camera& camera, const ViewLimits& limits, const Transform& placement);

  double at(const Box3& box) const override;
  // Over the farthest part of the box, in the picture or not. mm, in the prototype.
  double most(const Box3& box) const;

  // Of the picture with its rim. Neither is sure to find out, both are right when they say yes.
  bool outside(const Box3& box) const { return beyond(box) > 0.0; }
  bool inside(const Box3& box) const;
  // About what part of the box is in the picture, 0 to 1; 1 where inside() says so.
  double share(const Box3& box) const;

  // Is a mesh made for this field good for another one of the same instance, too? True where all of the box
  // that the other one sees is seen here, at tolerances that are nowhere larger, and somewhere no smaller
  // than 1 / finer of what the other one wants.
  bool serves(const ViewTolerance& other, const Box3& box, double finer) const;

 private:
  // An affine function of places in the prototype.
  struct Affine {
    dvec3 n{0.0};
    double d = 0.0;
    double operator()(const dvec3& p) const { return glm::dot(n, p) + d; }
    double least(const Box3& box) const {
      return (*this)(box.center()) - glm::dot(glm::abs(n), 0.5 * box.extent());
    }
    double most(const Box3& box) const {
      return (*this)(box.center()) + glm::dot(glm::abs(n), 0.5 * box.extent());
    }
  };

  double beyond(const Box3& box) const;  // mm, world: from the frustum, a lower bound; <= 0 within
  double allowed(double depth) const;    // mm, in the prototype
  // Of what is seen of the box on the inner side of a plane.
  std::vector<dvec3> corners(const Box3& box, const Affine& cut) const;

  std::array<Affine, 5> planes_;  // of the frustum: mm, world, positive outside
  Affine depth_;                  // mm, world, from the eye
  bool perspective_;
  double near_;
  double share_;    // tolerance in the world by depth (perspective), or the tolerance itself
  double stretch_;  // the placement's largest
};

}  // namespace trimray::tess
