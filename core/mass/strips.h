// The region inside a face's trim loops as strips, over each of which the face's integrands are smooth.
//
// By Green's theorem the integral over the region is that over its border of F dv, F(u, v) being the integral
// from some line up to u (D. Gunderman, K. Weiss, J. Evans, "Spectral mesh-free quadrature for planar regions
// bounded by rational parametric curves", Computer-Aided Design 130, 2021). The loops are cut at the lines
// where the surface is not smooth. In every cell between such lines, the line to start from is the cell's
// left border, so a piece of a loop stands for the strip between itself and that border, and for the whole
// width of every cell further to the left:
//
//      |       |    \      strips of the piece \: one that ends at it (3), and two whole ones (1, 2), which
//      |   1   | 2   \ 3   cancel with those of the loop's other pieces, so far as they are outside
//      |       |     /
#pragma once

#include <vector>

#include "core/mass/surface_row.h"
#include "core/nurbs/store.h"

namespace trimray::mass {

// All coordinates from Strips::origin. Counts with `weight` times the integral over t in [0, 1] of v'(t) dt
// and s from `left` to u(t).
struct Strip {
  dvec2 inside{0.0};  // of the cell
  double left = 0.0;
  dvec2 from{0.0}, to{0.0};  // the piece's ends
  std::int32_t ctrl = 0;     // its first control point; a line has none
  std::int32_t degree = 1;
  double weight = 0.0;
};

struct Strips {
  dvec2 origin{0.0};  // uv_face
  std::vector<Strip> strips;
  std::vector<dvec3> ctrl_h;  // (w u, w v, w)
};

// A face without loops is its uv box. Loops that do not run as outer loops and holes should count by the
// nesting of one in the other. Straight links close them as in core/nurbs/trim_segment.h.
Strips cut_strips(const nurbs::NurbsStore& store, std::int32_t face);

}  // namespace trimray::mass
