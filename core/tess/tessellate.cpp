#include "core/tess/tessellate.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <span>

#include "core/base/parallel.h"
#include "core/tess/face_mesh.h"
#include "core/tess/mesh_face.h"
#include "core/tess/triangle_bound.h"

namespace trimray::tess {

using nurbs::CoEdge;
using nurbs::Edge;
using nurbs::Face;
using nurbs::FaceStatus;
using nurbs::NurbsStore;
using nurbs::Prototype;

namespace {

constexpr int kRounds = 24, kSeparations = 6;

// A side of a triangle as its two vertices, for finding sides that more faces use than may.
struct SideUse {
  VertexKey low, high;
  std::int32_t face, triangle;
  std::int8_t side;
  bool forward;
};

class Tessellator {
 public:
  Tessellator(const NurbsStore& store, std::int32_t prototype, const ToleranceField& tolerance,
              const TessOptions& options)
      : store_(store),
        prototype_(store.prototypes[prototype]),
        limits_{&tolerance, options.angle},
        threads_(options.threads) {}

  Tessellation run() {
    const std::int32_t faces = prototype_.faces.size();
    charts_.resize(faces), meshes_.resize(faces), hints_.resize(faces);
    for (std::int32_t i = 0; i < faces; ++i) {
      const Face& f = face(i);
      if (f.status == FaceStatus::kOk && f.surface >= 0 && f.triangles.size() == 0)
        charts_[i] = std::make_unique<Chart>(store_, store_.surfaces[f.surface]);
    }
    make_trees();
    unite_vertices();
    sample_edges();
    std::vector<std::int32_t> todo;
    for (std::int32_t i = 0; i < faces; ++i)
      if (charts_[i]) todo.push_back(i);
    for (int round = 0; round < kRounds && !todo.empty(); ++round) {
      mesh(todo);
      todo = next(round + 1 < kRounds);
    }
    cover();
    return stitch();
  }

 private:
  const Face& face(std::int32_t i) const { return store_.faces[prototype_.faces.begin + i]; }

  void make_trees() {
    trees_.resize(charts_.size());
    parallel_ranges(charts_.size(), 4, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        if (charts_[i] && charts_[i]->surface().kind != nurbs::SurfaceKind::kPlane)
          trees_[i] =
              std::make_unique<CurvatureTree>(store_, *charts_[i], loops_box(static_cast<std::int32_t>(i)),
                                              *limits_.tolerance, limits_.angle);
    });
  }

  // Of a face's p-curves, in the chart.
  Box2 loops_box(std::int32_t i) const {
    const Face& f = face(i);
    Box2 box = f.uv_box;
    for (std::int32_t l = f.loops.begin; l < f.loops.end; ++l)
      for (std::int32_t c = store_.loops[l].coedges.begin; c < store_.loops[l].coedges.end; ++c)
        for (std::int32_t p = store_.coedges[c].pieces.begin; p < store_.coedges[c].pieces.end; ++p)
          for (std::int32_t k = store_.trim_pieces[p].ctrl.begin; k < store_.trim_pieces[p].ctrl.end; ++k) {
            const dvec3& h = store_.trim_ctrl_h[k];
            box.add(dvec2(h.x, h.y) / h.z);
          }
    return {charts_[i]->from_face(box.lower), charts_[i]->from_face(box.upper)};
  }

