#include "raster/draw_mesh.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace trimray::raster {

std::array<float, 2> uv_fraction(const nurbs::Face& face, const dvec2& uv) {
  std::array<float, 2> result;
  for (int k = 0; k < 2; ++k) {
    const double extent = face.uv_box.upper[k] - face.uv_box.lower[k];
    result[k] = extent > 0.0 ? static_cast<float>((uv[k] - face.uv_box.lower[k]) / extent) : 0.5f;
  }
  return result;
}

MeshTargets mesh_targets(const tess::TriMesh& mesh, const nurbs::NurbsStore& store, SeedProcess process) {
  const std::size_t count = mesh.triangles.size();
  if (mesh.corner_uv.size() != count || mesh.face.size() != count)
    throw ArgumentError("a mesh needs uv and a face for each triangle");
  const auto vertices = static_cast<std::int32_t>(mesh.vertices.size());
  const auto faces = static_cast<std::int32_t>(store.faces.size());
  MeshTargets result;
  result.of_triangle.resize(count);
  if (process == SeedProcess::kId) result.targets.resize(count);
  std::vector<std::int32_t> number;  // of the faces, from the first on that the prototype can have
  std::int32_t first_face = faces;
  for (const std::int32_t face : mesh.face) first_face = std::min(first_face, face);
  for (std::size_t t = 0; t < count; ++t) {
    for (const std::int32_t v : mesh.triangles[t])
      if (v < 0 || v >= vertices)
        throw ArgumentError("triangle corner " + std::to_string(v) + " is no vertex");
    const std::int32_t face = mesh.face[t];
    if (face < 0 || face >= faces) throw ArgumentError("the mesh names face " + std::to_string(face));
    if (process == SeedProcess::kId) {
      const auto& uv = mesh.corner_uv[t];
      const auto [u, v] = uv_fraction(store.faces[face], (uv[0] + uv[1] + uv[2]) / 3.0);
      result.of_triangle[t] = static_cast<std::uint32_t>(t);
      result.targets[t] = {.face = face, .u = u, .v = v};
      continue;
    }
    const auto at = static_cast<std::size_t>(face - first_face);
    if (at >= number.size()) number.resize(at + 1, -1);
    if (number[at] < 0) {
      number[at] = static_cast<std::int32_t>(result.targets.size());
      result.targets.push_back({.face = face});
    }
    result.of_triangle[t] = static_cast<std::uint32_t>(number[at]);
  }
  return result;
}

namespace {

// By shell of the prototype: which of its triangles are never seen from outside. A shell whose mesh may have
// holes hides nothing: one with faces that cannot be drawn or were covered by other means, one that is cut,
// or without volume.
std::map<std::int32_t, Hidden> hidden_sides(const tess::InstanceMesh& instance,
                                            const nurbs::NurbsStore& store, const Box3& bounds) {
  std::map<std::int32_t, Hidden> result;
  if (instance.cut) return result;
  const tess::TriMesh& mesh = instance.mesh->mesh;
  std::map<std::int32_t, double> volume;
  const dvec3 center = bounds.center();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    volume[store.faces[mesh.face[t]].shell] +=
        glm::dot(mesh.vertices[a] - center, glm::cross(mesh.vertices[b] - center, mesh.vertices[c] - center));
  }
  const double least = 1e-9 * bounds.diagonal() * bounds.diagonal() * bounds.diagonal();
  for (const auto& [shell, six_volumes] : volume) {
    if (shell < 0 || shell >= static_cast<std::int32_t>(store.shells.size()) || !store.shells[shell].closed ||
        !(std::abs(six_volumes) > least))
      continue;
    const nurbs::Range faces = store.shells[shell].faces;
    const bool all_drawn =
        std::all_of(store.faces.begin() + faces.begin, store.faces.begin() + faces.end,
                    [](const nurbs::Face& f) { return f.status == nurbs::FaceStatus::kOk || f.is_mesh(); });
    if (all_drawn) result[shell] = six_volumes > 0.0 ? Hidden::kBack : Hidden::kInsideOut;
  }
  for (const tess::TessIssue& issue : instance.mesh->issues)
    if (issue.face >= 0 && issue.face < static_cast<std::int32_t>(store.faces.size()))
      result.erase(store.faces[issue.face].shell);
  return result;
}

// Fills a block's vertices: one for each (vertex, uv), or with kId one that each triangle may call its own.
class BlockVertices {
 public:
  BlockVertices(const tess::TriMesh& mesh, const nurbs::NurbsStore& store, const MeshTargets& targets,
                SeedProcess process, DrawMesh& out)
      : mesh_(mesh),
        store_(store),
        targets_(targets),
        process_(process),
        out_(out),
        first_(mesh.vertices.size(), -1),
        block_of_(mesh.vertices.size(), -1) {}

  void start(std::int32_t block) {
    block_ = block;
    begin_ = out_.x.size();
    next_.clear(), corner_uv_.clear(), owned_.clear();
  }

  std::array<std::uint16_t, 3> triangle(std::size_t t) {
    const auto& corners = mesh_.triangles[t];
    std::array<std::uint16_t, 3> at;
    if (process_ == SeedProcess::kUv) {
      for (int k = 0; k < 3; ++k) at[k] = find(t, corners[k], mesh_.corner_uv[t][k], targets_.of_triangle[t]);
      return at;
    }
    for (int k = 0; k < 3; ++k) at[k] = find(t, corners[k], dvec2(0.0), 0);
    // The last corner must be the triangle's own; the order of the corners may turn, but not reverse.
    int own = 0;
    while (own < 3 && owned_[at[own]]) ++own;
    if (own == 3) {
      own = 2;
      at[2] = add(t, corners[2]);
    }
    owned_[at[own]] = true;
    out_.id[begin_ + at[own]] = targets_.of_triangle[t];
    return {at[(own + 1) % 3], at[(own + 2) % 3], at[own]};
  }

