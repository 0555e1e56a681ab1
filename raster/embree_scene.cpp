#include "raster/embree_scene.h"

#include <unistd.h>

#include <map>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace trimray::raster {

EmbreeDevice::EmbreeDevice(const embree::Library& l)
    : library(l), device(l.new_device(nullptr)), process(getpid()) {
  if (!device) throw Error("Embree makes no device: error " + std::to_string(l.device_error(nullptr)));
}
EmbreeDevice::~EmbreeDevice() {
  if (process == getpid()) library.release_device(device);
}

EmbreeScene::EmbreeScene(std::shared_ptr<const EmbreeDevice> device, const tess::ViewMeshes& meshes,
                         const nurbs::NurbsStore& store, int threads)
    : device_(std::move(device)), store_(&store) {
  std::map<const tess::Tessellation*, std::pair<std::size_t, Box3>> known;  // instance that had it first
  std::vector<std::size_t> first;
  for (const tess::InstanceMesh& i : meshes.instances) {
    const auto [at, fresh] = known.try_emplace(i.mesh.get(), parts_.size(), Box3{});
    first.push_back(at->second.first);
    Box3& box = at->second.second;
    if (fresh) {
      for (const SeedProcess process : {SeedProcess::kId, SeedProcess::kUv})
        targets_[static_cast<int>(process)].push_back(
            std::make_shared<MeshTargets>(mesh_targets(i.mesh->mesh, store, process)));
      for (const dvec3& v : i.mesh->mesh.vertices) box.add(v);
    } else {
      for (auto& t : targets_) t.push_back(t[first.back()]);
    }
    const Transform& placement = store.instances[i.instance].placement;
    parts_.push_back({i.instance, i.mesh, placement});
    if (box.empty()) continue;
    for (int k = 0; k < 8; ++k)
      bounds_.add(placement.point({(k & 1 ? box.lower : box.upper).x, (k & 2 ? box.lower : box.upper).y,
                                   (k & 4 ? box.lower : box.upper).z}));
  }
  if (!bounds_.empty()) center_ = bounds_.center();
  const embree::Library& library = device_->library;
  scene_ = library.new_scene(device_->device);
  if (!scene_) throw Error("Embree makes no scene");
  try {
    library.set_quality(scene_, embree::kLowQuality);
    for (std::size_t i = 0; i < parts_.size(); ++i) add(meshes.instances[i].mesh->mesh, parts_[i].placement);
    // Embree's own tasks run in the arena that the commit is called from.
    parallel_ranges(1, 1, threads, [&](std::size_t, std::size_t) { library.commit_scene(scene_); });
    if (const int error = library.device_error(device_->device))
      throw Error("Embree cannot build its hierarchy: error " + std::to_string(error));
  } catch (...) {
    library.release_scene(scene_);
    throw;
  }
}

EmbreeScene::~EmbreeScene() {
  if (device_->process == getpid()) device_->library.release_scene(scene_);
}

void EmbreeScene::add(const tess::TriMesh& mesh, const Transform& placement) {
  const embree::Library& library = device_->library;
  const embree::Geometry geometry = library.new_geometry(device_->device, embree::kTriangles);
  // A geometry without triangles keeps its number.
  const std::size_t vertices = mesh.vertices.size(), triangles = mesh.triangles.size();
  auto* v = static_cast<float*>(library.new_buffer(geometry, embree::kVertexBuffer, 0, embree::kFloat3,
                                                   3 * sizeof(float), std::max<std::size_t>(vertices, 1)));
  auto* t = static_cast<unsigned*>(
      library.new_buffer(geometry, embree::kIndexBuffer, 0, embree::kUint3, 3 * sizeof(unsigned), triangles));
  if (v && (t || triangles == 0)) {
    for (const dvec3& p : mesh.vertices) {
      const dvec3 q = placement.point(p) - center_;
      for (int k = 0; k < 3; ++k) *v++ = static_cast<float>(q[k]);
    }
    for (const auto& corners : mesh.triangles)
      for (const std::int32_t c : corners) *t++ = static_cast<unsigned>(c);
    library.commit_geometry(geometry);
    library.attach(scene_, geometry);
  }
  library.release_geometry(geometry);
  if (!v || (!t && triangles > 0)) throw Error("Embree has no memory for a mesh");
}

bool EmbreeScene::is_of(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store) const {
  if (device_->process != getpid() || store_ != &store || parts_.size() != meshes.instances.size())
    return false;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const tess::InstanceMesh& wanted = meshes.instances[i];
    const Transform& placement = store.instances[wanted.instance].placement;
    if (parts_[i].instance != wanted.instance || parts_[i].mesh.lock() != wanted.mesh ||
        parts_[i].placement.linear != placement.linear ||
        parts_[i].placement.translation != placement.translation)
      return false;
  }
  return true;
}

}  // namespace trimray::raster
