// One face made ready for the reference tracer: its Bezier pieces over the search region, its trims, and all
// roots of a line on it.
#pragma once

#include <vector>

#include "core/reference/line.h"
#include "core/reference/trim.h"

namespace trimray::reference {

// A piece to search. For an offset surface shape is a polynomial approximation (1e-10 of the face's size)
// that only guides the search: roots are polished on the definition, base piece plus offset.
struct Piece {
  Patch shape;
  Box3 box;                                       // relative to the face's origin
  int base = -1;                                  // offset surfaces: index into FaceModel::base ...
  double x0 = 0.0, x1 = 1.0, y0 = 0.0, y1 = 1.0;  // ... and the part of it that shape covers
};

class FaceModel {
 public:
  // margin: how far, in mm, the search must reach beyond the face's uv_box.
  FaceModel(const nurbs::NurbsStore& store, std::int32_t face, double margin);

  // Every crossing of the whole line with the extended surface, sorted by t (unit direction), inside
  // by the p-curves. Tangent double roots are dropped together.
  void roots(const Line& line, std::vector<trace::Root>& out) const;

  const Box3& box() const { return box_; }  // of the search region
  const TrimLoops& trims() const { return trims_; }

  struct Point {
    Vec3 p, dx, dy, normal;  // dx, dy by the piece's own parameters; normal not unit
  };
  Point at(dvec2 uv_face) const;  // in the prototype's coordinates; uv within the search region

 private:
  void add_offset_pieces(const Patch& patch, int base, Box2 part, int depth);
  bool search(const Line& line, const Vec3& shift, std::vector<trace::Root>& out) const;
  Point point(const Piece& piece, Real x, Real y) const;  // relative to the face's origin
  Vec3 offset_point(const Patch& patch, Real x, Real y) const;

  std::int32_t face_ = -1;
  bool reversed_ = false;
  double offset_ = 0.0, size_ = 0.0;
  nurbs::ParamMap map_u_, map_v_;
  std::vector<double> knots_u_, knots_v_;
  dvec2 period_{0.0}, middle_{0.0}, range_{0.0};
  Vec3 origin_{0};
  std::vector<Piece> pieces_;
  std::vector<Patch> base_;
  Box3 box_;
  TrimLoops trims_;
};

// The control hull's box of a face's whole NURBS form, widened for the margin and the offset: cheap enough to
// be asked for every ray.
Box3 rough_box(const nurbs::NurbsStore& store, std::int32_t face, double margin);

}  // namespace trimray::reference
