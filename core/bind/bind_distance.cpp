// PointIndex: distances from points to a model; and points spread over it.
#include <memory>
#include <tuple>

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include "core/bind/bind.h"
#include "core/distance/point_index.h"
#include "core/distance/sample.h"

namespace trimray::bind {

namespace {

using distance::Nearest;
using distance::PointIndex;

Out<double> rows(const std::vector<dvec3>& points) {
  std::vector<double> values;
  values.reserve(3 * points.size());
  for (const dvec3& p : points) values.insert(values.end(), {p.x, p.y, p.z});
  return array(std::move(values), {points.size(), 3});
}

Out<double> rows(const std::vector<dvec2>& points) {
  std::vector<double> values;
  values.reserve(2 * points.size());
  for (const dvec2& p : points) values.insert(values.end(), {p.x, p.y});
  return array(std::move(values), {points.size(), 2});
}

// distance, point, face, instance, edge, uv, band, gap.
using NearestArrays = std::tuple<Out<double>, Out<double>, Out<std::int32_t>, Out<std::int32_t>,
                                 Out<std::int32_t>, Out<double>, Out<double>, Out<double>>;
NearestArrays nearest(const PointIndex& index, const In2<double, 3>& points, bool edges, int threads) {
  const std::size_t n = points.shape(0);
  std::vector<dvec3> queries(n);
  for (std::size_t i = 0; i < n; ++i) queries[i] = {points(i, 0), points(i, 1), points(i, 2)};
  std::vector<Nearest> found(n);
  {
    nb::gil_scoped_release release;
    index.nearest(queries, found, threads, edges);
  }
  std::vector<double> distance(n), band(n), gap(n);
  std::vector<dvec3> point(n);
  std::vector<dvec2> uv(n);
  std::vector<std::int32_t> face(n), instance(n), edge(n);
  for (std::size_t i = 0; i < n; ++i) {
    distance[i] = found[i].distance, gap[i] = found[i].gap, point[i] = found[i].point,
    uv[i] = found[i].uv_face;
    face[i] = found[i].face, instance[i] = found[i].instance, edge[i] = found[i].edge,
    band[i] = found[i].band;
  }
  return {array(std::move(distance), {n}), rows(point),
          array(std::move(face), {n}),     array(std::move(instance), {n}),
          array(std::move(edge), {n}),     rows(uv),
          array(std::move(band), {n}),     array(std::move(gap), {n})};
}

// point, normal, face, instance, uv.
using FaceArrays = std::tuple<Out<double>, Out<double>, Out<std::int32_t>, Out<std::int32_t>, Out<double>>;
FaceArrays sample_faces(const nurbs::NurbsStore& store, int count, std::uint64_t seed, int threads) {
  distance::FaceSamples s;
  {
    nb::gil_scoped_release release;
    s = distance::sample_faces(store, {count, seed, threads});
  }
  const std::size_t n = s.point.size();
  return {rows(s.point), rows(s.normal), array(std::move(s.face), {n}), array(std::move(s.instance), {n}),
          rows(s.uv_face)};
}

// point, edge, instance.
using EdgeArrays = std::tuple<Out<double>, Out<std::int32_t>, Out<std::int32_t>>;
EdgeArrays sample_edges(const nurbs::NurbsStore& store, int count, std::uint64_t seed, int threads) {
  distance::EdgeSamples s;
  {
    nb::gil_scoped_release release;
    s = distance::sample_edges(store, {count, seed, threads});
  }
  const std::size_t n = s.point.size();
  return {rows(s.point), array(std::move(s.edge), {n}), array(std::move(s.instance), {n})};
}

}  // namespace

void bind_distance(nb::module_& m) {
  nb::class_<PointIndex>(m, "PointIndex", "A store made ready for distances.")
      .def(
          "__init__",
          [](PointIndex* self, std::shared_ptr<nurbs::NurbsStore> store, int threads) {
            nb::gil_scoped_release release;
            new (self) PointIndex(std::move(store), threads);
          },
          nb::arg("store"), nb::arg("threads") = 0)
      .def_prop_ro("diagonal", &PointIndex::diagonal, "Of the box of all that is indexed, mm.")
      .def_prop_ro(
          "left_out",
          [](const PointIndex& index) {
            std::vector<std::int32_t> faces(index.left_out().begin(), index.left_out().end());
            const std::size_t n = faces.size();
            return array(std::move(faces), {n});
          },
          nb::rv_policy::move, "(k,) int32: faces that are not, or not wholly, indexed.")
      .def_prop_ro("bytes", [](const PointIndex& index) { return index.stats().bytes; })
      .def("nearest", &nearest, nb::arg("points"), nb::arg("edges") = false, nb::arg("threads") = 0,
           "distance (n,), point (n, 3), face (n,), instance (n,), edge (n,), uv (n, 2), band (n,), gap "
           "(n,); edges: of "
           "the "
           "edges alone.");
  m.def("sample_faces", &sample_faces, nb::arg("store"), nb::arg("count"), nb::arg("seed"),
        nb::arg("threads") = 0,
        "count points of each face of each instance: point (n, 3), normal (n, 3), face (n,), instance (n,), "
        "uv (n, 2).");
  m.def("sample_edges", &sample_edges, nb::arg("store"), nb::arg("count"), nb::arg("seed"),
        nb::arg("threads") = 0,
        "count points of each edge of each instance: point (n, 3), edge (n,), instance (n,).");
}

}  // namespace trimray::bind
