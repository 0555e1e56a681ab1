#include "core/nurbs/store.h"

#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/nurbs/knot_vector.h"
#include "core/nurbs/mesh_store.h"

namespace trimray::nurbs {
namespace {

[[noreturn]] void fail(const char* what, std::size_t index) {
  throw FormatError("NURBS store: " + std::string(what) + " (at " + std::to_string(index) + ")");
}

template <typename T>
void check_range(const Range& r, const std::vector<T>& array, const char* what, std::size_t index) {
  if (r.begin < 0 || r.end < r.begin || static_cast<std::size_t>(r.end) > array.size()) fail(what, index);
}

template <typename T>
void check_index(std::int32_t i, const std::vector<T>& array, const char* what, std::size_t index) {
  if (i < 0 || static_cast<std::size_t>(i) >= array.size()) fail(what, index);
}

template <int N>
bool finite(const glm::vec<N, double>& v) {
  for (int i = 0; i < N; ++i)
    if (!std::isfinite(v[i])) return false;
  return true;
}

bool finite(const Box2& b) { return finite(b.lower) && finite(b.upper); }

void check_knots(const NurbsStore& store, const Range& r, int degree, int count, std::size_t index) {
  check_range(r, store.knots, "knot range out of bounds", index);
  if (degree < 1 || degree > kMaxDegree) fail("degree out of range", index);
  if (count <= degree || r.size() != static_cast<std::int64_t>(count) + degree + 1) fail("knot count", index);
  const double* k = store.knots.data() + r.begin;
  for (int i = 0; i < r.size(); ++i)
    if (!std::isfinite(k[i]) || (i > 0 && k[i] < k[i - 1])) fail("knots unsorted", index);
  if (k[0] != k[degree] || k[count] != k[count + degree]) fail("knots not clamped", index);
  // Every inner knot at most degree times, so that every basis function has a support.
  for (int i = 0; i < count; ++i)
    if (!(k[i + degree + 1] > k[i])) fail("knot multiplicity", index);
  for (int i = 1; i < count; ++i)
    if (!(k[i + degree] > k[i])) fail("knot multiplicity", index);
}

void check_conic(const NurbsStore& store, std::int32_t conic, std::size_t index) {
  if (conic >= 0) check_index(conic, store.conics, "conic", index);
}

void check_surface(const NurbsStore& store, std::size_t i) {
  const Surface& f = store.surfaces[i];
  if (f.kind > SurfaceKind::kNone || f.basis > SurfaceKind::kNone) fail("surface kind", i);
  check_conic(store, f.conic, i);
  if (f.kind == SurfaceKind::kMesh || f.kind == SurfaceKind::kNone) return;
  if (f.map_u > ParamMap::kHyperbolic || f.map_v > ParamMap::kHyperbolic) fail("parameter map", i);
  check_knots(store, f.knots_u, f.degree_u, f.count_u, i);
  check_knots(store, f.knots_v, f.degree_v, f.count_v, i);
  check_range(f.ctrl, store.ctrl_h, "control point range", i);
  if (f.ctrl.size() != static_cast<std::int64_t>(f.count_u) * f.count_v) fail("control point count", i);
  for (std::int32_t k = f.ctrl.begin; k < f.ctrl.end; ++k)
    if (!finite(store.ctrl_h[k]) || !(store.ctrl_h[k].w > 0.0)) fail("control point", i);
  if (f.periodic_u != (f.period_u > 0.0) || f.periodic_v != (f.period_v > 0.0)) fail("period", i);
  if (!std::isfinite(f.offset) || !std::isfinite(f.period_u) || !std::isfinite(f.period_v))
    fail("surface numbers", i);
  if (!finite(f.domain) || f.domain.empty()) fail("surface domain", i);
  if (!finite(f.location) || !finite(f.x_axis) || !finite(f.y_axis) || !finite(f.z_axis) ||
      !std::isfinite(f.r1) || !std::isfinite(f.r2) || !std::isfinite(f.semi_angle))
    fail("surface frame", i);
}

template <typename H>
void check_pieces(const std::vector<CurvePiece>& pieces, const std::vector<H>& ctrl, const char* what) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const CurvePiece& p = pieces[i];
    check_range(p.ctrl, ctrl, what, i);
    if (p.ctrl.size() < 2 || p.ctrl.size() > kMaxDegree + 1) fail(what, i);
    if (!std::isfinite(p.t0) || !std::isfinite(p.t1)) fail(what, i);
  }
  for (std::size_t i = 0; i < ctrl.size(); ++i)
    if (!finite(ctrl[i]) || !(ctrl[i][H::length() - 1] > 0.0)) fail(what, i);
}

