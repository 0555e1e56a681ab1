// trimray._core: what Python sees of core/. Private to the package: trimray/__init__.py is the public face.
#include "core/base/error.h"
#include "core/bind/bind.h"

NB_MODULE(_core, m) {
  namespace nb = nanobind;
  // An interpreter that ends by an exception keeps objects alive; that is no news to a user.
  nb::set_leak_warnings(false);
  m.doc() = "Native core of trimray. Lengths are mm, angles radians.";
  nb::exception<trimray::Error> error(m, "CoreError", PyExc_RuntimeError);
  nb::exception<trimray::FormatError>(m, "FormatError", error.ptr());
  nb::exception<trimray::ArgumentError>(m, "ArgumentError", error.ptr());
  trimray::bind::bind_store(m);
  trimray::bind::bind_view(m);
  trimray::bind::bind_seeds(m);
  trimray::bind::bind_trace(m);
  trimray::bind::bind_measure(m);
  trimray::bind::bind_bench(m);
  trimray::bind::bind_tess(m);
  trimray::bind::bind_mesh_levels(m);
  trimray::bind::bind_raster(m);
  trimray::bind::bind_mesh_file(m);
  trimray::bind::bind_mesh_check(m);
  trimray::bind::bind_mesh_measure(m);
  trimray::bind::bind_distance(m);
  trimray::bind::bind_mass(m);
}
