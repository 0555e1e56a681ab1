// What stands in a triangle file, checked before OpenMesh sees it.
//
// OpenMesh's readers skip lines that they do not understand, take a damaged number for 0, round to float32,
// and do not end on some damaged headers. So each file is scanned first; OpenMesh is given a clean copy in
// the same format, and must return exactly the polygons that the scan counted.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.h"

namespace trimray::tess {

using Rgba = std::array<std::uint8_t, 4>;

struct MeshScan {
  struct Group {
    std::string name;
    std::int64_t end = 0;  // one past its last face in `clean`
  };
  std::string clean;          // for OpenMesh
  std::vector<dvec3> points;  // exact, in the file's order; empty for STL, whose vertices OpenMesh welds
  std::int64_t faces = 0;     // in `clean`
  std::int64_t left_out = 0;  // not in `clean`: fewer than three different corners
  std::vector<Group> groups;  // empty: the file names none
  bool binary = false;        // the file
  // sRGB-encoded 0..255; empty: none. OpenMesh reads colours of some of these files wrongly, so they are not
  // in `clean`; those of an OBJ file's materials come from OpenMesh.
  std::vector<Rgba> point_colors, face_colors;
};

// A colour of 3 or 4 numbers, 0..1 or 0..255.
Rgba rgba(const double* c, int count, bool fractions);

// Each throws FormatError, naming the line or the number of what is wrong.
MeshScan scan_stl(std::string_view bytes);
MeshScan scan_ply(std::string_view bytes);
MeshScan scan_off(std::string_view bytes);
// folder: of the material libraries; "" for none.
MeshScan scan_obj(std::string_view bytes, const std::string& folder);

}  // namespace trimray::tess
