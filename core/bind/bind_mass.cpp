// Area, volume and moments of a store.
#include <tuple>

#include <nanobind/stl/tuple.h>

#include "core/bind/bind.h"
#include "core/mass/mass.h"

namespace trimray::bind {

namespace {

using Pair = std::tuple<double, double>;

Out<double> copied(const std::vector<double>& values) {
  std::vector<double> own = values;
  return array(std::move(own), {values.size()});
}

nb::typed<nb::dict, nb::str, nb::any> measure_mass(const nurbs::NurbsStore& store, int threads) {
  mass::MassProperties m;
  {
    nb::gil_scoped_release release;
    m = mass::measure_mass(store, threads);
  }
  const mass::Body body = mass::body_of(m.moments);
  std::vector<double> centroid, inertia;
  for (int i = 0; i < 3; ++i) {
    centroid.push_back(body.centroid[i]);
    for (int j = 0; j < 3; ++j) inertia.push_back(body.inertia[j][i]);
  }
  nb::dict d;
  d["area"] = Pair(m.area, m.area_error);
  d["volume"] = Pair(m.moments.volume, m.moments.volume_error);
  d["centroid"] = array(std::move(centroid), {3}), d["centroid_error"] = body.centroid_error;
  d["inertia"] = array(std::move(inertia), {3, 3}), d["inertia_error"] = body.inertia_error;
  d["face_areas"] = copied(m.face_area), d["face_area_errors"] = copied(m.face_area_error);
  d["shell_volumes"] = copied(m.shell_volume), d["shell_volume_errors"] = copied(m.shell_volume_error);
  const std::size_t left = m.left_out.size();
  d["left_out"] = array(std::move(m.left_out), {left});
  return d;
}

}  // namespace

void bind_mass(nb::module_& m) {
  m.def(
      "measure_mass", &measure_mass, nb::arg("store"), nb::arg("threads") = 0,
      "area, volume, each with its error; centroid, inertia about it, centroid_error, inertia_error; "
      "face_areas, shell_volumes, in their prototypes, with their errors; left_out: faces without an area.");
}

}  // namespace trimray::bind
