// What stands in for the mesh of a face whose loops cannot be triangulated.
#include <algorithm>
#include <cmath>
#include <map>

#include "core/tess/delaunay.h"
#include "core/tess/face_mesh.h"

namespace trimray::tess {
namespace {

void add(FaceMesh& out, const Chart& chart, bool reversed, std::array<VertexKey, 3> vertices,
         std::array<dvec2, 3> p) {
  if (vertices[0] == vertices[1] || vertices[1] == vertices[2] || vertices[2] == vertices[0]) return;
  if (reversed) std::swap(vertices[1], vertices[2]), std::swap(p[1], p[2]);
  out.triangles.push_back(vertices);
  out.corner_uv.push_back({chart.to_face(p[0]), chart.to_face(p[1]), chart.to_face(p[2])});
  out.deviation.push_back(kInf);
}

// Sides may cross: there are new points where they do, which the neighbours do not know.
bool cover_crossing(const Chart& chart, const FacePolygon& polygon, bool reversed, FaceMesh& out) {
  std::vector<dvec2> points;
  std::vector<VertexKey> keys;
  std::vector<std::array<int, 2>> sides;
  std::map<std::array<double, 2>, int> known;
  for (const auto& loop : polygon.loops) {
    std::vector<int> index;
    for (const BoundaryPoint& b : loop) {
      const std::array<double, 2> at{b.p.x, b.p.y};
      const auto [found, fresh] = known.try_emplace(at, static_cast<int>(points.size()));
      if (fresh) points.push_back(b.p), keys.push_back(b.vertex);
      index.push_back(found->second);
    }
    for (std::size_t i = 0; i < index.size(); ++i)
      if (index[i] != index[(i + 1) % index.size()])
        sides.push_back({index[i], index[(i + 1) % index.size()]});
  }
  const dvec2 scale = 1.0 / glm::max(polygon.box.extent(), dvec2(1e-300));
  for (dvec2& p : points) p *= scale;
  const Delaunay result = triangulate_crossing(points, sides);
  for (std::size_t i = keys.size(); i < points.size(); ++i) {
    out.own_vertices.push_back(chart.point(points[i] / scale));
    keys.push_back(-static_cast<VertexKey>(out.own_vertices.size()));
  }
  for (const auto& t : result.triangles)
    add(out, chart, reversed, {keys[t[0]], keys[t[1]], keys[t[2]]},
        {points[t[0]] / scale, points[t[1]] / scale, points[t[2]] / scale});
  return !out.triangles.empty();
}

// All of the box: more than the face, never less.
void cover_box(const Chart& chart, const Box2& uv_box, bool reversed, FaceMesh& out) {
  constexpr int kCells = 16;
  const Box2 box{chart.from_face(uv_box.lower), chart.from_face(uv_box.upper)};
  const auto at = [&](int i, int j) { return box.lower + box.extent() * dvec2(i, j) / double(kCells); };
  const auto first = static_cast<VertexKey>(out.own_vertices.size());
  for (int i = 0; i <= kCells; ++i)
    for (int j = 0; j <= kCells; ++j) out.own_vertices.push_back(chart.point(at(i, j)));
  const auto key = [&](int i, int j) { return -1 - (first + i * (kCells + 1) + j); };
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      add(out, chart, reversed, {key(i, j), key(i + 1, j), key(i, j + 1)},
          {at(i, j), at(i + 1, j), at(i, j + 1)});
      add(out, chart, reversed, {key(i + 1, j), key(i + 1, j + 1), key(i, j + 1)},
          {at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
}

}  // namespace

FaceMesh cover_face(const nurbs::NurbsStore& store, std::int32_t face, const Chart& chart,
                    const FacePolygon& polygon) {
  FaceMesh out;
  out.own_vertices = polygon.own_vertices;
  const nurbs::Face& f = store.faces[face];
  if (!cover_crossing(chart, polygon, f.reversed, out)) cover_box(chart, f.uv_box, f.reversed, out);
  return out;
}

}  // namespace trimray::tess
