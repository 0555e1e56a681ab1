// Seeds: what a raster pass saw, as Python holds it.
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/stl/string.h>

#include "core/base/error.h"
#include "core/bind/bind.h"
#include "core/bind/seeds.h"
#include "raster/rasterizer.h"

namespace trimray::bind {

namespace {

using raster::SeedBuffers;
using raster::SeedProcess;
using InIds = nb::ndarray<const std::uint32_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using InUv = nb::ndarray<const float, nb::shape<-1, -1, 2>, nb::c_contig, nb::device::cpu>;

struct Kept {
  std::vector<std::uint32_t> id;
  std::vector<float> uv;
};

Seeds from_arrays(const InIds& id, const InUv& uv, const In2<std::int32_t, 2>& targets,
                  const In2<float, 2>& target_uv) {
  if (targets.shape(0) != target_uv.shape(0)) throw ArgumentError("seeds: targets differ in number");
  if (uv.size() != 0 && (uv.shape(0) != id.shape(0) || uv.shape(1) != id.shape(1)))
    throw ArgumentError("seeds: id and uv differ in size");
  auto kept = std::make_shared<Kept>();
  kept->id = vector(id), kept->uv = vector(uv);
  Seeds seeds;
  SeedBuffers& b = seeds.buffers;
  b.width_px = static_cast<int>(id.shape(1)), b.height_px = static_cast<int>(id.shape(0));
  b.process = uv.size() != 0 ? SeedProcess::kUv : SeedProcess::kId;
  b.id = kept->id, b.uv = kept->uv;
  for (std::size_t i = 0; i < targets.shape(0); ++i)
    b.targets.push_back({targets(i, 0), targets(i, 1), target_uv(i, 0), target_uv(i, 1)});
  b.owner = std::move(kept);
  return seeds;
}

Out<float> uv_plane(const Seeds& seeds) {
  const SeedBuffers& b = seeds.buffers;
  std::vector<float> uv(2 * b.id.size(), 0.0f);
  for (std::size_t i = 0; i < b.id.size(); ++i) {
    if (b.id[i] == 0 || b.id[i] > b.targets.size()) continue;
    const raster::SeedTarget& target = b.targets[b.id[i] - 1];
    const bool own = b.process == SeedProcess::kId;
    uv[2 * i] = own ? target.u : b.uv[2 * i], uv[2 * i + 1] = own ? target.v : b.uv[2 * i + 1];
  }
  return array(std::move(uv),
               {static_cast<std::size_t>(b.height_px), static_cast<std::size_t>(b.width_px), 2});
}

Out<std::uint32_t> id_plane(const Seeds& seeds) {
  const SeedBuffers& b = seeds.buffers;
  return array(std::vector<std::uint32_t>(b.id.begin(), b.id.end()),
               {static_cast<std::size_t>(b.height_px), static_cast<std::size_t>(b.width_px)});
}

}  // namespace

void bind_seeds(nb::module_& m) {
  nb::class_<Seeds>(m, "Seeds", "Where on which surface a tracer should look first, by pixel. Never trusted.")
      .def_static("from_arrays", &from_arrays, nb::arg("id"), nb::arg("uv"), nb::arg("targets"),
                  nb::arg("target_uv"),
                  "id (h, w) uint32: 0 for nothing, else one more than the number of a target. uv (h, w, 2) "
                  "float32, as fractions of the face's uv box, for targets that are surfaces; (0, 0, 2) for "
                  "targets that are triangles. targets (n, 2) int32: instance and face; target_uv (n, 2) "
                  "float32.")
      .def_prop_ro("targets", [](const Seeds& s) { return s.buffers.targets.size(); })
      .def("id", &id_plane, "(h, w) uint32.")
      .def("uv", &uv_plane, "(h, w, 2) float32, of what was seen; 0 for nothing.");
  m.def(
      "choose_raster",
      [](double covered_px, std::size_t triangles) {
        nb::gil_scoped_release release;
        const std::optional<raster::Backend> backend = raster::choose(covered_px, triangles);
        if (!backend) throw Error("no backend is available");
        return std::string(raster::backend_name(*backend));
      },
      nb::arg("covered_px"), nb::arg("triangles"),
      "The backend that gives seeds soonest. CoreError: none is available.");
}

}  // namespace trimray::bind
