// What verification asks of a mesh: measured distances from the exact surfaces and edges.
#include <cstring>

#include <nanobind/stl/pair.h>

#include "core/bind/bind.h"
#include "core/tess/edge_measure.h"
#include "core/tess/mesh_measure.h"

namespace trimray::bind {

namespace {

using Uv = nb::ndarray<const double, nb::shape<-1, 3, 2>, nb::c_contig, nb::device::cpu>;
using Dict = nb::typed<nb::dict, nb::str, nb::any>;

template <typename To, typename From>
void copy_rows(const From* from, std::size_t rows, std::vector<To>& to) {
  to.resize(rows);
  if (rows > 0) std::memcpy(static_cast<void*>(to.data()), from, rows * sizeof(To));
}

tess::TriMesh mesh_of(const In2<double, 3>& vertices, const In2<std::int32_t, 3>& triangles,
                      const Uv& corner_uv, const In1<std::int32_t>& face) {
  tess::TriMesh mesh;
  copy_rows(vertices.data(), vertices.shape(0), mesh.vertices);
  copy_rows(triangles.data(), triangles.shape(0), mesh.triangles);
  copy_rows(corner_uv.data(), corner_uv.shape(0), mesh.corner_uv);
  copy_rows(face.data(), face.shape(0), mesh.face);
  return mesh;
}

std::pair<Out<double>, Out<double>> measure_mesh(const nurbs::NurbsStore& store,
                                                 const In2<double, 3>& vertices,
                                                 const In2<std::int32_t, 3>& triangles, const Uv& corner_uv,
                                                 const In1<std::int32_t>& face, const In1<double>& enough,
                                                 int subdivisions, std::int64_t most_triangles,
                                                 std::uint64_t seed, int threads) {
  tess::TriMesh mesh = mesh_of(vertices, triangles, corner_uv, face);
  mesh.deviation = vector(enough);
  tess::DeviationMeasure m;
  {
    nb::gil_scoped_release release;
    m = tess::measure_deviation(store, mesh, {subdivisions, most_triangles, seed, threads});
  }
  const std::size_t count = m.to_surface.size();
  return {array(std::move(m.to_surface), {count}), array(std::move(m.from_surface), {count})};
}

Dict measure_mesh_edges(const nurbs::NurbsStore& store, const In2<double, 3>& vertices,
                        const In2<std::int32_t, 3>& triangles, const Uv& corner_uv,
                        const In1<std::int32_t>& face, int points, int threads) {
  const tess::TriMesh mesh = mesh_of(vertices, triangles, corner_uv, face);
  tess::EdgeMeasure m;
  {
    nb::gil_scoped_release release;
    m = tess::measure_edges(store, mesh, points, threads);
  }
  const std::size_t n = m.sides.size();
  std::vector<std::int32_t> triangle, corner, edge;
  std::vector<std::uint8_t> open;
  std::vector<double> from, to, edge_to_side, side_to_edge;
  for (const tess::BorderSide& s : m.sides) {
    triangle.push_back(s.triangle), corner.push_back(s.corner), edge.push_back(s.edge);
    open.push_back(s.open), from.push_back(s.from), to.push_back(s.to);
    edge_to_side.push_back(s.edge_to_side), side_to_edge.push_back(s.side_to_edge);
  }
  Dict d;
  d["triangle"] = array(std::move(triangle), {n}), d["corner"] = array(std::move(corner), {n});
  d["edge"] = array(std::move(edge), {n}), d["open"] = array(std::move(open), {n});
  d["from"] = array(std::move(from), {n}), d["to"] = array(std::move(to), {n});
  d["edge_to_side"] = array(std::move(edge_to_side), {n});
  d["side_to_edge"] = array(std::move(side_to_edge), {n});
  const std::size_t edges = m.length.size();
  d["edge_length"] = array(std::move(m.length), {edges});
  d["edge_missing"] = array(std::move(m.missing), {edges});
  return d;
}

Dict measure_mesh_cover(const nurbs::NurbsStore& store, const In2<double, 3>& vertices,
                        const In2<std::int32_t, 3>& triangles, const Uv& corner_uv,
                        const In1<std::int32_t>& face) {
  const std::vector<tess::FaceCover> cover =
      tess::measure_cover(store, mesh_of(vertices, triangles, corner_uv, face));
  std::vector<double> area;
  std::vector<std::int64_t> count, turned_over;
  for (const tess::FaceCover& f : cover)
    area.push_back(f.uv_area), count.push_back(f.triangles), turned_over.push_back(f.turned_over);
  const std::size_t n = cover.size();
  Dict d;
  d["uv_area"] = array(std::move(area), {n}), d["triangles"] = array(std::move(count), {n});
  d["turned_over"] = array(std::move(turned_over), {n});
  return d;
}

// How often each edge is used by faces that can be drawn.
Out<std::int32_t> edge_uses(const nurbs::NurbsStore& store) {
  std::vector<std::int32_t> uses(store.edges.size(), 0);
  for (const nurbs::CoEdge& c : store.coedges)
    if (store.faces[c.face].status == nurbs::FaceStatus::kOk) ++uses[c.edge];
  return array(std::move(uses), {store.edges.size()});
}

// Faces of shells that are closed and whose faces can all be drawn.
Out<std::uint8_t> closed_faces(const nurbs::NurbsStore& store) {
  std::vector<std::uint8_t> closed(store.faces.size(), 0);
  for (const nurbs::Shell& shell : store.shells) {
    bool whole = shell.closed;
    for (std::int32_t f = shell.faces.begin; f < shell.faces.end; ++f)
      whole = whole && store.faces[f].status == nurbs::FaceStatus::kOk;
    for (std::int32_t f = shell.faces.begin; f < shell.faces.end; ++f) closed[f] = whole;
  }
  return array(std::move(closed), {store.faces.size()});
}

}  // namespace

void bind_mesh_measure(nb::module_& m) {
  m.def(
      "measure_mesh", &measure_mesh, nb::arg("store"), nb::arg("vertices"), nb::arg("triangles"),
      nb::arg("corner_uv"), nb::arg("face"), nb::arg("enough"), nb::arg("subdivisions") = 6,
      nb::arg("most_triangles") = 0, nb::arg("seed") = 1, nb::arg("threads") = 0,
      "By triangle, mm: the largest distance found of its points from its face's surface, and of the "
      "surface's "
      "points at the same uv from the face's triangles (other triangles than its own are asked where that is "
      "over enough, (m,)); NaN where not chosen or not exact. ArgumentError: the mesh does not fit the "
      "store.");
  m.def(
      "measure_mesh_edges", &measure_mesh_edges, nb::arg("store"), nb::arg("vertices"), nb::arg("triangles"),
      nb::arg("corner_uv"), nb::arg("face"), nb::arg("points") = 16, nb::arg("threads") = 0,
      "Every side of a triangle where its face ends: triangle, corner, edge (-1: on none), open, from and to "
      "on the edge, distances (mm); and by edge, mm, its length in use and how much of it the mesh lacks.");
  m.def(
      "measure_mesh_cover", &measure_mesh_cover, nb::arg("store"), nb::arg("vertices"), nb::arg("triangles"),
      nb::arg("corner_uv"), nb::arg("face"),
      "By face of the store: signed area of its triangles in uv, their number, and how many are turned over "
      "in uv.");
  m.def("closed_faces", &closed_faces, nb::arg("store"),
        "(n,) uint8: 1 for faces of closed shells all of whose faces can be drawn.");
  m.def("edge_uses", &edge_uses, nb::arg("store"),
        "(n,) int32: how often each edge is used by faces that can be drawn.");
}

}  // namespace trimray::bind
