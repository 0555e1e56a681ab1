// NurbsStore: built, saved, loaded, and told about in arrays.
#include <algorithm>
#include <memory>
#include <tuple>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "core/base/error.h"
#include "core/bind/bind.h"
#include "core/nurbs/build_store.h"
#include "core/nurbs/merge_stores.h"
#include "core/nurbs/mesh_store.h"
#include "core/trace/extent.h"

namespace trimray::bind {

namespace {

using nurbs::NurbsStore;
using StorePtr = std::shared_ptr<NurbsStore>;

std::span<const std::byte> bytes_of(const nb::bytes& b) {
  return {reinterpret_cast<const std::byte*>(b.c_str()), b.size()};
}

StorePtr build(const nb::bytes& brep, const In1<std::int32_t>& prototype_shapes,
               const In2<float, 4>& prototype_colors, const In1<std::int32_t>& face_color_shapes,
               const In2<float, 4>& face_colors, const In1<std::int32_t>& instance_prototypes,
               const In2<double, 12>& instance_placements, const In2<float, 4>& instance_colors,
               std::string meta) {
  nurbs::BuildInput input;
  input.prototype_shapes = vector(prototype_shapes);
  input.prototype_colors = vector(prototype_colors);
  input.face_color_shapes = vector(face_color_shapes);
  input.face_colors = vector(face_colors);
  input.instance_prototypes = vector(instance_prototypes);
  input.instance_placements = vector(instance_placements);
  input.instance_colors = vector(instance_colors);
  input.meta = std::move(meta);
  const auto stream = bytes_of(brep);
  nb::gil_scoped_release release;
  return std::make_shared<NurbsStore>(nurbs::build_store(stream, input));
}

StorePtr from_triangles(const In2<double, 3>& vertices, const In2<std::int32_t, 3>& triangles,
                        const In1<std::int32_t>& group_ends, const In2<float, 4>& colors, std::string meta) {
  const std::size_t count = group_ends.shape(0);
  if (colors.shape(0) != count) throw ArgumentError("colors must hold 4 values a group");
  std::vector<dvec3> points(vertices.shape(0));
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = dvec3(vertices(i, 0), vertices(i, 1), vertices(i, 2));
  std::vector<nurbs::Triangle> corners(triangles.shape(0));
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i] = {triangles(i, 0), triangles(i, 1), triangles(i, 2)};
  std::vector<nurbs::MeshGroup> groups(count);
  for (std::size_t i = 0; i < count; ++i) {
    groups[i].end = group_ends(i);
    std::copy_n(colors.data() + 4 * i, 4, groups[i].color);
  }
  nb::gil_scoped_release release;
  return std::make_shared<NurbsStore>(
      nurbs::mesh_store(std::move(points), std::move(corners), groups, std::move(meta)));
}

StorePtr merge(const std::vector<StorePtr>& stores, std::string meta) {
  std::vector<const NurbsStore*> parts;
  for (const StorePtr& s : stores) parts.push_back(s.get());
  nb::gil_scoped_release release;
  return std::make_shared<NurbsStore>(nurbs::merge_stores(parts, std::move(meta)));
}

StorePtr load(const nb::bytes& data) {
  const auto bytes = bytes_of(data);
  nb::gil_scoped_release release;
  return std::make_shared<NurbsStore>(nurbs::load_store(bytes));
}

nb::bytes save(const NurbsStore& store) {
  std::vector<std::byte> bytes;
  {
    nb::gil_scoped_release release;
    bytes = nurbs::save_store(store);
  }
  return nb::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

// One column of the faces.
template <typename T, typename Get>
Out<T> face_column(const NurbsStore& store, const Get& get) {
  std::vector<T> values;
  values.reserve(store.faces.size());
  for (const nurbs::Face& f : store.faces) values.push_back(get(f));
  return array(std::move(values), {store.faces.size()});
}

Out<float> face_colors(const NurbsStore& store) {
  std::vector<float> values;
  for (const nurbs::Face& f : store.faces) values.insert(values.end(), f.color, f.color + 4);
  return array(std::move(values), {store.faces.size(), 4});
}

// What faces without a colour of their own take: the instance's, else the prototype's, else red -1.
Out<float> instance_colors(const NurbsStore& store) {
  std::vector<float> values;
  for (const nurbs::Instance& i : store.instances) {
    const float* color = i.color[0] >= 0.0f ? i.color : store.prototypes[i.prototype].color;
    values.insert(values.end(), color, color + 4);
  }
  return array(std::move(values), {store.instances.size(), 4});
}

Out<double> placements(const NurbsStore& store) {
  std::vector<double> values;
  for (const nurbs::Instance& i : store.instances) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) values.push_back(i.placement.linear[column][row]);
      values.push_back(i.placement.translation[row]);
    }
  }
  return array(std::move(values), {store.instances.size(), 3, 4});
}