  // Synthetic edges have vertices of their own, and loops may be open within tolerance: vertices that follow
  // on one another at one place are one.
  void unite_vertices() {
    wireframe_.vertex_begin = prototype_.vertices.begin, wireframe_.edge_begin = prototype_.edges.begin;
    wireframe_.one.resize(prototype_.vertices.size());
    std::iota(wireframe_.one.begin(), wireframe_.one.end(), prototype_.vertices.begin);
    const double least = 1e-7 * prototype_.bounds.diagonal();
    for (std::int32_t i = 0; i < prototype_.faces.size(); ++i) {
      if (!charts_[i]) continue;
      const nurbs::Range& loops = face(i).loops;
      for (std::int32_t l = loops.begin; l < loops.end; ++l) {
        const nurbs::Range& coedges = store_.loops[l].coedges;
        for (std::int32_t c = coedges.begin; c < coedges.end; ++c) {
          const CoEdge &a = store_.coedges[c],
                       &b = store_.coedges[c + 1 < coedges.end ? c + 1 : coedges.begin];
          const Edge &from = store_.edges[a.edge], &to = store_.edges[b.edge];
          const std::int32_t v = from.vertex[a.reversed ? 0 : 1], w = to.vertex[b.reversed ? 1 : 0];
          if (v == w) continue;
          const nurbs::Vertex &p = store_.vertices[v], &q = store_.vertices[w];
          // Not so far that an edge between them would be swallowed.
          const double short_edge = 0.25 * std::min(from.degenerate ? kInf : length_bound(from),
                                                    to.degenerate ? kInf : length_bound(to));
          const double reach =
              std::min(2.0 * std::max({from.band, to.band, p.tolerance, q.tolerance}), short_edge);
          if (glm::distance(p.point, q.point) <= std::max(least, reach)) unite(v, w);
        }
      }
    }
    // An edge that has no length to speak of is a point.
    point_edges_.assign(prototype_.edges.size(), false);
    for (std::int32_t e = prototype_.edges.begin; e < prototype_.edges.end; ++e) {
      const Edge& edge = store_.edges[e];
      if (edge.degenerate || length_bound(edge) > least) continue;
      point_edges_[e - prototype_.edges.begin] = true;
      unite(edge.vertex[0], edge.vertex[1]);
    }
    for (std::size_t i = 0; i < wireframe_.one.size(); ++i)
      wireframe_.one[i] = root(static_cast<std::int32_t>(i) + wireframe_.vertex_begin);
  }

  // Of the box around an edge and its vertices.
  double length_bound(const Edge& edge) const {
    Box3 box;
    for (const std::int32_t v : edge.vertex) box.add(store_.vertices[v].point);
    for (std::int32_t p = edge.pieces.begin; p < edge.pieces.end; ++p)
      for (std::int32_t c = store_.edge_pieces[p].ctrl.begin; c < store_.edge_pieces[p].ctrl.end; ++c)
        box.add(dvec3(store_.edge_ctrl_h[c]) / store_.edge_ctrl_h[c].w);
    return box.diagonal();
  }

  std::int32_t root(std::int32_t v) const {
    while (wireframe_.one[v - wireframe_.vertex_begin] != v) v = wireframe_.one[v - wireframe_.vertex_begin];
    return v;
  }

  void unite(std::int32_t v, std::int32_t w) {
    v = root(v), w = root(w);
    wireframe_.one[std::max(v, w) - wireframe_.vertex_begin] = std::min(v, w);
  }

