// NurbsStore: every face of a model as an exact trimmed NURBS surface, in flat arrays.
//
// Ranges are half-open index ranges into the array named beside them. Lengths are mm and angles radians,
// in the coordinates of the face's prototype; an instance places a prototype in the world.
// uv_face is the (u, v) of the file's surface (angles for circular directions) and the only uv that
// leaves the library. The NURBS form lives over the same uv_face knots; between two knots of a circular
// direction its parameter s differs from u by the ParamMap, and equals it at every knot.
//
// A store is immutable after build_store/load_store returns it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/box.h"
#include "core/base/types.h"

namespace trimray::nurbs {

struct Range {
  std::int32_t begin = 0, end = 0;
  std::int32_t size() const { return end - begin; }
};

// The analytic kind keeps the formulas of core/brep/topology.h.
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
  kOffset,
  kMesh,  // triangles in place of a surface
  kNone
};
const char* kind_name(SurfaceKind kind);  // "plane", "cylinder", ... "mesh"

// How the NURBS parameter s runs between two neighbouring knots [a, a + d], m = a + d / 2:
//   kIdentity    s = u
//   kCircular    s = a + d/2 (1 + tan((u - m)/2) / tan(d/4))      circles and ellipses
//   kHyperbolic  the same with tanh                               hyperbolas
enum class ParamMap : std::uint8_t { kIdentity, kCircular, kHyperbolic };

// A conic of the file by its own formula (core/brep/topology.h), beside its exact rational pieces: only the
// formula tells which point of a piece belongs to a parameter. x_axis and y_axis are unit and normal to each
// other. For a conic in uv_face all z are 0.
enum class ConicKind : std::uint8_t { kCircle, kEllipse, kParabola, kHyperbola };
struct Conic {
  ConicKind kind = ConicKind::kCircle;
  dvec3 location{0.0}, x_axis{0.0}, y_axis{0.0};
  double r1 = 0.0, r2 = 0.0;
};

// One surface per face. Analytic frame and radii are set for kPlane ... kTorus, the direction (z_axis) for
// kExtrusion, the axis (location, z_axis) for kRevolution, if the shape is in its place by a rigid motion;
// the NURBS form is set for every kind but kMesh and kNone. For kOffset the NURBS form and the frame are the
// basis surface's, and the true point is S(u,v) + offset * Su x Sv / |Su x Sv|: it has no exact NURBS form
// and is evaluated from this definition.
struct Surface {
  SurfaceKind kind = SurfaceKind::kNone;
  SurfaceKind basis = SurfaceKind::kNone;  // what the NURBS form is of: kind, but for kOffset
  std::int32_t conic = -1;                 // NurbsStore::conics: the curve that a sweep moves, -1: no conic
  bool rational = false;
  bool periodic_u = false, periodic_v = false;  // of the file's surface, in uv_face
  ParamMap map_u = ParamMap::kIdentity, map_v = ParamMap::kIdentity;
  std::int32_t degree_u = 0, degree_v = 0;
  std::int32_t count_u = 0, count_v = 0;  // control points
  Range knots_u, knots_v;                 // NurbsStore::knots; clamped, count + degree + 1 values
  Range ctrl;                             // NurbsStore::ctrl_h, [iu * count_v + iv]
  double period_u = 0.0, period_v = 0.0;  // 0 unless periodic
  double offset = 0.0;                    // kOffset only
  Box2 domain;  // uv_face over which the NURBS form holds: the face's uv box plus a margin
  dvec3 location{0.0}, x_axis{0.0}, y_axis{0.0}, z_axis{0.0};
  double r1 = 0.0, r2 = 0.0, semi_angle = 0.0;
};

// Rational Bezier pieces, control points homogeneous. A piece covers [t0, t1] of the edge's parameter,
// which is linear in the piece's own [0, 1] only where the curve is polynomial.
struct CurvePiece {
  Range ctrl;  // edges: NurbsStore::edge_ctrl_h; trims: NurbsStore::trim_ctrl_h. degree = ctrl.size() - 1
  double t0 = 0.0, t1 = 0.0;
};

// An edge and its exact 3D curve, the one truth about where its faces meet.
//
// Its path runs vertex[0] -> first piece's start -> ... -> last piece's end -> vertex[1], the two links
// being straight; every face that uses the edge uses this same path, so the paths of a closed shell
// cancel exactly. band: no point of any of its faces' p-curves, put on the face's surface, and no link
// is farther from the path than this (measured, then widened by a safety factor; at least kMinBand of
// the prototype's diagonal).
struct Edge {
  Range pieces;  // NurbsStore::edge_pieces; empty for a degenerate edge
  std::int32_t vertex[2] = {-1, -1};
  Range coedges;            // NurbsStore::edge_coedges
  std::int32_t conic = -1;  // NurbsStore::conics, at the parameters of the pieces; -1: no conic
  double tolerance = 0.0;   // as the file says
  double band = 0.0;
  bool degenerate = false;  // a pole or apex: its path is one point
  bool smooth = false;      // faces meet tangentially
};