Out<std::int32_t> prototype_faces(const NurbsStore& store) {
  std::vector<std::int32_t> values;
  for (const nurbs::Prototype& p : store.prototypes)
    values.insert(values.end(), {p.faces.begin, p.faces.end});
  return array(std::move(values), {store.prototypes.size(), 2});
}

// Face counts of open and closed shells, by prototype: (closed shells, open shells).
Out<std::int32_t> prototype_shells(const NurbsStore& store) {
  std::vector<std::int32_t> values;
  for (const nurbs::Prototype& p : store.prototypes) {
    std::int32_t closed = 0;
    for (std::int32_t s = p.shells.begin; s < p.shells.end; ++s) closed += store.shells[s].closed;
    values.insert(values.end(), {closed, p.shells.size() - closed});
  }
  return array(std::move(values), {store.prototypes.size(), 2});
}

std::pair<Out<double>, Out<double>> extent(const NurbsStore& store, int threads) {
  trace::Extent e;
  {
    nb::gil_scoped_release release;
    e = trace::model_extent(store, threads);
  }
  std::vector<double> points;
  for (const dvec3& p : e.points) points.insert(points.end(), {p.x, p.y, p.z});
  const Box3& b = e.bounds;
  std::vector<double> bounds{b.lower.x, b.lower.y, b.lower.z, b.upper.x, b.upper.y, b.upper.z};
  return {array(std::move(bounds), {2, 3}), array(std::move(points), {e.points.size(), 3})};
}

// Places in the world that a ray may be aimed at to test parity: every vertex, and the start, middle and end
// of every edge piece; with the numbers of closed and open shells over all instances.
std::tuple<Out<double>, std::int32_t, std::int32_t> parity_targets(const NurbsStore& store) {
  std::vector<double> points;
  std::int32_t closed = 0, open = 0;
  for (const nurbs::Instance& instance : store.instances) {
    const nurbs::Prototype& p = store.prototypes[instance.prototype];
    const auto add = [&](const dvec3& local) {
      const dvec3 q = instance.placement.point(local);
      points.insert(points.end(), {q.x, q.y, q.z});
    };
    for (std::int32_t s = p.shells.begin; s < p.shells.end; ++s) ++(store.shells[s].closed ? closed : open);
    for (std::int32_t v = p.vertices.begin; v < p.vertices.end; ++v) add(store.vertices[v].point);
    for (std::int32_t e = p.edges.begin; e < p.edges.end; ++e) {
      const nurbs::Range pieces = store.edges[e].pieces;
      for (std::int32_t i = pieces.begin; i < pieces.end; ++i) {
        for (const double t : {0.0, 0.5, 1.0}) add(trace::edge_piece_point(store, store.edge_pieces[i], t));
      }
    }
  }
  const std::size_t count = points.size() / 3;
  return {array(std::move(points), {count, 3}), closed, open};
}

}  // namespace

