#include "core/nurbs/build_mesh_face.h"

#include <utility>

#include "core/base/error.h"
#include "core/nurbs/mesh_store.h"

namespace trimray::nurbs {
namespace {

constexpr std::size_t kMaxSize = 100'000'000;  // triangles, and nodes

const brep::FaceData& data_of(const brep::Model& model, const WalkFace& face) {
  return model.faces[model.shapes[face.shape].data];
}

// Some writers let the triangles run clockwise; the normals tell.
bool against_normals(const brep::Mesh& mesh) {
  double sum = 0.0;
  if (mesh.normals.size() != mesh.nodes.size()) return false;
  for (const auto& t : mesh.triangles) {
    const dvec3 &a = mesh.nodes[t[0]], &b = mesh.nodes[t[1]], &c = mesh.nodes[t[2]];
    const glm::vec3 normal = mesh.normals[t[0]] + mesh.normals[t[1]] + mesh.normals[t[2]];
    sum += glm::dot(glm::cross(b - a, c - a), dvec3(normal));
  }
  return sum < 0.0;
}

}  // namespace

bool is_mesh_face(const brep::Model& model, const WalkFace& face) {
  const brep::FaceData& data = data_of(model, face);
  return data.surface < 0 && data.mesh >= 0 && !model.meshes[data.mesh].triangles.empty();
}

FaceWork build_mesh_face(const brep::Model& model, const Walk& walk, const WalkFace& face) {
  const brep::FaceData& data = data_of(model, face);
  const brep::Mesh& mesh = model.meshes[data.mesh];
  Transform place = walk.transforms[face.transform];
  if (data.location >= 0) place = place * model.locations[data.location];
  FaceWork work;
  work.form.surface.kind = SurfaceKind::kMesh;
  for (const dvec3& node : mesh.nodes) {
    work.mesh_vertices.push_back(place.point(node));
    if (!sound_vertex(work.mesh_vertices.back())) {
      refuse(work, FaceStatus::kBadSurface);
      return work;
    }
  }
  work.mesh_triangles = mesh.triangles;
  const bool turned = face.reversed != against_normals(mesh);
  for (Triangle& t : work.mesh_triangles) {
    if (turned) std::swap(t[1], t[2]);
    for (const std::int32_t v : t) work.bounds.add(work.mesh_vertices[v]);
  }
  return work;
}

void check_mesh_size(const brep::Model& model, std::span<const PrototypeWork> prototypes) {
  std::size_t triangles = 0, nodes = 0;
  for (const PrototypeWork& prototype : prototypes)
    for (const WalkFace& face : prototype.walk.faces) {
      if (!is_mesh_face(model, face)) continue;
      const brep::Mesh& mesh = model.meshes[data_of(model, face).mesh];
      triangles += mesh.triangles.size(), nodes += mesh.nodes.size();
      if (triangles > kMaxSize || nodes > kMaxSize)
        throw FormatError("B-rep: too many triangles: a triangulation is used over and over");
    }
}

}  // namespace trimray::nurbs
