#include "core/tess/half_edge.h"

#include <algorithm>
#include <deque>

#include <OpenMesh/Core/System/omstream.hh>

#include "core/base/box.h"
#include "core/base/error.h"
#include "core/tess/mesh_check.h"

namespace trimray::tess {
namespace {

// A flip must lower the deviation by this fraction: rounding alone must not make flips.
constexpr double kWorthwhile = 1e-6;
// Share of a quadrilateral's area in uv below which one of its triangles counts as turned over.
constexpr double kFlatInUv = 1e-9;

// OpenMesh says on std::cerr what it refuses; we say it in our own way. For good: other threads mesh, too.
void silence_openmesh() {
  static const bool done = (::omerr().disable(), true);
  static_cast<void>(done);
}

double cross(dvec2 a, dvec2 b) { return a.x * b.y - a.y * b.x; }
double uv_area(const std::array<dvec2, 3>& t) { return 0.5 * cross(t[1] - t[0], t[2] - t[0]); }

class Flipper {
 public:
  Flipper(TriMesh& mesh, const DeviationProof& proof, double enough)
      : mesh_(mesh), proof_(proof), enough_(enough), half_(half_edges(mesh)) {
    Box3 box;
    for (const dvec3& p : mesh.vertices) box.add(p);
    least_height_ = kDegenerateHeight * box.diagonal();
    // What the half-edge mesh does not hold it cannot keep from being doubled.
    frozen_.assign(mesh.vertices.size(), false);
    for (const std::int32_t t : half_.refused)
      for (const std::int32_t v : mesh.triangles[t]) frozen_[v] = true;
  }

  std::int64_t run() {
    HalfEdgeKernel& kernel = half_.kernel;
    std::deque<int> queue;
    std::vector<bool> queued(kernel.n_edges(), true);
    for (std::size_t e = 0; e < kernel.n_edges(); ++e) queue.push_back(static_cast<int>(e));
    std::int64_t flips = 0;
    // The sorted deviations fall with every flip, so this ends; the limit guards against a proof that
    // gives two answers for one triangle.
    const std::int64_t most = 16 * static_cast<std::int64_t>(kernel.n_edges());
    while (!queue.empty() && flips < most) {
      const OpenMesh::EdgeHandle edge(queue.front());
      queue.pop_front();
      queued[edge.idx()] = false;
      if (!try_flip(edge)) continue;
      ++flips;
      for (int side = 0; side < 2; ++side) {
        const auto h = kernel.halfedge_handle(edge, side);
        for (const auto around : {kernel.next_halfedge_handle(h), kernel.prev_halfedge_handle(h)}) {
          const int e = kernel.edge_handle(around).idx();
          if (!queued[e]) queue.push_back(e), queued[e] = true;
        }
      }
    }
    return flips;
  }

 private:
  // The two triangles of an edge as a quadrilateral:
  //
  //        c
  //       / \        old: (a, b, c), (b, a, d)
  //      a---b       new: (a, d, c), (d, b, c)
  //       \ /
  //        d
  struct Quad {
    std::int32_t first = -1, second = -1;  // triangles
    std::int32_t a = -1, b = -1, c = -1, d = -1;
    dvec2 uv_a{0.0}, uv_b{0.0}, uv_c{0.0}, uv_d{0.0};
  };

  int corner_of(std::int32_t triangle, std::int32_t vertex) const {
    const auto& t = mesh_.triangles[triangle];
    return t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
  }

  bool quad_at(OpenMesh::EdgeHandle edge, Quad& q) const {
    const HalfEdgeKernel& kernel = half_.kernel;
    const auto h = kernel.halfedge_handle(edge, 0), o = kernel.halfedge_handle(edge, 1);
    const auto fh = kernel.face_handle(h), fo = kernel.face_handle(o);
    if (!fh.is_valid() || !fo.is_valid()) return false;
    q.first = half_.triangles[fh.idx()], q.second = half_.triangles[fo.idx()];
    if (mesh_.face[q.first] != mesh_.face[q.second]) return false;
    q.a = kernel.from_vertex_handle(h).idx(), q.b = kernel.to_vertex_handle(h).idx();
    q.c = kernel.to_vertex_handle(kernel.next_halfedge_handle(h)).idx();
    q.d = kernel.to_vertex_handle(kernel.next_halfedge_handle(o)).idx();
    for (const std::int32_t v : {q.a, q.b, q.c, q.d})
      if (frozen_[v]) return false;
    const auto uv = [&](std::int32_t t, std::int32_t v) { return mesh_.corner_uv[t][corner_of(t, v)]; };
    q.uv_a = uv(q.first, q.a), q.uv_b = uv(q.first, q.b);
    q.uv_c = uv(q.first, q.c), q.uv_d = uv(q.second, q.d);
    // One place with two uv: a seam or a pole, where the two triangles are not neighbours in uv.
    return q.uv_a == uv(q.second, q.a) && q.uv_b == uv(q.second, q.b);
  }

