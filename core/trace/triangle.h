// Rays against triangles, watertight and in double.
//
// "Watertight Ray/Triangle Intersection" (Woop, Benthin, Wald 2013): the ray becomes the z axis by a shear
// that depends on the ray alone, so a corner has one place in the (x, y) plane for all triangles that share
// it. A triangle is crossed when the origin lies inside it there. The signs are exact, and where the origin
// lies on a side it is moved by (e, e^2), an infinitely small e (symbolic perturbation): of the triangles
// around an edge or a corner exactly those count that a ray beside it would meet. So no ray passes between
// two triangles, and on a closed mesh a whole line enters as often as it leaves, rounding or not.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/types.h"

namespace trimray::trace {

// The shear of one ray: p -> (p[x] - org[x]) - sx (p[z] - org[z]), the same with y. dir has unit length.
struct RayShear {
  double org[3];
  double sx, sy, sz;  // dir[x] / dir[z], dir[y] / dir[z], 1 / dir[z]
  int x, y, z;        // axes; z is the longest of dir

  RayShear() = default;
  RayShear(const dvec3& o, const dvec3& d);
};

inline constexpr int kTrianglesPerBlock = 8;

// A leaf of triangles of one face, structure of arrays. Unused places stand at the end.
struct alignas(64) TriangleBlock {
  double corner[3][3][kTrianglesPerBlock];    // [corner][axis]
  std::int32_t triangle[kTrianglesPerBlock];  // NurbsStore::mesh_triangles
  std::int32_t count = 0;
};

// The line of ray number `ray` crosses triangle number `lane` of a block. Not initialized: arrays of it are
// filled from the front.
struct TriangleCrossing {
  int ray, lane;
  double t;
  dvec2 weights;  // of the second and the third corner
};

// All crossings of the lines of the rays in `active` with the triangles of the block, at any t, ray by ray.
// out has room for kTrianglesPerBlock a ray. Returns their number. A crossing's bits depend on nothing but
// the ray and the triangle. Relative to the triangle's plane the error of t is a few ulp of the distances
// involved, divided by the sine of the grazing angle.
int cross_triangles(const TriangleBlock& block, std::span<const RayShear> rays, std::uint64_t active,
                    TriangleCrossing* out);

// Unit normal that the corners run around counter-clockwise; (0, 0, 1) for a triangle without area.
dvec3 triangle_normal(const dvec3& a, const dvec3& b, const dvec3& c);

}  // namespace trimray::trace
