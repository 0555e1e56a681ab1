// Meshes for a camera.
#include <map>
#include <memory>

#include <nanobind/stl/shared_ptr.h>

#include "core/base/error.h"
#include "core/bind/mesh_arrays.h"
#include "core/tess/mesh_levels.h"

namespace trimray::bind {

namespace {

// [(instance, mesh's index, made for it alone)], by mesh (arrays, issues), and (built, reused).
using Placing = std::tuple<std::int32_t, int, bool>;
using ViewResult =
    std::tuple<std::vector<Placing>, std::vector<std::pair<MeshArrays, Issues>>, std::pair<int, int>>;

ViewResult meshes(tess::MeshLevels& levels, const view::Camera& camera, double deviation_px, int threads) {
  tess::ViewMeshes found;
  {
    nb::gil_scoped_release release;
    found = levels.meshes(camera, deviation_px, threads);
  }
  std::vector<Placing> placings;
  std::vector<std::pair<MeshArrays, Issues>> meshes;
  std::map<const tess::Tessellation*, int> index;
  for (const tess::InstanceMesh& i : found.instances) {
    const auto [at, fresh] = index.try_emplace(i.mesh.get(), static_cast<int>(meshes.size()));
    if (fresh) meshes.push_back({mesh_arrays(i.mesh->mesh), issues_of(*i.mesh)});
    placings.push_back({i.instance, at->second, i.cut});
  }
  return {std::move(placings), std::move(meshes), {found.built, found.reused}};
}

}  // namespace

void bind_mesh_levels(nb::module_& m) {
  nb::class_<tess::MeshLevels>(m, "MeshLevels", "Meshes of a store for cameras, kept from one to the next.")
      .def(
          "__init__",
          [](tess::MeshLevels* self, std::shared_ptr<nurbs::NurbsStore> store, double angle) {
            if (!(angle > 0.0)) throw ArgumentError("angle must be above 0");
            new (self) tess::MeshLevels(std::move(store), {.angle = angle});
          },
          nb::arg("store"), nb::arg("angle"), "angle: rad, inf for none.")
      .def("meshes", &meshes, nb::arg("camera"), nb::arg("deviation_px"), nb::arg("threads") = 0,
           "[(instance, mesh, cut)] of the instances in the picture; by mesh what tessellate() returns; "
           "(meshes built, meshes reused).")
      .def(
          "triangles",
          [](tess::MeshLevels& levels, const view::Camera& camera, double deviation_px, int threads) {
            nb::gil_scoped_release release;
            const tess::ViewMeshes found = levels.meshes(camera, deviation_px, threads);
            return std::tuple{found.triangles, found.built, found.reused};
          },
          nb::arg("camera"), nb::arg("deviation_px"), nb::arg("threads") = 0,
          "The same, as counts: triangles of all instances, meshes built, meshes reused.")
      .def_prop_ro("bytes", &tess::MeshLevels::bytes, "Of the meshes that are kept.");
}

}  // namespace trimray::bind