struct Vertex {
  dvec3 point{0.0};
  double tolerance = 0.0;
};

// One use of an edge by a loop, with the edge's image in the face's uv.
// The trim pieces already run in the loop's direction (reversed uses are turned round), and joined with
// straight links end -> next start they form a closed curve in uv_face, seam jumps excepted.
struct CoEdge {
  std::int32_t edge = -1, loop = -1, face = -1;
  bool reversed = false;    // runs against the edge's path
  bool seam = false;        // the same face uses this edge twice
  Range pieces;             // NurbsStore::trim_pieces
  std::int32_t conic = -1;  // NurbsStore::conics, at the parameters of the pieces; -1: no conic
};

struct Loop {
  std::int32_t face = -1;
  Range coedges;  // NurbsStore::coedges, in order along the loop
};

enum class FaceStatus : std::uint8_t {
  kOk,
  kNoSurface,    // and no triangles either
  kBadSurface,   // NaN or huge numbers, far from all edges, weights <= 0, unsorted knots
  kBadTrim,      // p-curves missing, unusable or far off their edges, or an empty uv box
  kUnsupported,  // a curve or surface kind without exact form or evaluator
};
const char* status_reason(FaceStatus status);  // "ok" or the reason a face cannot be drawn

// Corners, into NurbsStore::mesh_vertices, counter-clockwise seen from outside.
using Triangle = std::array<std::int32_t, 3>;

struct Face {
  std::int32_t surface = -1;  // NurbsStore::surfaces
  std::int32_t prototype = -1, shell = -1;
  std::int32_t shape = -1;  // index in the importer's byte stream (1-based), to trace a face to its file
  Range loops;              // NurbsStore::loops; empty: the whole natural domain
  Range triangles;          // NurbsStore::mesh_triangles; not empty for mesh faces and only for them
  FaceStatus status = FaceStatus::kOk;
  bool reversed = false;                 // outward normal is -(Su x Sv)
  bool iso_rectangle = false;            // the trim is exactly uv_box: no inside test needed
  Box2 uv_box;                           // of the trim curves, in uv_face
  float color[4] = {kNoColor, 0, 0, 1};  // sRGB-encoded, 0..1, straight alpha
  static constexpr float kNoColor = -1.0f;
  bool has_color() const { return color[0] >= 0.0f; }
  // A face of triangles: its surface is of kind kMesh, it has no loops and is never reversed, uv_box is the
  // unit square, and uv_face of a point is (weight of the second corner, weight of the third) in the triangle
  // that it lies on.
  bool is_mesh() const { return triangles.size() > 0; }
};

struct Shell {
  std::int32_t prototype = -1;
  Range faces;
  // Every edge is used exactly twice by the shell, in opposite directions, degenerate edges excepted; of a
  // shell of mesh faces, every side of its triangles.
  bool closed = false;
  bool lone = false;        // a face that the file puts into no shell
  std::int32_t solid = -1;  // number of its solid within the prototype, -1: of none
};

struct Prototype {
  Range faces, edges, vertices, shells;
  Box3 bounds;  // conservative, mm
  float color[4] = {Face::kNoColor, 0, 0, 1};
};

struct Instance {
  std::int32_t prototype = -1;
  Transform placement;  // prototype -> world
  float color[4] = {Face::kNoColor, 0, 0, 1};
};

// Colour of a face in an instance: the face's, else the instance's, else the prototype's.
struct NurbsStore {
  std::vector<Surface> surfaces;
  std::vector<double> knots;
  std::vector<dvec4> ctrl_h;  // (w x, w y, w z, w)
  std::vector<Conic> conics;
  std::vector<Face> faces;
  std::vector<Loop> loops;
  std::vector<CoEdge> coedges;
  std::vector<CurvePiece> trim_pieces;
  std::vector<dvec3> trim_ctrl_h;  // (w u, w v, w)
  std::vector<Edge> edges;
  std::vector<std::int32_t> edge_coedges;
  std::vector<CurvePiece> edge_pieces;
  std::vector<dvec4> edge_ctrl_h;
  std::vector<Vertex> vertices;
  std::vector<dvec3> mesh_vertices;      // of mesh faces
  std::vector<Triangle> mesh_triangles;  // by face, in the order of the faces
  std::vector<Shell> shells;
  std::vector<Prototype> prototypes;
  std::vector<Instance> instances;
  std::string meta;  // UTF-8 JSON of the importer: names, tree, unit, report. Carried, never read here.
};

// Checks every index, count and knot vector of a store; throws FormatError. A store that passes can be
// traced without reading out of bounds.
void validate(const NurbsStore& store);

// One file, versioned and checksummed. load_store throws FormatError on anything it did not write.
std::vector<std::byte> save_store(const NurbsStore& store);
NurbsStore load_store(std::span<const std::byte> bytes);

}  // namespace trimray::nurbs
