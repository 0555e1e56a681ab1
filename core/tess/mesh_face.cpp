#include "core/tess/mesh_face.h"

#include <bit>

namespace trimray::tess {

std::size_t MeshFaces::PlaceHash::operator()(const std::array<double, 3>& p) const {
  std::uint64_t h = 0;
  for (const double x : p) h = (h ^ std::bit_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15u, h ^= h >> 32;
  return h;
}

void MeshFaces::add(const nurbs::NurbsStore& store, std::int32_t face, TriMesh& out) {
  const nurbs::Range& range = store.faces[face].triangles;
  for (std::int32_t t = range.begin; t < range.end; ++t) {
    std::array<std::int32_t, 3> corner;
    for (int k = 0; k < 3; ++k) {
      const dvec3& p = store.mesh_vertices[store.mesh_triangles[t][k]];
      // + 0.0: -0 and 0 are one place.
      const auto [at, fresh] = numbers_.try_emplace({p.x + 0.0, p.y + 0.0, p.z + 0.0},
                                                    static_cast<std::int32_t>(out.vertices.size()));
      if (fresh) out.vertices.push_back(p);
      corner[k] = at->second;
    }
    out.triangles.push_back(corner);
    out.corner_uv.push_back({dvec2(0, 0), dvec2(1, 0), dvec2(0, 1)});
    out.face.push_back(face);
    out.deviation.push_back(0.0);
  }
}

}  // namespace trimray::tess
