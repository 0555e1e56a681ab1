#include "raster/rasterizer.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>

#include "core/base/error.h"
#include "raster/backends.h"

namespace trimray::raster {

namespace {

std::unique_ptr<Rasterizer> try_to_make(Backend backend) {
  return backend == Backend::kEmbree ? make_embree_rasterizer() : make_gl_rasterizer(backend);
}

// Named by TRIMRAY_NO_RASTER.
bool forbidden(Backend backend) {
  const char* value = std::getenv("TRIMRAY_NO_RASTER");
  std::string_view list = value ? value : "";
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const std::string_view name = list.substr(0, comma);
    if (name == "all" || name == backend_name(backend)) return true;
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return false;
}

struct Known {
  std::mutex mutex;
  std::map<Backend, std::string> why_not;  // empty: available
};
Known& known() {
  static auto* instance = new Known;
  return *instance;
}

}  // namespace

const char* backend_name(Backend backend) {
  switch (backend) {
    case Backend::kOsmesa:
      return "osmesa";
    case Backend::kEgl:
      return "egl";
    case Backend::kEmbree:
      return "embree";
  }
  return "?";
}

std::optional<Backend> backend_of(std::string_view name) {
  for (const Backend backend : kBackends)
    if (name == backend_name(backend)) return backend;
  return std::nullopt;
}

bool available(Backend backend, std::string* why_not) {
  std::string reason;
  if (forbidden(backend)) {
    reason = "switched off by TRIMRAY_NO_RASTER";
  } else {
    Known& k = known();
    const std::lock_guard lock(k.mutex);
    const auto [at, fresh] = k.why_not.try_emplace(backend);
    if (fresh) {
      try {
        try_to_make(backend);
      } catch (const std::exception& error) {
        at->second = error.what();
      }
    }
    reason = at->second;
  }
  const bool result = reason.empty();
  if (why_not) *why_not = std::move(reason);
  return result;
}

std::string version(Backend backend) {
  if (!available(backend)) return {};
  return backend == Backend::kEmbree ? embree_version() : gl_version(backend);
}

std::unique_ptr<Rasterizer> make_rasterizer(Backend backend) {
  std::string why_not;
  if (!available(backend, &why_not))
    throw Error(std::string("raster backend ") + backend_name(backend) + " is not available: " + why_not);
  return try_to_make(backend);
}

void check_view(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store, const view::Camera& camera) {
  if (camera.width_px < 1 || camera.height_px < 1) throw ArgumentError("a picture needs at least 1 x 1 px");
  if (camera.width_px > kMaxPicturePx || camera.height_px > kMaxPicturePx)
    throw ArgumentError("a picture of " + std::to_string(camera.width_px) + " x " +
                        std::to_string(camera.height_px) + " px is too large to be drawn");
  if (!(camera.pixel > 0.0 && camera.pixel < kInf)) throw ArgumentError("a pixel must have a size above 0");
  for (const tess::InstanceMesh& i : meshes.instances) {
    if (i.instance < 0 || i.instance >= static_cast<std::int32_t>(store.instances.size()))
      throw ArgumentError("the view has a mesh of instance " + std::to_string(i.instance) +
                          ", which the store has not");
    if (!i.mesh) throw ArgumentError("an instance of the view has no mesh");
  }
}

void AllTargets::add(std::int32_t instance, const std::vector<SeedTarget>& more) {
  if (targets.size() + more.size() >= ~std::uint32_t{0}) throw ArgumentError("a view of too many triangles");
  first.push_back(static_cast<std::uint32_t>(targets.size()) + 1);
  for (SeedTarget target : more) {
    target.instance = instance;
    targets.push_back(target);
  }
}

}  // namespace trimray::raster
