// Cameras.
#include <nanobind/stl/pair.h>

#include "core/base/error.h"
#include "core/bind/bind.h"
#include "core/view/camera.h"

namespace trimray::bind {

namespace {

view::Camera fit(double azimuth_deg, double elevation_deg, view::UpAxis up, const In2<double, 3>& points,
                 int width_px, int height_px, bool perspective, double fov_deg, double margin) {
  std::vector<dvec3> p;
  for (std::size_t i = 0; i < points.shape(0); ++i) p.push_back({points(i, 0), points(i, 1), points(i, 2)});
  return view::fit(view::look(azimuth_deg, elevation_deg, up), p,
                   {.width_px = width_px,
                    .height_px = height_px,
                    .perspective = perspective,
                    .fov_deg = fov_deg,
                    .margin = margin});
}

Out<double> vec(const dvec3& v) { return array(std::vector<double>{v.x, v.y, v.z}, {3}); }

// Rays of all pixel centres, row by row: two arrays (height * width, 3).
std::pair<Out<double>, Out<double>> rays(const view::Camera& c) {
  std::vector<double> org, dir;
  const std::size_t pixels = static_cast<std::size_t>(c.width_px) * c.height_px;
  org.reserve(3 * pixels), dir.reserve(3 * pixels);
  for (int y = 0; y < c.height_px; ++y) {
    for (int x = 0; x < c.width_px; ++x) {
      const view::CameraRay r = c.ray(x + 0.5, y + 0.5);
      org.insert(org.end(), {r.org.x, r.org.y, r.org.z});
      dir.insert(dir.end(), {r.dir.x, r.dir.y, r.dir.z});
    }
  }
  return {array(std::move(org), {pixels, 3}), array(std::move(dir), {pixels, 3})};
}

}  // namespace

void bind_view(nb::module_& m) {
  nb::enum_<view::UpAxis>(m, "UpAxis")
      .value("X", view::UpAxis::kX)
      .value("Y", view::UpAxis::kY)
      .value("Z", view::UpAxis::kZ)
      .value("MINUS_X", view::UpAxis::kMinusX)
      .value("MINUS_Y", view::UpAxis::kMinusY)
      .value("MINUS_Z", view::UpAxis::kMinusZ);
  nb::class_<view::Camera>(m, "Camera", "Where the rays of a picture start and go.")
      .def_static("fit", &fit, nb::arg("azimuth_deg"), nb::arg("elevation_deg"), nb::arg("up"),
                  nb::arg("points"), nb::arg("width_px"), nb::arg("height_px"), nb::arg("perspective"),
                  nb::arg("fov_deg"), nb::arg("margin"), "Fitted to points (n, 3) float64, mm.")
      .def_prop_ro(
          "eye", [](const view::Camera& c) { return vec(c.eye); }, nb::rv_policy::move, "(3,) float64, mm.")
      .def_prop_ro(
          "right", [](const view::Camera& c) { return vec(c.right); }, nb::rv_policy::move,
          "(3,) float64, unit.")
      .def_prop_ro(
          "up", [](const view::Camera& c) { return vec(c.up); }, nb::rv_policy::move, "(3,) float64, unit.")
      .def_prop_ro(
          "forward", [](const view::Camera& c) { return vec(c.forward); }, nb::rv_policy::move,
          "(3,) float64, unit.")
      .def_ro("perspective", &view::Camera::perspective)
      .def_ro("pixel", &view::Camera::pixel, "mm per px (orthographic) or tangent per px (perspective).")
      .def_ro("width_px", &view::Camera::width_px)
      .def_ro("height_px", &view::Camera::height_px)
      .def(
          "zoomed",
          [](view::Camera c, double zoom) {
            if (!(zoom > 0.0 && zoom < kInf)) throw ArgumentError("zoom must be above 0");
            c.pixel /= zoom;
            return c;
          },
          nb::arg("zoom"), "The same picture enlarged about its centre.")
      .def(
          "turned",
          [](const view::Camera& c, double angle_deg, const In1<double>& pivot, view::UpAxis up) {
            if (pivot.shape(0) != 3) throw ArgumentError("pivot must be (3,)");
            return view::turned(c, angle_deg, {pivot(0), pivot(1), pivot(2)}, up);
          },
          nb::arg("angle_deg"), nb::arg("pivot"), nb::arg("up"),
          "Moved about the upright line through pivot (3,) float64, mm, so that the azimuth grows.")
      .def("rays", &rays,
           "Origins and unit directions, (height * width, 3) float64 each, of the pixel centres.");
}

}  // namespace trimray::bind