void check_edges(const NurbsStore& store) {
  for (std::size_t i = 0; i < store.edges.size(); ++i) {
    const Edge& e = store.edges[i];
    check_range(e.pieces, store.edge_pieces, "edge pieces", i);
    check_range(e.coedges, store.edge_coedges, "edge co-edges", i);
    check_conic(store, e.conic, i);
    check_index(e.vertex[0], store.vertices, "edge vertex", i);
    check_index(e.vertex[1], store.vertices, "edge vertex", i);
    if (!std::isfinite(e.tolerance) || !std::isfinite(e.band) || e.band < 0.0) fail("edge band", i);
    if (!e.degenerate && e.pieces.size() == 0) fail("edge without path", i);
    for (std::int32_t k = e.coedges.begin; k < e.coedges.end; ++k) {
      check_index(store.edge_coedges[k], store.coedges, "edge co-edge", i);
      if (store.coedges[store.edge_coedges[k]].edge != static_cast<std::int32_t>(i)) fail("edge co-edge", i);
    }
  }
  for (std::size_t i = 0; i < store.conics.size(); ++i) {
    const Conic& c = store.conics[i];
    if (c.kind > ConicKind::kHyperbola) fail("conic kind", i);
    if (!finite(c.location) || !finite(c.x_axis) || !finite(c.y_axis)) fail("conic", i);
    if (!std::isfinite(c.r1) || !std::isfinite(c.r2)) fail("conic", i);
  }
  for (std::size_t i = 0; i < store.vertices.size(); ++i)
    if (!finite(store.vertices[i].point) || !std::isfinite(store.vertices[i].tolerance)) fail("vertex", i);
}

// Triangles stand in the order of the faces, so that no two faces can claim the same ones.
void check_mesh(const NurbsStore& store) {
  std::int32_t last = 0;
  for (std::size_t i = 0; i < store.faces.size(); ++i) {
    const Face& f = store.faces[i];
    check_range(f.triangles, store.mesh_triangles, "face triangles", i);
    const bool mesh_kind = store.surfaces[f.surface].kind == SurfaceKind::kMesh;
    if (f.is_mesh() != (mesh_kind && f.status == FaceStatus::kOk)) fail("mesh face", i);
    if (!f.is_mesh()) continue;
    if (f.triangles.begin < last) fail("triangles of another face", i);
    last = f.triangles.end;
    if (f.loops.size() != 0 || f.reversed) fail("mesh face", i);
  }
  for (std::size_t i = 0; i < store.mesh_triangles.size(); ++i)
    for (const std::int32_t v : store.mesh_triangles[i])
      check_index(v, store.mesh_vertices, "mesh triangle corner", i);
  for (std::size_t i = 0; i < store.mesh_vertices.size(); ++i)
    if (!sound_vertex(store.mesh_vertices[i])) fail("mesh vertex", i);
}

void check_faces(const NurbsStore& store) {
  for (std::size_t i = 0; i < store.faces.size(); ++i) {
    const Face& f = store.faces[i];
    check_index(f.surface, store.surfaces, "face surface", i);
    check_index(f.prototype, store.prototypes, "face prototype", i);
    check_index(f.shell, store.shells, "face shell", i);
    check_range(f.loops, store.loops, "face loops", i);
    if (f.status > FaceStatus::kUnsupported) fail("face status", i);
    if (f.status == FaceStatus::kOk && store.surfaces[f.surface].kind == SurfaceKind::kNone)
      fail("face without surface", i);
    if (f.status == FaceStatus::kOk && (!finite(f.uv_box) || f.uv_box.empty())) fail("face uv box", i);
    for (std::int32_t l = f.loops.begin; l < f.loops.end; ++l)
      if (store.loops[l].face != static_cast<std::int32_t>(i)) fail("loop of another face", i);
  }
  for (std::size_t i = 0; i < store.loops.size(); ++i) {
    const Loop& loop = store.loops[i];
    check_index(loop.face, store.faces, "loop face", i);
    check_range(loop.coedges, store.coedges, "loop co-edges", i);
    for (std::int32_t c = loop.coedges.begin; c < loop.coedges.end; ++c)
      if (store.coedges[c].loop != static_cast<std::int32_t>(i)) fail("co-edge of another loop", i);
  }
  for (std::size_t i = 0; i < store.coedges.size(); ++i) {
    const CoEdge& c = store.coedges[i];
    check_index(c.edge, store.edges, "co-edge edge", i);
    check_index(c.loop, store.loops, "co-edge loop", i);
    check_index(c.face, store.faces, "co-edge face", i);
    if (store.loops[c.loop].face != c.face) fail("co-edge face", i);
    check_range(c.pieces, store.trim_pieces, "co-edge pieces", i);
    if (c.pieces.size() == 0) fail("co-edge without pieces", i);
    check_conic(store, c.conic, i);
  }
}