void bind_store(nb::module_& m) {
  nb::class_<NurbsStore>(m, "Store", "Every face of a model as an exact trimmed NURBS surface; immutable.")
      .def_static(
          "build", &build, nb::arg("brep"), nb::arg("prototype_shapes"), nb::arg("prototype_colors"),
          nb::arg("face_color_shapes"), nb::arg("face_colors"), nb::arg("instance_prototypes"),
          nb::arg("instance_placements"), nb::arg("instance_colors"), nb::arg("meta"),
          "From the importer's byte stream and arrays. FormatError: the stream is damaged; ArgumentError: "
          "the arrays do not fit it.")
      .def_static(
          "from_triangles", &from_triangles, nb::arg("vertices"), nb::arg("triangles"), nb::arg("group_ends"),
          nb::arg("colors"), nb::arg("meta"),
          "A model that comes as triangles: vertices (n, 3) float64, mm; triangles (m, 3) int32, "
          "counter-clockwise from outside; group_ends (g,) int32: each group of triangles, up to its end, "
          "is one face; colors (g, 4) float32, sRGB-encoded, red -1 for none. ArgumentError: an index that "
          "names nothing, a coordinate that is not finite, groups that are empty or do not cover the "
          "triangles.")
      .def_static(
          "merge", &merge, nb::arg("stores"), nb::arg("meta"),
          "All prototypes, instances and faces of the first store, then those of the second, and so on. "
          "ArgumentError: too large together.")
      .def_static("load", &load, nb::arg("data"), "From what save() gave. FormatError: anything else.")
      .def("save", &save, "The store as the bytes of one file.")
      .def_prop_ro(
          "meta", [](const NurbsStore& s) { return s.meta; }, "The importer's JSON.")
      .def_prop_ro("face_count", [](const NurbsStore& s) { return s.faces.size(); })
      .def(
          "face_kinds",
          [](const NurbsStore& s) {
            std::vector<std::string> kinds;
            for (const nurbs::Face& f : s.faces) {
              kinds.push_back(
                  nurbs::kind_name(f.surface < 0 ? nurbs::SurfaceKind::kNone : s.surfaces[f.surface].kind));
            }
            return kinds;
          },
          "Surface kind of every face.")
      .def(
          "face_statuses",
          [](const NurbsStore& s) {
            std::vector<std::string> reasons;
            for (const nurbs::Face& f : s.faces) reasons.push_back(nurbs::status_reason(f.status));
            return reasons;
          },
          "\"ok\" or the reason the face cannot be drawn.")
      .def("face_colors", &face_colors,
           "(n, 4) float32, sRGB-encoded, straight alpha; red -1 where the face has none of its own.")
      .def(
          "face_prototypes",
          [](const NurbsStore& s) {
            return face_column<std::int32_t>(s, [](const nurbs::Face& f) { return f.prototype; });
          },
          "(n,) int32.")
      .def(
          "face_shapes",
          [](const NurbsStore& s) {
            return face_column<std::int32_t>(s, [](const nurbs::Face& f) { return f.shape; });
          },
          "(n,) int32, 1-based position in the importer's byte stream.")
      .def(
          "instance_prototypes",
          [](const NurbsStore& s) {
            std::vector<std::int32_t> values;
            for (const nurbs::Instance& i : s.instances) values.push_back(i.prototype);
            const std::size_t count = values.size();
            return array(std::move(values), {count});
          },
          "(n,) int32.")
      .def("instance_placements", &placements, "(n, 3, 4) float64, prototype to world, mm.")
      .def(
          "instance_colors", &instance_colors,
          "(n, 4) float32, sRGB-encoded: of faces without a colour of their own; red -1 where there is none.")
      .def("prototype_faces", &prototype_faces, "(n, 2) int32: first face and one past the last.")
      .def("prototype_shells", &prototype_shells, "(n, 2) int32: closed and open shells.")
      .def(
          "arrays", [](nb::handle self) { return store_arrays(self); },
          nb::sig("def arrays(self) -> dict[str, NDArray[Any]]"),
          "Every array of the store by its name in core/nurbs/store.h, read-only, sharing the store's "
          "memory: "
          "knots (n,), ctrl_h (n, 4), trim_ctrl_h (n, 3), edge_ctrl_h (n, 4), mesh_vertices (n, 3) float64; "
          "edge_coedges (n,), mesh_triangles (n, 3) int32; surfaces, conics, faces, loops, coedges, "
          "trim_pieces, "
          "edges, edge_pieces, vertices, shells, prototypes, instances: structured, (n,). A range is (2,) "
          "int32, "
          "an enum uint8, a box (2, d) and a vector (3,) float64, a colour (4,) float32; placement (4, 3): "
          "the "
          "columns.")
      .def("parity_targets", &parity_targets,
           "Points (n, 3) float64, world, mm, on every vertex and edge; closed shells; open shells, over all "
           "instances.")
      .def("extent", &extent, nb::arg("threads") = 0,
           "Tight bounds (2, 3) float64 and outline points (n, 3) float64, world, mm; inf, -inf when nothing "
           "can be drawn.");
}

}  // namespace trimray::bind
