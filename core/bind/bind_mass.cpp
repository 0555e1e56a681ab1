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

Out<double> rows(const mass::MassProperties& m, mass::Integrals mass::FaceIntegrals::*which) {
  std::vector<double> values;
  for (const mass::FaceIntegrals& f : m.faces)
    values.insert(values.end(), (f.*which).begin(), (f.*which).end());
  return array(std::move(values), {m.faces.size(), mass::kIntegrals});
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
  d["face_integrals"] = rows(m, &mass::FaceIntegrals::value);
  d["face_integral_errors"] = rows(m, &mass::FaceIntegrals::error);
  std::vector<double> origins;
  for (const dvec3& o : m.origins) origins.insert(origins.end(), {o.x, o.y, o.z});
  d["origins"] = array(std::move(origins), {m.origins.size(), 3});
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
      "shell_volumes, in their prototypes, with their errors; face_integrals, face_integral_errors (n, 11), "
      "in their prototypes, NaN for faces that cannot be drawn, about origins (p, 3): area; by the "
      "divergence "
      "theorem volume, x, y, z, xx, xy, xz, yy, yz, zz; left_out: faces without an area.");
}

}  // namespace trimray::bind
