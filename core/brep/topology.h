// What the B-rep byte stream says, before any of it is turned into NURBS: curves, surfaces and the
// graph of shapes, in flat vectors that refer to each other by index. Produced by core/brep/bintools,
// consumed by core/nurbs/build_store. Lengths in mm, angles in radians. No field is trusted.
//
// What the parser guarantees, and nothing else (reals may be NaN, knots unsorted, weights negative):
//   - every index is in range, and a basis has a smaller index than what is made of it, at most
//     kMaxBasisDepth levels deep;
//   - degrees are in [1, kMaxDegree], there are at least 2 knots with multiplicities in [1, degree + 1],
//     and poles, weights, knots and multiplicities agree in number (periodic or not);
//   - shapes have children of the kinds that OpenCascade allows (a wire has edges, a shell faces, ...),
//     all at smaller positions, no way from a shape down to a vertex is longer than kMaxShapeDepth, and
//     a walk down from a shape, meeting shared shapes once per use, takes at most kMaxShapeUses steps.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace trimray::brep {

// OpenCascade constructs no curve or surface of a higher degree.
inline constexpr int kMaxDegree = 25;
// OpenCascade itself never nests trimmed and offset curves or surfaces deeper than 3.
inline constexpr int kMaxBasisDepth = 16;
// So that a recursive walk of the graph is safe.
inline constexpr int kMaxShapeDepth = 256;
// So that compounds of compounds do not multiply without end: about 4 million faces.
inline constexpr std::int64_t kMaxShapeUses = std::int64_t{1} << 26;

enum class CurveKind : std::uint8_t {
  kLine,
  kCircle,
  kEllipse,
  kParabola,
  kHyperbola,
  kBezier,
  kBspline,
  kTrimmed,
  kOffset
};

// A curve in space (Vec = dvec3) or in a surface's uv (Vec = dvec2).
//   line      location + t * x_axis
//   circle    location + r1 * (cos t * x_axis + sin t * y_axis)
//   ellipse   location + r1 * cos t * x_axis + r2 * sin t * y_axis
//   parabola  location + t^2 / (4 r1) * x_axis + t * y_axis               (r1 = focal length)
//   hyperbola location + r1 * cosh t * x_axis + r2 * sinh t * y_axis
//   trimmed   curves[basis] over [first, last]
//   bezier    a spline with the knots 0 and 1; periodic splines have sum(multiplicities) - last poles
//   offset    curves[basis] moved by `offset` along (tangent x offset_direction), in 2D along the
//             tangent turned by -90 degrees
// y_axis carries the handedness of the frame in 2D.
template <typename Vec>
struct Curve {
  CurveKind kind = CurveKind::kLine;
  Vec location{0.0}, x_axis{0.0}, y_axis{0.0};
  double r1 = 0.0, r2 = 0.0;
  bool rational = false, periodic = false;
  int degree = 0;
  std::vector<Vec> poles;
  std::vector<double> weights;  // empty unless rational
  std::vector<double> knots;    // distinct values
  std::vector<std::int32_t> multiplicities;
  double first = 0.0, last = 0.0;  // trimmed only
  double offset = 0.0;
  Vec offset_direction{0.0};  // 3D only
  std::int32_t basis = -1;    // trimmed, offset: index into the same vector, always smaller
};
using Curve2 = Curve<dvec2>;
using Curve3 = Curve<dvec3>;

enum class SurfaceKind : std::uint8_t {
  kPlane,
  kCylinder,
  kCone,
  kSphere,
  kTorus,
  kExtrusion,
  kRevolution,
  kBezier,
  kBspline,
  kTrimmed,
  kOffset
};

