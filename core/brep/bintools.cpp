#include "core/brep/bintools.h"

#include "core/brep/sections.h"

namespace trimray::brep {
namespace {

// The title line; what stands behind "V4" differs between the versions and between writers.
int read_version(ByteReader& in) {
  constexpr const char* titles[] = {"Open CASCADE Topology V1 (c)\n", "Open CASCADE Topology V2 (c)\n",
                                    "Open CASCADE Topology V3 (c)\n",
                                    "Open CASCADE Topology V4, (c) Open Cascade\n"};
  in.accept("\n");
  for (int i = 0; i < 4; ++i) {
    if (in.accept(titles[i])) return i + 1;
  }
  in.fail("not a BinTools shape set of version 1 to 4");
}

}  // namespace

Model parse_bintools(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  Model model;
  StreamTables tables;
  tables.version = read_version(in);
  read_locations(in, model, tables);
  read_curves2(in, model, tables);
  read_curves3(in, model, tables);
  skip_polygons3(in, tables);
  skip_polygons_on_mesh(in, tables);
  read_surfaces(in, model, tables);
  read_meshes(in, model, tables);
  read_shapes(in, model, tables);
  return model;
}

}  // namespace trimray::brep
