// Files of triangles, to and from arrays.
#include <memory>

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "core/base/error.h"
#include "core/bind/bind.h"
#include "core/nurbs/store.h"
#include "core/tess/corner_normals.h"
#include "core/tess/mesh_file.h"

namespace trimray::bind {

namespace {

template <typename T, int Rows, int Columns>
using In3 = nb::ndarray<const T, nb::shape<-1, Rows, Columns>, nb::c_contig, nb::device::cpu>;

using tess::MeshFile;

std::shared_ptr<MeshFile> read(const std::string& path, const std::string& format) {
  nb::gil_scoped_release release;
  return std::make_shared<MeshFile>(tess::read_mesh_file(path, tess::mesh_format(format)));
}

Out<double> vertices(const MeshFile& file) {
  std::vector<double> values;
  values.reserve(3 * file.vertices.size());
  for (const dvec3& p : file.vertices) values.insert(values.end(), {p.x, p.y, p.z});
  return array(std::move(values), {file.vertices.size(), 3});
}

Out<std::int32_t> triangles(const MeshFile& file) {
  std::vector<std::int32_t> values;
  values.reserve(3 * file.triangles.size());
  for (const auto& t : file.triangles) values.insert(values.end(), t.begin(), t.end());
  return array(std::move(values), {file.triangles.size(), 3});
}

Out<std::int32_t> group_ends(const MeshFile& file) {
  std::vector<std::int32_t> values;
  for (const tess::FileGroup& g : file.groups) values.push_back(g.end);
  return array(std::move(values), {file.groups.size()});
}

Out<float> group_colors(const MeshFile& file) {
  std::vector<float> values;
  for (const tess::FileGroup& g : file.groups) values.insert(values.end(), g.color.begin(), g.color.end());
  return array(std::move(values), {file.groups.size(), 4});
}

std::vector<nb::bytes> group_names(const MeshFile& file) {
  std::vector<nb::bytes> names;
  for (const tess::FileGroup& g : file.groups) names.emplace_back(g.name.data(), g.name.size());
  return names;
}

template <int Columns, typename Array>
auto rows(const Array& a) {
  using T = std::remove_const_t<typename Array::Scalar>;
  std::vector<std::array<T, Columns>> values(a.shape(0));
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (int c = 0; c < Columns; ++c) values[i][c] = a(i, c);
  }
  return values;
}

std::vector<dvec3> points(const In2<double, 3>& a) {
  std::vector<dvec3> values(a.shape(0));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = {a(i, 0), a(i, 1), a(i, 2)};
  return values;
}

nb::bytes write(const std::string& format, const In2<double, 3>& vertices,
                const In2<std::int32_t, 3>& triangles, const In2<double, 3>& normals,
                const In2<float, 4>& colors) {
  const std::vector<dvec3> v = points(vertices), n = points(normals);
  const auto t = rows<3>(triangles);
  const auto c = rows<4>(colors);
  std::string bytes;
  {
    nb::gil_scoped_release release;
    bytes = tess::write_mesh({.vertices = v, .triangles = t, .normals = n, .colors = c},
                             tess::mesh_format(format));
  }
  return nb::bytes(bytes.data(), bytes.size());
}

// By corner: triangles (m, 3), corner_uv (m, 3, 2), face (m,).
Out<double> corner_normals(const nurbs::NurbsStore& store, const In2<double, 3>& vertices,
                           const In2<std::int32_t, 3>& triangles, const In3<double, 3, 2>& corner_uv,
                           const In1<std::int32_t>& face, int threads) {
  const std::size_t m = triangles.shape(0);
  if (corner_uv.shape(0) != m || face.shape(0) != m) throw ArgumentError("one uv and face a triangle");
  tess::TriMesh mesh{.vertices = points(vertices),
                     .triangles = rows<3>(triangles),
                     .corner_uv = {},
                     .face = vector(face),
                     .deviation = {}};
  mesh.corner_uv.resize(m);
  for (std::size_t i = 0; i < m; ++i) {
    for (int k = 0; k < 3; ++k) {
      mesh.corner_uv[i][k] = {corner_uv(i, k, 0), corner_uv(i, k, 1)};
      if (mesh.triangles[i][k] < 0 || static_cast<std::size_t>(mesh.triangles[i][k]) >= mesh.vertices.size())
        throw ArgumentError("triangle corner that is no vertex");
    }
    if (mesh.face[i] < 0 || static_cast<std::size_t>(mesh.face[i]) >= store.faces.size())
      throw ArgumentError("triangle of a face that does not exist");
  }
  std::vector<dvec3> normals;
  {
    nb::gil_scoped_release release;
    normals = tess::corner_normals(store, mesh, threads);
  }
  std::vector<double> values;
  values.reserve(3 * normals.size());
  for (const dvec3& n : normals) values.insert(values.end(), {n.x, n.y, n.z});
  return array(std::move(values), {m, 3, 3});
}

}  // namespace

void bind_mesh_file(nb::module_& m) {
  nb::class_<MeshFile>(m, "MeshFile", "What read_mesh_file() found.")
      .def("vertices", &vertices, "(n, 3) float64, as they stand in the file; taken as mm.")
      .def("triangles", &triangles, "(m, 3) int32.")
      .def("group_ends", &group_ends, "(g,) int32: one past the last triangle of each group.")
      .def("group_colors", &group_colors, "(g, 4) float32, sRGB-encoded; red -1 where there is none.")
      .def("group_names", &group_names, "Bytes as in the file, by group; often empty.")
      .def_prop_ro(
          "faces", [](const MeshFile& f) { return f.faces; }, "Polygons in the file.")
      .def_prop_ro(
          "left_out", [](const MeshFile& f) { return f.left_out; },
          "Of them, those without three different corners.")
      .def_prop_ro(
          "mixed_colors", [](const MeshFile& f) { return f.mixed_colors; },
          "More colours than groups are worth: the groups have their mean.")
      .def_prop_ro(
          "binary", [](const MeshFile& f) { return f.binary; }, "Not a text.");
  m.def("read_mesh_file", &read, nb::arg("path"), nb::arg("format"),
        "A file of triangles; format: stl, obj, ply or off. FormatError: damaged, or no such file.");
  m.def("write_mesh_file", &write, nb::arg("format"), nb::arg("vertices"), nb::arg("triangles"),
        nb::arg("normals"), nb::arg("colors"),
        "The bytes of a stl, obj, ply or off file. normals: by vertex, (0, 3) for none; colors: by triangle, "
        "(0, 4) for none. Equal arguments give equal bytes. ArgumentError: the arrays do not fit.");
  m.def("corner_normals", &corner_normals, nb::arg("store"), nb::arg("vertices"), nb::arg("triangles"),
        nb::arg("corner_uv"), nb::arg("face"), nb::arg("threads") = 0,
        "Outward unit normals of the exact surfaces at the corners of triangles, (m, 3, 3) float64. "
        "ArgumentError: the arrays do not fit.");
}

}  // namespace trimray::bind
