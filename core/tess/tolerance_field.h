// How far a mesh may be from its surface, by place.
#pragma once

#include "core/base/box.h"

namespace trimray::tess {

class ToleranceField {
 public:
  virtual ~ToleranceField() = default;
  // mm > 0, in the coordinates of the prototype, for all that lies within the box; kInf where nobody looks.
  // The smaller the box, the larger (never smaller) the answer. From any thread.
  virtual double at(const Box3& box) const = 0;
};

class UniformTolerance final : public ToleranceField {
 public:
  explicit UniformTolerance(double mm) : mm_(mm) {}
  double at(const Box3&) const override { return mm_; }

 private:
  double mm_;
};

}  // namespace trimray::tess
