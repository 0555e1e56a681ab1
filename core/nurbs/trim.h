// Is a point of the uv plane inside a face's trim loops? Exact, by crossing parity of bimonotone Bezier
// pieces (Schollmeyer and Froehlich, "Direct Trimming of NURBS Surfaces on the GPU", SIGGRAPH 2009), with
// an accelerating grid per face.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/nurbs/store.h"

namespace trimray::nurbs {

enum class Coverage : std::uint8_t { kOutside, kInside, kMixed };

// The accelerated trim loops of every face of a store. Holds what it needs; the store may go.
// Throws ArgumentError for a trim curve of degree above 63.
class TrimIndex {
 public:
  explicit TrimIndex(const NurbsStore& store, int threads = 0);
  TrimIndex(TrimIndex&&) noexcept;
  TrimIndex& operator=(TrimIndex&&) noexcept;
  ~TrimIndex();

  // True when uv lies inside the loops by the even-odd rule. uv is taken as it is: the caller brings
  // periodic coordinates into the face's uv_box first (wrap below). Points on a curve fall on one
  // side by the half-open rule, the same one every time.
  bool inside(std::int32_t face, dvec2 uv_face) const;

  // Brings a periodic coordinate next to the face's uv_box: u + k * period with the smallest distance
  // from the box's middle.
  dvec2 wrap(std::int32_t face, dvec2 uv_face) const;
  // Does wrap() ever change a coordinate?
  bool wraps(std::int32_t face) const;

  // Both for the points u[i], v[i] with bit i of `which` set, i < 8, at less cost each. wrap() works in
  // place; the result of inside() is a subset of `which`.
  void wrap(std::int32_t face, double* u, double* v, std::uint32_t which) const;
  std::uint32_t inside(std::int32_t face, const double* u, const double* v, std::uint32_t which) const;

  // Conservative: kInside and kOutside are certain for the whole box.
  Coverage coverage(std::int32_t face, const Box2& uv_face) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trimray::nurbs
