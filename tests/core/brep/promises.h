// What a parsed Model promises (core/brep/topology.h), as a check shared by tests and fuzzers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/brep/topology.h"

namespace trimray::testing {

struct BrokenPromise : std::logic_error {
  using std::logic_error::logic_error;
};

inline void promise(bool holds, const char* what) {
  if (!holds) throw BrokenPromise(std::string("broken promise of the B-rep parser: ") + what);
}

// -1 (absent) or an index below size.
inline void promise_optional(std::int32_t i, std::size_t size, const char* what) {
  promise(i >= -1 && i < static_cast<std::int64_t>(size), what);
}
inline void promise_index(std::int32_t i, std::size_t size, const char* what) {
  promise(i >= 0 && i < static_cast<std::int64_t>(size), what);
}

inline void promise_knots(const std::vector<double>& knots, const std::vector<std::int32_t>& multiplicities,
                          int degree, bool periodic, std::int64_t poles) {
  promise(degree >= 1 && degree <= brep::kMaxDegree, "degree");
  promise(knots.size() >= 2 && knots.size() == multiplicities.size(), "knots");
  std::int64_t sum = 0;
  for (const std::int32_t m : multiplicities) {
    promise(m >= 1 && m <= degree + 1, "multiplicity");
    sum += m;
  }
  promise(poles == sum - (periodic ? multiplicities.back() : degree + 1), "number of poles");
}

template <typename Vec>
void promise_curves(const std::vector<brep::Curve<Vec>>& curves) {
  using brep::CurveKind;
  std::vector<int> depth(curves.size());
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const brep::Curve<Vec>& c = curves[i];
    if (c.kind == CurveKind::kTrimmed || c.kind == CurveKind::kOffset) {
      promise_index(c.basis, i, "basis curve");
      depth[i] = depth[c.basis] + 1;
      promise(depth[i] <= brep::kMaxBasisDepth, "depth of basis curves");
    } else {
      promise(c.basis == -1, "basis curve");
    }
    if (c.kind != CurveKind::kBezier && c.kind != CurveKind::kBspline) continue;
    promise(c.weights.size() == (c.rational ? c.poles.size() : 0), "weights");
    promise_knots(c.knots, c.multiplicities, c.degree, c.periodic, static_cast<std::int64_t>(c.poles.size()));
  }
}

inline void promise_surfaces(const brep::Model& model) {
  using brep::SurfaceKind;
  std::vector<int> depth(model.surfaces.size());
  for (std::size_t i = 0; i < model.surfaces.size(); ++i) {
    const brep::Surface& s = model.surfaces[i];
    if (s.kind == SurfaceKind::kTrimmed || s.kind == SurfaceKind::kOffset) {
      promise_index(s.basis, i, "basis surface");
      depth[i] = depth[s.basis] + 1;
      promise(depth[i] <= brep::kMaxBasisDepth, "depth of basis surfaces");
    } else {
      promise(s.basis == -1, "basis surface");
    }
    if (s.kind == SurfaceKind::kExtrusion || s.kind == SurfaceKind::kRevolution) {
      promise_index(s.basis_curve, model.curves3.size(), "curve of a swept surface");
    }
    if (s.kind != SurfaceKind::kBezier && s.kind != SurfaceKind::kBspline) continue;
    promise(static_cast<std::int64_t>(s.poles.size()) == std::int64_t{s.count_u} * s.count_v, "pole grid");
    promise(s.weights.size() == (s.rational_u || s.rational_v ? s.poles.size() : 0), "weights");
    promise_knots(s.knots_u, s.multiplicities_u, s.degree_u, s.periodic_u, s.count_u);
    promise_knots(s.knots_v, s.multiplicities_v, s.degree_v, s.periodic_v, s.count_v);
  }
}

inline void promise_shapes(const brep::Model& model) {
  using brep::ShapeKind;
  std::vector<int> depth(model.shapes.size());
  std::vector<std::int64_t> uses(model.shapes.size());
  for (std::size_t i = 0; i < model.shapes.size(); ++i) {
    const brep::Shape& shape = model.shapes[i];
    if (shape.kind == ShapeKind::kVertex) {
      promise_index(shape.data, model.vertices.size(), "vertex");
    } else if (shape.kind == ShapeKind::kEdge) {
      promise_index(shape.data, model.edges.size(), "edge");
    } else if (shape.kind == ShapeKind::kFace) {
      promise_index(shape.data, model.faces.size(), "face");
    } else {
      promise(shape.data == -1, "data of a shape without geometry");
    }
    for (const brep::ShapeUse& use : shape.children) {
      promise_index(use.shape, i, "child");
      promise_optional(use.location, model.locations.size(), "location of a child");
      const ShapeKind kind = model.shapes[use.shape].kind;
      promise(shape.kind == ShapeKind::kCompound || kind > shape.kind, "kind of a child");
      depth[i] = std::max(depth[i], depth[use.shape] + 1);
      uses[i] += 1 + uses[use.shape];
    }
    promise(uses[i] <= brep::kMaxShapeUses, "number of uses");
    promise(depth[i] <= brep::kMaxShapeDepth, "depth of shapes");
  }
}

// Throws BrokenPromise.
inline void check_promises(const brep::Model& model) {
  promise_curves(model.curves2);
  promise_curves(model.curves3);
  promise_surfaces(model);
  promise_shapes(model);
  for (const brep::EdgeData& edge : model.edges) {
    promise_optional(edge.curve3, model.curves3.size(), "3D curve");
    promise_optional(edge.location, model.locations.size(), "location of a curve");
    for (const brep::PCurve& p : edge.pcurves) {
      promise_index(p.curve, model.curves2.size(), "p-curve");
      promise_optional(p.curve2, model.curves2.size(), "second p-curve");
      promise_index(p.surface, model.surfaces.size(), "surface of a p-curve");
      promise_optional(p.location, model.locations.size(), "location of a p-curve");
    }
  }
  for (const brep::FaceData& face : model.faces) {
    promise_optional(face.surface, model.surfaces.size(), "surface of a face");
    promise_optional(face.location, model.locations.size(), "location of a face");
    promise_optional(face.mesh, model.meshes.size(), "triangulation of a face");
  }
  for (const brep::Mesh& mesh : model.meshes) {
    promise(mesh.normals.empty() || mesh.normals.size() == mesh.nodes.size(), "normals of a triangulation");
    for (const auto& triangle : mesh.triangles)
      for (const std::int32_t v : triangle) promise_index(v, mesh.nodes.size(), "node of a triangle");
  }
}

}  // namespace trimray::testing
