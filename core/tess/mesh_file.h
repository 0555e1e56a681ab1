// Files of triangles: STL, OBJ, PLY and OFF, read and written through OpenMesh.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.h"

namespace trimray::tess {

enum class MeshFormat : std::uint8_t { kStl, kObj, kPly, kOff };

// "stl", "obj", "ply", "off". Throws ArgumentError for any other name.
MeshFormat mesh_format(std::string_view name);

// Triangles that belong together: a solid of an STL file, an o, g or usemtl of an OBJ file, one colour.
struct FileGroup {
  std::string name;      // "" where the file gives none
  std::int32_t end = 0;  // one past its last triangle; it begins where the one before ends
  std::array<float, 4> color{-1.0f, 0.0f, 0.0f, 1.0f};  // sRGB-encoded, straight alpha; red -1: none
};

struct MeshFile {
  std::vector<dvec3> vertices;                         // as they stand in the file; taken as mm
  std::vector<std::array<std::int32_t, 3>> triangles;  // into vertices, turned as in the file
  std::vector<FileGroup> groups;                       // at least one; they cover all triangles
  std::int64_t faces = 0;                              // polygons in the file
  std::int64_t left_out = 0;  // of them, those without three different corners: nothing to draw
  bool binary = false;
  bool mixed_colors = false;  // more colours than groups are worth: the groups have their mean
};

// Every polygon of the file, as triangles: non-manifold, doubled and turned ones too. STL corners with equal
// coordinates are one vertex. folder: where an OBJ file's material library may lie beside it; "" for nowhere.
// Throws FormatError for what is no such file, is cut off, or holds a coordinate that is not finite or a
// corner that does not exist.
MeshFile read_mesh(std::string_view bytes, MeshFormat format, const std::string& folder = "");

// The same from a path. Throws FormatError also where the file cannot be read.
MeshFile read_mesh_file(const std::string& path, MeshFormat format);

struct MeshToWrite {
  std::span<const dvec3> vertices;                         // mm
  std::span<const std::array<std::int32_t, 3>> triangles;  // into vertices
  std::span<const dvec3> normals;                          // by vertex, unit; empty: none. OBJ, PLY
  std::span<const std::array<float, 4>> colors;            // by triangle; empty: none. PLY, OFF
};

// The bytes of a file; STL and PLY binary (little endian). Equal meshes give equal bytes. OpenMesh
// writes coordinates as float32 in all of them. Throws ArgumentError for an index out of range or arrays of
// different lengths.
std::string write_mesh(const MeshToWrite& mesh, MeshFormat format);

}  // namespace trimray::tess