  void sample_edges() {
    const std::int32_t edges = prototype_.edges.size();
    wireframe_.polylines.resize(edges);
    parallel_ranges(edges, 8, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Edge& edge = store_.edges[prototype_.edges.begin + i];
        std::vector<EdgeUse> uses;
        for (std::int32_t k = edge.coedges.begin; k < edge.coedges.end; ++k) {
          const std::int32_t c = store_.edge_coedges[k];
          const std::int32_t f = store_.coedges[c].face - prototype_.faces.begin;
          if (!charts_[f]) continue;
          const bool bounded = needs_tree(charts_[f]->surface().kind);
          uses.push_back({charts_[f].get(), bounded ? trees_[f].get() : nullptr, c});
        }
        if (uses.empty() || point_edges_[i]) continue;
        // Vertices that are one stand at one place.
        const auto place = [&](std::int32_t v) {
          return store_.vertices[wireframe_.one[v - wireframe_.vertex_begin]].point;
        };
        const dvec3 ends[2] = {place(edge.vertex[0]), place(edge.vertex[1])};
        wireframe_.polylines[i] = make_polyline(store_, edge, ends, uses, limits_);
      }
    });
  }

  void mesh(const std::vector<std::int32_t>& todo) {
    parallel_ranges(todo.size(), 1, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::int32_t i = todo[k], f = prototype_.faces.begin + i;
        const FacePolygon polygon = make_polygon(store_, f, *charts_[i], wireframe_, limits_);
        meshes_[i] = mesh_face(store_, f, *charts_[i], trees_[i].get(), polygon, limits_, hints_[i]);
      }
    });
  }

  // Grants what faces ask for; returns those that must be meshed again.
  std::vector<std::int32_t> next(bool more) {
    std::vector<std::array<std::int32_t, 2>> split;
    std::vector<bool> again(meshes_.size(), false);
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      FaceMesh& m = meshes_[i];
      split.insert(split.end(), m.split.begin(), m.split.end());
      hints_[i].points.insert(hints_[i].points.end(), m.found.begin(), m.found.end());
      hints_[i].crossings += m.crossed;
      m.found.clear(), m.split.clear(), m.crossed = false;
    }
    if (split.empty() && separations_++ < kSeparations) separate(split, again);
    if (!more) return {};
    std::sort(split.begin(), split.end());
    split.erase(std::unique(split.begin(), split.end()), split.end());
    for (std::size_t i = 0; i < split.size();) {
      const std::int32_t e = split[i][0];
      EdgePolyline& line = wireframe_.polylines[e - wireframe_.edge_begin];
      std::vector<Cut> cuts;
      for (; i < split.size() && split[i][0] == e; ++i) {
        const int k = split[i][1];
        if (line.segments() > kMostSegments || line.at[k + 1] - line.at[k] < 1e-9 * line.at.back()) continue;
        cuts.push_back({k, 0.5 * (line.at[k] + line.at[k + 1])});
      }
      if (cuts.empty()) continue;
      const Edge& edge = store_.edges[e];
      split_segments(store_, edge, cuts, line);
      for (std::int32_t k = edge.coedges.begin; k < edge.coedges.end; ++k)
        again[store_.coedges[store_.edge_coedges[k]].face - prototype_.faces.begin] = true;
    }
    std::vector<std::int32_t> todo;
    for (std::size_t i = 0; i < again.size(); ++i)
      if (again[i] && charts_[i]) todo.push_back(static_cast<std::int32_t>(i));
    return todo;
  }

  // Two faces may draw a side between the same two vertices, though they do not meet there (a face so coarse
  // that it is as flat as its neighbour): such sides get a point more.
  void separate(std::vector<std::array<std::int32_t, 2>>& split, std::vector<bool>& again) {
    std::vector<SideUse> sides;
    for (std::size_t i = 0; i < meshes_.size(); ++i)
      for (std::size_t t = 0; t < meshes_[i].triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
          const VertexKey a = meshes_[i].triangles[t][k], b = meshes_[i].triangles[t][(k + 1) % 3];
          if (a < 0 || b < 0) continue;  // a face's own point: nobody else's side
          sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(i),
                           static_cast<std::int32_t>(t), static_cast<std::int8_t>(k), a < b});
        }
    std::sort(sides.begin(), sides.end(), [](const SideUse& a, const SideUse& b) {
      return std::tie(a.low, a.high, a.face, a.triangle, a.side) <
             std::tie(b.low, b.high, b.face, b.triangle, b.side);
    });
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
      int forward = 0;
      for (end = begin;
           end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high;
           ++end)
        forward += sides[end].forward;
      const int count = static_cast<int>(end - begin);
      if (count <= 2 && forward <= 1 && count - forward <= 1) continue;
      part({sides.data() + begin, static_cast<std::size_t>(count)}, split, again);
    }
  }

  // Sides across a face are the ones to give way; where all lie on edges, these are as coarse as to fall
  // together.
  void part(std::span<const SideUse> uses, std::vector<std::array<std::int32_t, 2>>& split,
            std::vector<bool>& again) {
    std::vector<std::array<std::int32_t, 2>> on_edges;
    bool across = false;
    for (const SideUse& s : uses) {
      const std::array<std::int32_t, 2> edge = segment_of(s);
      if (edge[0] >= 0) {
        on_edges.push_back(edge);
        continue;
      }
      across = true;
      const auto& uv = meshes_[s.face].corner_uv[s.triangle];
      const Chart& chart = *charts_[s.face];
      hints_[s.face].points.push_back(0.5 *
                                      (chart.from_face(uv[s.side]) + chart.from_face(uv[(s.side + 1) % 3])));
      again[s.face] = true;
    }
    if (across) return;
    std::sort(on_edges.begin(), on_edges.end());
    on_edges.erase(std::unique(on_edges.begin(), on_edges.end()), on_edges.end());
    // More faces than two on one edge is how the model is.
    if (on_edges.size() > 1) split.insert(split.end(), on_edges.begin(), on_edges.end());
  }

  // The edge and segment that a side lies on; -1 when it crosses the face.
  std::array<std::int32_t, 2> segment_of(const SideUse& s) const {
    const FaceMesh& m = meshes_[s.face];
    const VertexKey a = m.triangles[s.triangle][s.side], b = m.triangles[s.triangle][(s.side + 1) % 3];
    const Face& f = face(s.face);
    for (std::int32_t l = f.loops.begin; l < f.loops.end; ++l)
      for (std::int32_t c = store_.loops[l].coedges.begin; c < store_.loops[l].coedges.end; ++c) {
        const std::int32_t e = store_.coedges[c].edge;
        const int n = wireframe_.polyline(e).segments();
        const auto key = [&](int sample) {
          if (sample > 0 && sample < n) return inner_key(e, sample);
          return VertexKey{
              wireframe_.one[store_.edges[e].vertex[sample == 0 ? 0 : 1] - wireframe_.vertex_begin]};
        };
        for (int k = 0; k < n; ++k)
          if ((key(k) == a && key(k + 1) == b) || (key(k) == b && key(k + 1) == a)) return {e, k};
      }
    return {-1, -1};
  }

  void cover() {
    for (std::int32_t i = 0; i < prototype_.faces.size(); ++i) {
      if (!charts_[i]) continue;
      FaceMesh& m = meshes_[i];
      if (m.failure.empty()) continue;
      result_.issues.push_back({prototype_.faces.begin + i, m.failure});
      if (!m.triangles.empty()) continue;
      const FacePolygon polygon =
          make_polygon(store_, prototype_.faces.begin + i, *charts_[i], wireframe_, limits_);
      m = cover_face(store_, prototype_.faces.begin + i, *charts_[i], polygon);
    }
  }

  Tessellation stitch() {
    TriMesh& out = result_.mesh;
    std::size_t triangles = 0;
    for (const FaceMesh& m : meshes_) triangles += m.triangles.size();
    out.triangles.reserve(triangles), out.corner_uv.reserve(triangles), out.face.reserve(triangles),
        out.deviation.reserve(triangles);
    std::vector<std::int32_t> of_vertex(prototype_.vertices.size(), -1);
    std::vector<std::vector<std::int32_t>> of_sample(wireframe_.polylines.size());
    const auto place = [&](std::int32_t& number, const dvec3& p) {
      if (number < 0) number = static_cast<std::int32_t>(out.vertices.size()), out.vertices.push_back(p);
      return number;
    };
    for (std::int32_t i = 0; i < prototype_.faces.size(); ++i) {
      if (face(i).triangles.size() > 0) mesh_faces_.add(store_, prototype_.faces.begin + i, out);
      const FaceMesh& m = meshes_[i];
      std::vector<std::int32_t> own(m.own_vertices.size(), -1);
      for (std::size_t t = 0; t < m.triangles.size(); ++t) {
        std::array<std::int32_t, 3> corner;
        for (int k = 0; k < 3; ++k) {
          const VertexKey key = m.triangles[t][k];
          if (key < 0) {
            corner[k] = place(own[-1 - key], m.own_vertices[-1 - key]);
          } else if (key < kInnerSample) {
            corner[k] = place(of_vertex[key - wireframe_.vertex_begin], store_.vertices[key].point);
          } else {
            const EdgePolyline& line = wireframe_.polyline(key_edge(key));
            auto& numbers = of_sample[key_edge(key) - wireframe_.edge_begin];
            numbers.resize(line.points.size(), -1);
            corner[k] = place(numbers[key_sample(key)], line.points[key_sample(key)]);
          }
        }
        out.triangles.push_back(corner);
        out.corner_uv.push_back(m.corner_uv[t]);
        out.face.push_back(prototype_.faces.begin + i);
        out.deviation.push_back(m.deviation[t]);
      }
    }
    return std::move(result_);
  }

  const NurbsStore& store_;
  const Prototype& prototype_;
  EdgeLimits limits_;
  int threads_;
  Wireframe wireframe_;
  std::vector<bool> point_edges_;
  std::vector<std::unique_ptr<Chart>> charts_;
  std::vector<std::unique_ptr<CurvatureTree>> trees_;
  std::vector<FaceMesh> meshes_;
  std::vector<FaceHints> hints_;
  MeshFaces mesh_faces_;
  Tessellation result_;
  int separations_ = 0;
};

}  // namespace

Tessellation tessellate(const NurbsStore& store, std::int32_t prototype, const ToleranceField& tolerance,
                        const TessOptions& options) {
  return Tessellator(store, prototype, tolerance, options).run();
}

}  // namespace trimray::tess