  bool keeps_shape(const Quad& q, const std::array<dvec2, 3>& uv0, const std::array<dvec2, 3>& uv1) const {
    const double before0 = uv_area({q.uv_a, q.uv_b, q.uv_c}), before1 = uv_area({q.uv_b, q.uv_a, q.uv_d});
    const double whole = before0 + before1, sign = whole > 0.0 ? 1.0 : -1.0;
    const double least = kFlatInUv * std::abs(whole);
    for (const double area : {before0, before1, uv_area(uv0), uv_area(uv1)})
      if (!(sign * area > least)) return false;
    const auto& p = mesh_.vertices;
    const dvec3 &a = p[q.a], &b = p[q.b], &c = p[q.c], &d = p[q.d];
    if (!(smallest_height(a, d, c) > least_height_) || !(smallest_height(d, b, c) > least_height_))
      return false;
    const dvec3 n0 = glm::cross(b - a, c - a), n1 = glm::cross(a - b, d - b);
    const dvec3 m0 = glm::cross(d - a, c - a), m1 = glm::cross(b - d, c - d);
    for (const dvec3& n : {n0, n1})
      for (const dvec3& m : {m0, m1})
        if (!(glm::dot(n, m) > 0.0)) return false;
    return true;
  }

  bool try_flip(OpenMesh::EdgeHandle edge) {
    Quad q;
    if (!quad_at(edge, q)) return false;
    const double before = std::max(mesh_.deviation[q.first], mesh_.deviation[q.second]);
    if (!(before > enough_ && before < kInf) || !half_.kernel.is_flip_ok(edge)) return false;
    const std::array<dvec2, 3> uv0{q.uv_a, q.uv_d, q.uv_c}, uv1{q.uv_d, q.uv_b, q.uv_c};
    if (!keeps_shape(q, uv0, uv1)) return false;
    const auto& p = mesh_.vertices;
    const std::int32_t face = mesh_.face[q.first];
    const double good = before * (1.0 - kWorthwhile);
    const double after0 = proof_(face, uv0, {p[q.a], p[q.d], p[q.c]});
    if (!(after0 < good)) return false;
    const double after1 = proof_(face, uv1, {p[q.d], p[q.b], p[q.c]});
    if (!(after1 < good)) return false;

    half_.kernel.flip(edge);
    // Which of the two faces the kernel gave to which triangle: the one that still has a.
    const auto h = half_.kernel.halfedge_handle(edge, 0);
    const auto apex = half_.kernel.to_vertex_handle(half_.kernel.next_halfedge_handle(h)).idx();
    const std::int32_t at_h = half_.triangles[half_.kernel.face_handle(h).idx()];
    const std::int32_t with_a = apex == q.a ? at_h : at_h == q.first ? q.second : q.first;
    const std::int32_t with_b = with_a == q.first ? q.second : q.first;
    mesh_.triangles[with_a] = {q.a, q.d, q.c}, mesh_.triangles[with_b] = {q.d, q.b, q.c};
    mesh_.corner_uv[with_a] = uv0, mesh_.corner_uv[with_b] = uv1;
    mesh_.deviation[with_a] = after0, mesh_.deviation[with_b] = after1;
    return true;
  }

  TriMesh& mesh_;
  const DeviationProof& proof_;
  double enough_;
  HalfEdgeMesh half_;
  double least_height_ = 0.0;
  std::vector<bool> frozen_;
};

}  // namespace

bool HalfEdgeMesh::closed_manifold() const {
  if (!refused.empty()) return false;
  for (const auto h : kernel.halfedges())
    if (kernel.is_boundary(h)) return false;
  return std::all_of(kernel.vertices_begin(), kernel.vertices_end(),
                     [&](const auto v) { return kernel.is_manifold(v); });
}

HalfEdgeMesh half_edges(const TriMesh& mesh) {
  silence_openmesh();
  HalfEdgeMesh result;
  HalfEdgeKernel& kernel = result.kernel;
  kernel.reserve(mesh.vertices.size(), 3 * mesh.triangles.size() / 2 + 1, mesh.triangles.size());
  for (const dvec3& p : mesh.vertices) kernel.add_vertex({p.x, p.y, p.z});
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    for (const std::int32_t v : t) {
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.vertices.size())
        throw ArgumentError("triangle " + std::to_string(i) + " names vertex " + std::to_string(v) + " of " +
                            std::to_string(mesh.vertices.size()));
    }
    const bool distinct = t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    OpenMesh::FaceHandle face;
    if (distinct) {
      using OpenMesh::VertexHandle;
      face = kernel.add_face(VertexHandle(t[0]), VertexHandle(t[1]), VertexHandle(t[2]));
    }
    (face.is_valid() ? result.triangles : result.refused).push_back(static_cast<std::int32_t>(i));
  }
  return result;
}

std::int64_t improve(TriMesh& mesh, const DeviationProof& proof, double enough) {
  return Flipper(mesh, proof, enough).run();
}

}  // namespace trimray::tess
