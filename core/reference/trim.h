// Is a point of the uv plane inside a face's trim loops? By counting crossings of a half-line, each
// curve halved until its control polygon decides.
#pragma once

#include <vector>

#include "core/nurbs/store.h"

namespace trimray::reference {

class TrimLoops {
 public:
  TrimLoops(const nurbs::NurbsStore& store, std::int32_t face);

  // Even-odd rule over the point and its images one period away; with copied loops, over its image in the
  // box.
  bool inside(dvec2 uv_face) const;

  // +1 where the loops run counterclockwise about the face in uv, -1 where they run clockwise.
  int orientation() const { return orientation_; }

 private:
  int crossings(dvec2 uv) const;

  std::vector<std::vector<dvec3>> curves_;  // homogeneous (w u, w v, w), the closing links included
  Box2 box_;
  bool rectangle_ = false;  // inside means in the box
  bool upward_ = false;     // the half-line runs along v, because some loop closes only round the period of u
  bool copied_ = false;     // loops longer than a period: the box, one period wide, has all of them at hand
  dvec2 period_{0.0};
  int orientation_ = 1;
};

}  // namespace trimray::reference