 private:
  std::uint16_t find(std::size_t t, std::int32_t vertex, const dvec2& uv, std::uint32_t id) {
    if (block_of_[vertex] != block_) block_of_[vertex] = block_, first_[vertex] = -1;
    for (std::int32_t i = first_[vertex]; i >= 0; i = next_[i])
      if (process_ == SeedProcess::kId || (corner_uv_[i] == uv && out_.id[begin_ + i] == id))
        return static_cast<std::uint16_t>(i);
    const std::uint16_t i = add(t, vertex);
    corner_uv_[i] = uv, next_[i] = first_[vertex];
    first_[vertex] = i;
    if (process_ == SeedProcess::kUv) {
      out_.uv.back() = uv_fraction(store_.faces[mesh_.face[t]], uv);
      out_.id.back() = id;
    }
    return i;
  }

  std::uint16_t add(std::size_t, std::int32_t vertex) {
    const dvec3& p = mesh_.vertices[vertex];
    out_.x.push_back(p.x), out_.y.push_back(p.y), out_.z.push_back(p.z);
    out_.uv.push_back({0.5f, 0.5f}), out_.id.push_back(0);
    next_.push_back(-1), corner_uv_.push_back(dvec2(0.0)), owned_.push_back(false);
    return static_cast<std::uint16_t>(next_.size() - 1);
  }

  const tess::TriMesh& mesh_;
  const nurbs::NurbsStore& store_;
  const MeshTargets& targets_;
  SeedProcess process_;
  DrawMesh& out_;
  std::vector<std::int32_t> first_, block_of_;  // by vertex of the mesh
  std::int32_t block_ = -1;
  std::size_t begin_ = 0;
  // By vertex of the block.
  std::vector<std::int32_t> next_;
  std::vector<dvec2> corner_uv_;
  std::vector<bool> owned_;
};

}  // namespace

DrawMesh draw_mesh(const tess::InstanceMesh& instance, const nurbs::NurbsStore& store, SeedProcess process) {
  const tess::TriMesh& mesh = instance.mesh->mesh;
  DrawMesh out;
  MeshTargets targets = mesh_targets(mesh, store, process);
  for (const auto& t : mesh.triangles)
    for (const std::int32_t v : t) out.bounds.add(mesh.vertices[v]);
  const std::map<std::int32_t, Hidden> hidden = hidden_sides(instance, store, out.bounds);
  const auto side = [&](std::uint32_t t) {
    const auto found = hidden.find(store.faces[mesh.face[t]].shell);
    return found == hidden.end() ? Hidden::kNever : found->second;
  };

  // A block hides the same side throughout; else triangles keep their order, which goes face by face.
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  if (!hidden.empty())
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return side(a) < side(b); });
  BlockVertices vertices(mesh, store, targets, process, out);
  for (std::size_t k = 0; k < order.size();) {
    DrawBlock block;
    block.hidden = side(order[k]);
    block.vertices.begin = static_cast<std::int32_t>(out.x.size());
    block.triangles.begin = static_cast<std::int32_t>(out.triangles.size());
    vertices.start(static_cast<std::int32_t>(out.blocks.size()));
    const std::size_t end = std::min(order.size(), k + kBlockTriangles);
    for (; k < end && side(order[k]) == block.hidden; ++k) {
      out.triangles.push_back(vertices.triangle(order[k]));
      for (const std::int32_t v : mesh.triangles[order[k]]) block.bounds.add(mesh.vertices[v]);
    }
    block.vertices.end = static_cast<std::int32_t>(out.x.size());
    block.triangles.end = static_cast<std::int32_t>(out.triangles.size());
    out.blocks.push_back(block);
  }
  out.targets = std::move(targets.targets);
  return out;
}

std::vector<std::shared_ptr<const DrawMesh>> DrawMeshes::of(const tess::ViewMeshes& meshes,
                                                            const nurbs::NurbsStore& store,
                                                            SeedProcess process, int threads) {
  const std::lock_guard lock(mutex_);
  // By mesh, each once; the meshes are alive during the call, so an address tells them apart.
  std::map<const tess::Tessellation*, std::size_t> index;
  std::vector<const tess::InstanceMesh*> wanted;
  for (const tess::InstanceMesh& i : meshes.instances) {
    if (!i.mesh) throw ArgumentError("an instance has no mesh");
    if (index.try_emplace(i.mesh.get(), wanted.size()).second) wanted.push_back(&i);
  }
  std::vector<std::shared_ptr<const DrawMesh>> made(wanted.size());
  for (const Kept& k : kept_) {
    const auto source = k.source.lock();
    if (!source || k.store != &store || k.process != process) continue;
    const auto found = index.find(source.get());
    if (found != index.end()) made[found->second] = k.mesh;
  }
  parallel_ranges(wanted.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!made[i]) made[i] = std::make_shared<DrawMesh>(draw_mesh(*wanted[i], store, process));
  });
  kept_.clear();
  for (std::size_t i = 0; i < wanted.size(); ++i)
    kept_.push_back({wanted[i]->mesh, &store, process, made[i]});
  std::vector<std::shared_ptr<const DrawMesh>> result;
  for (const tess::InstanceMesh& i : meshes.instances) result.push_back(made[index[i.mesh.get()]]);
  return result;
}

}  // namespace trimray::raster
