// The sections that hold polygons and triangulations. Triangulations are kept: a face without a surface has
// nothing else. Polygons are passed over; their counts are kept to check the indices that refer to them.
#include "core/brep/sections.h"

namespace trimray::brep {

void skip_polygons3(ByteReader& in, StreamTables& tables) {
  const std::int32_t count = in.section("Polygon3D", 13);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t nodes = in.count(24);
    const bool parameters = in.flag();
    in.real();  // deflection
    in.skip_items(nodes, parameters ? 32 : 24);
  }
  tables.polygons3 = count;
}

void skip_polygons_on_mesh(ByteReader& in, StreamTables& tables) {
  const std::int32_t count = in.section("PolygonOnTriangulations", 13);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t nodes = in.count(4);
    in.skip_items(nodes, 4);
    in.real();  // deflection
    if (in.flag()) in.skip_items(nodes, 8);
  }
  tables.polygons_on_mesh = count;
}

void read_meshes(ByteReader& in, Model& model, StreamTables& tables) {
  const std::int32_t count = in.section("Triangulations", 17);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t nodes = in.count(24);
    const std::int32_t triangles = in.count(12);
    const bool uv = in.flag();
    const bool normals = tables.version >= 4 && in.flag();
    in.real();  // deflection
    Mesh& mesh = model.meshes.emplace_back();
    in.checked_count(nodes, 24);  // once more, now that what stands between is read
    mesh.nodes.reserve(nodes);
    for (std::int32_t k = 0; k < nodes; ++k) mesh.nodes.push_back(in.vec3());
    if (uv) in.skip_items(nodes, 16);
    in.checked_count(triangles, 12);
    mesh.triangles.reserve(triangles);
    for (std::int32_t k = 0; k < triangles; ++k) {
      std::array<std::int32_t, 3>& triangle = mesh.triangles.emplace_back();
      for (std::int32_t& corner : triangle) corner = in.index(mesh.nodes.size(), "node");
    }
    if (!normals) continue;
    in.checked_count(nodes, 12);
    mesh.normals.reserve(nodes);
    for (std::int32_t k = 0; k < nodes; ++k) mesh.normals.push_back(in.short_vec3());
  }
  tables.meshes = count;
}

}  // namespace trimray::brep
