// Raster passes, for tests and for looking at seeds.
#include <memory>
#include <string>
#include <tuple>

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "core/base/error.h"
#include "core/bind/bind.h"
#include "core/bind/seeds.h"
#include "raster/rasterizer.h"

namespace trimray::bind {

namespace {

using raster::Backend;
using raster::SeedProcess;

Backend backend_named(const std::string& name) {
  if (const auto backend = raster::backend_of(name)) return *backend;
  std::string known;
  for (const Backend b : raster::kBackends)
    known += (known.empty() ? "" : ", ") + std::string(backend_name(b));
  throw ArgumentError("no raster backend is called " + name + " (" + known + ")");
}

// id, uv, and by id - 1 the instance and the face.
using Planes = std::tuple<Out<std::uint32_t>, Out<float>, Out<std::int32_t>, Out<std::int32_t>>;

Planes planes_of(const raster::SeedBuffers& b) {
  const auto width = static_cast<std::size_t>(b.width_px), height = static_cast<std::size_t>(b.height_px);
  std::vector<std::uint32_t> id(b.id.begin(), b.id.end());
  std::vector<float> uv(2 * id.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < id.size(); ++i) {
    if (id[i] == 0) continue;
    const raster::SeedTarget& target = b.targets[id[i] - 1];
    const bool own = b.process == SeedProcess::kUv;
    uv[2 * i] = own ? b.uv[2 * i] : target.u, uv[2 * i + 1] = own ? b.uv[2 * i + 1] : target.v;
  }
  std::vector<std::int32_t> instance, face;
  for (const raster::SeedTarget& target : b.targets)
    instance.push_back(target.instance), face.push_back(target.face);
  const std::size_t targets = b.targets.size();
  return {array(std::move(id), {height, width}), array(std::move(uv), {height, width, 2}),
          array(std::move(instance), {targets}), array(std::move(face), {targets})};
}

raster::SeedBuffers draw(raster::Rasterizer& rasterizer, tess::MeshLevels& levels,
                         const nurbs::NurbsStore& store, const view::Camera& camera, double deviation_px,
                         const std::string& process, int threads) {
  if (process != "id" && process != "uv") throw ArgumentError("process must be id or uv, not " + process);
  nb::gil_scoped_release release;
  return rasterizer.draw(levels.meshes(camera, deviation_px, threads), store, camera,
                         process == "id" ? SeedProcess::kId : SeedProcess::kUv, threads);
}

std::vector<std::tuple<std::string, bool, std::string>> backends() {
  std::vector<std::tuple<std::string, bool, std::string>> list;
  for (const Backend b : raster::kBackends) {
    std::string why_not;
    const bool there = raster::available(b, &why_not);
    list.emplace_back(backend_name(b), there, there ? raster::version(b) : why_not);
  }
  return list;
}

}  // namespace

void bind_raster(nb::module_& m) {
  nb::class_<raster::Rasterizer>(m, "Rasterizer", "Draws the meshes of a view once; what each pixel saw.")
      .def(nb::new_(
               [](const std::string& backend) { return raster::make_rasterizer(backend_named(backend)); }),
           nb::arg("backend"),
           "backend: osmesa, egl or embree. CoreError with the reason where it is not available.")
      .def_prop_ro("name", &raster::Rasterizer::name)
      .def(
          "seeds",
          [](raster::Rasterizer& r, tess::MeshLevels& levels, const nurbs::NurbsStore& store,
             const view::Camera& camera, double deviation_px, const std::string& process,
             int threads) { return Seeds{draw(r, levels, store, camera, deviation_px, process, threads)}; },
          nb::arg("levels"), nb::arg("store"), nb::arg("camera"), nb::arg("deviation_px") = 0.3,
          nb::arg("process") = "uv", nb::arg("threads") = 0,
          "What draw() tells, as the tracer takes it, without a copy.")
      .def(
          "draw",
          [](raster::Rasterizer& r, tess::MeshLevels& levels, const nurbs::NurbsStore& store,
             const view::Camera& camera, double deviation_px, const std::string& process, int threads) {
            return planes_of(draw(r, levels, store, camera, deviation_px, process, threads));
          },
          nb::arg("levels"), nb::arg("store"), nb::arg("camera"), nb::arg("deviation_px") = 0.3,
          nb::arg("process") = "uv", nb::arg("threads") = 0,
          "id (h, w) uint32, 0 where nothing is seen; uv (h, w, 2) float32, fractions of the face's uv box, "
          "NaN "
          "where nothing is seen; and by id - 1 instance (n,) and face (n,). levels: of this store. "
          "process: id "
          "(one a triangle, uv the mean of its corners) or uv (one a surface, uv as interpolated).")
      .def(
          "warm_up",
          [](raster::Rasterizer& r) {
            nb::gil_scoped_release release;
            r.warm_up();
          },
          "Does now what the first draw would spend on loading and compiling.");
  m.def(
      "raster_backends",
      [] {
        nb::gil_scoped_release release;
        return backends();
      },
      "[(name, whether it is available, its version or why not)].");
}

}  // namespace trimray::bind
