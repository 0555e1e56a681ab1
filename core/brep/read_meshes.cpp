// The sections that hold polygons and triangulations. trimray draws exact surfaces only, so they are
// passed over; their counts are kept to check the indices that refer to them.
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

void skip_meshes(ByteReader& in, StreamTables& tables) {
  const std::int32_t count = in.section("Triangulations", 17);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t nodes = in.count(24);
    const std::int32_t triangles = in.count(12);
    const bool uv = in.flag();
    const bool normals = tables.version >= 4 && in.flag();
    in.real();  // deflection
    in.skip_items(nodes, 24 + (uv ? 16 : 0) + (normals ? 12 : 0));
    in.skip_items(triangles, 12);
  }
  tables.meshes = count;
}

}  // namespace trimray::brep