void check_prototypes(const NurbsStore& store) {
  for (std::size_t i = 0; i < store.prototypes.size(); ++i) {
    const Prototype& p = store.prototypes[i];
    check_range(p.faces, store.faces, "prototype faces", i);
    check_range(p.edges, store.edges, "prototype edges", i);
    check_range(p.vertices, store.vertices, "prototype vertices", i);
    check_range(p.shells, store.shells, "prototype shells", i);
    for (std::int32_t k = p.faces.begin; k < p.faces.end; ++k)
      if (store.faces[k].prototype != static_cast<std::int32_t>(i)) fail("face of another prototype", i);
    for (std::int32_t k = p.edges.begin; k < p.edges.end; ++k)
      for (const std::int32_t v : store.edges[k].vertex)
        if (v < p.vertices.begin || v >= p.vertices.end) fail("vertex of another prototype", i);
    for (const dvec3& corner : {p.bounds.lower, p.bounds.upper})
      if (!p.bounds.empty() && !finite(corner)) fail("prototype bounds", i);
  }
  for (std::size_t i = 0; i < store.shells.size(); ++i) {
    check_index(store.shells[i].prototype, store.prototypes, "shell prototype", i);
    check_range(store.shells[i].faces, store.faces, "shell faces", i);
  }
  for (std::size_t i = 0; i < store.instances.size(); ++i) {
    const Instance& n = store.instances[i];
    check_index(n.prototype, store.prototypes, "instance prototype", i);
    for (int c = 0; c < 3; ++c)
      if (!finite(n.placement.linear[c])) fail("instance placement", i);
    if (!finite(n.placement.translation)) fail("instance placement", i);
  }
  // A co-edge's edge lies in its face's prototype.
  for (std::size_t i = 0; i < store.coedges.size(); ++i) {
    const Range& edges = store.prototypes[store.faces[store.coedges[i].face].prototype].edges;
    if (store.coedges[i].edge < edges.begin || store.coedges[i].edge >= edges.end)
      fail("edge of another prototype", i);
  }
}

}  // namespace

const char* kind_name(SurfaceKind kind) {
  static const char* const names[] = {"plane",      "cylinder", "cone",    "sphere", "torus", "extrusion",
                                      "revolution", "bezier",   "bspline", "offset", "mesh",  "none"};
  return kind <= SurfaceKind::kNone ? names[static_cast<int>(kind)] : "none";
}

const char* status_reason(FaceStatus status) {
  switch (status) {
    case FaceStatus::kOk:
      return "ok";
    case FaceStatus::kNoSurface:
      return "neither a surface nor triangles";
    case FaceStatus::kBadSurface:
      return "invalid surface (not finite, far off, weights <= 0 or unsorted knots)";
    case FaceStatus::kBadTrim:
      return "boundary curves are missing, unusable, off the surface or enclose nothing";
    case FaceStatus::kUnsupported:
      return "surface kind without an exact form";
  }
  return "unknown";
}

void validate(const NurbsStore& store) {
  for (std::size_t i = 0; i < store.surfaces.size(); ++i) check_surface(store, i);
  check_pieces(store.trim_pieces, store.trim_ctrl_h, "trim piece");
  check_pieces(store.edge_pieces, store.edge_ctrl_h, "edge piece");
  check_edges(store);
  check_faces(store);
  check_mesh(store);
  check_prototypes(store);
}

}  // namespace trimray::nurbs