// Frame: location, x_axis, y_axis, z_axis (unit; a left-handed frame is allowed).
//   plane     location + u x + v y
//   cylinder  location + r1 (cos u x + sin u y) + v z
//   cone      location + (r1 + v sin a)(cos u x + sin u y) + v cos a z          (a = semi_angle)
//   sphere    location + r1 cos v (cos u x + sin u y) + r1 sin v z
//   torus     location + (r1 + r2 cos v)(cos u x + sin u y) + r2 sin v z
//   extrusion curve3[basis_curve](u) + v z_axis
//   revolution curve3[basis_curve](v) turned by u about (location, z_axis)
//   bezier    a spline with the knots 0 and 1 in both directions
//   trimmed   surfaces[basis] over [u0,u1]x[v0,v1]
//   offset    surfaces[basis] moved by `offset` along its normal Su x Sv
struct Surface {
  SurfaceKind kind = SurfaceKind::kPlane;
  dvec3 location{0.0}, x_axis{0.0}, y_axis{0.0}, z_axis{0.0};
  double r1 = 0.0, r2 = 0.0, semi_angle = 0.0;
  bool rational_u = false, rational_v = false, periodic_u = false, periodic_v = false;
  int degree_u = 0, degree_v = 0;
  std::int32_t count_u = 0, count_v = 0;  // poles; poles[iu * count_v + iv]
  std::vector<dvec3> poles;
  std::vector<double> weights;           // empty unless rational
  std::vector<double> knots_u, knots_v;  // distinct values
  std::vector<std::int32_t> multiplicities_u, multiplicities_v;
  double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;  // trimmed only
  double offset = 0.0;
  std::int32_t basis = -1;        // trimmed, offset: index into surfaces, always smaller
  std::int32_t basis_curve = -1;  // extrusion, revolution: index into curves3
};

// A triangulation, in the coordinates of the face that uses it.
struct Mesh {
  std::vector<dvec3> nodes;
  std::vector<glm::vec3> normals;                      // as nodes, of the forward face; empty: not given
  std::vector<std::array<std::int32_t, 3>> triangles;  // into nodes
};

enum class ShapeKind : std::uint8_t { kCompound, kCompSolid, kSolid, kShell, kFace, kWire, kEdge, kVertex };
enum class Orientation : std::uint8_t { kForward, kReversed, kInternal, kExternal };

// One use of a shape by its parent.
struct ShapeUse {
  std::int32_t shape = -1;  // index into Model::shapes
  Orientation orientation = Orientation::kForward;
  std::int32_t location = -1;  // index into Model::locations, -1 for the identity
};

// An edge's curve on one surface. On a seam both curves are set (curve2 for the reversed use).
struct PCurve {
  std::int32_t curve = -1, curve2 = -1;  // index into Model::curves2
  std::int32_t surface = -1, location = -1;
  double first = 0.0, last = 0.0;
};

struct VertexData {
  dvec3 point{0.0};
  double tolerance = 0.0;
};

struct EdgeData {
  double tolerance = 0.0;
  bool same_parameter = false, same_range = false, degenerated = false;
  std::int32_t curve3 = -1, location = -1;  // the 3D curve, -1 when absent
  double first = 0.0, last = 0.0;
  std::vector<PCurve> pcurves;
  // Smooth (tangent or better) by the stream's regularity records, of a seam or between two surfaces;
  // a single record that says sharp wins.
  bool smooth = false;
};

struct FaceData {
  std::int32_t surface = -1, location = -1;  // surface -1: none, the mesh is all there is
  double tolerance = 0.0;
  bool natural_restriction = false;
  std::int32_t mesh = -1;  // index into Model::meshes, -1: none
};

struct Shape {
  ShapeKind kind = ShapeKind::kCompound;
  std::int32_t data = -1;  // index into vertices, edges or faces, by kind; -1 for the others
  bool closed = false;
  std::vector<ShapeUse> children;
};

struct Model {
  std::vector<Curve2> curves2;
  std::vector<Curve3> curves3;
  std::vector<Surface> surfaces;
  std::vector<Transform> locations;
  std::vector<Mesh> meshes;
  std::vector<VertexData> vertices;
  std::vector<EdgeData> edges;
  std::vector<FaceData> faces;
  // In the order of the stream: shapes[i] is the importer's index i + 1. A shape's children stand at
  // smaller positions (children first), so the graph has no cycles.
  std::vector<Shape> shapes;
};

}  // namespace trimray::brep
