// Writing: OpenMesh's writers over plain arrays.
#include <sstream>

#include <OpenMesh/Core/IO/exporter/BaseExporter.hh>
#include <OpenMesh/Core/IO/writer/OBJWriter.hh>
#include <OpenMesh/Core/IO/writer/OFFWriter.hh>
#include <OpenMesh/Core/IO/writer/PLYWriter.hh>
#include <OpenMesh/Core/IO/writer/STLWriter.hh>

#include "core/base/error.h"
#include "core/tess/mesh_file.h"
#include "core/tess/open_mesh_io.h"

namespace trimray::tess {

namespace {

using namespace OpenMesh;  // NOLINT: the overrides below name little else

class Exporter final : public IO::BaseExporter {
 public:
  explicit Exporter(const MeshToWrite& mesh) : mesh_(mesh) {}

  Vec3f point(VertexHandle v) const override { return Vec3f(pointd(v)); }
  Vec3d pointd(VertexHandle v) const override { return vec(mesh_.vertices[at(v)]); }
  bool is_point_double() const override { return true; }
  Vec3f normal(VertexHandle v) const override { return Vec3f(normald(v)); }
  // The OBJ writer asks for normals even where there are none.
  Vec3d normald(VertexHandle v) const override {
    return mesh_.normals.empty() ? Vec3d(0.0) : vec(mesh_.normals[at(v)]);
  }
  bool is_normal_double() const override { return true; }
  unsigned int get_vhandles(FaceHandle f, std::vector<VertexHandle>& corners) const override {
    corners.clear();
    for (const std::int32_t v : mesh_.triangles[at(f)]) corners.emplace_back(v);
    return 3;
  }
  Vec3f normal(FaceHandle f) const override { return Vec3f(normald(f)); }
  Vec3d normald(FaceHandle f) const override {
    const auto& [a, b, c] = mesh_.triangles[at(f)];
    const dvec3 n = glm::cross(mesh_.vertices[b] - mesh_.vertices[a], mesh_.vertices[c] - mesh_.vertices[a]);
    const double length = glm::length(n);
    return vec(length > 0.0 ? n / length : dvec3(0.0));
  }
  Vec4f colorAf(FaceHandle f) const override {
    const auto& c = mesh_.colors[at(f)];
    return {c[0], c[1], c[2], c[3]};
  }
  Vec3f colorf(FaceHandle f) const override {
    const Vec4f c = colorAf(f);
    return {c[0], c[1], c[2]};
  }
  Vec4uc colorA(FaceHandle f) const override {
    const Vec4ui c = colorAi(f);
    return Vec4uc(c);
  }
  Vec3uc color(FaceHandle f) const override { return Vec3uc(colori(f)); }
  Vec4ui colorAi(FaceHandle f) const override {
    Vec4ui result;
    for (int i = 0; i < 4; ++i) {
      const float x = colorAf(f)[i];
      result[i] = x > 0.0f ? static_cast<unsigned>(255.0f * std::min(x, 1.0f) + 0.5f) : 0u;
    }
    return result;
  }
  Vec3ui colori(FaceHandle f) const override {
    const Vec4ui c = colorAi(f);
    return {c[0], c[1], c[2]};
  }
  // The PLY writer looks for properties of its own in it.
  const BaseKernel* kernel() override { return &kernel_; }
  std::size_t n_vertices() const override { return mesh_.vertices.size(); }
  std::size_t n_faces() const override { return mesh_.triangles.size(); }
  std::size_t n_edges() const override { return 0; }
  bool is_triangle_mesh() const override { return true; }
  bool has_vertex_normals() const override { return !mesh_.normals.empty(); }
  bool has_face_normals() const override { return true; }
  bool has_face_colors() const override { return !mesh_.colors.empty(); }

  // Never asked for under the options below.
  Vec3uc color(VertexHandle) const override { return Vec3uc(std::uint8_t{0}); }
  Vec4uc colorA(VertexHandle) const override { return Vec4uc(std::uint8_t{0}); }
  Vec3ui colori(VertexHandle) const override { return Vec3ui(0); }
  Vec4ui colorAi(VertexHandle) const override { return Vec4ui(0); }
  Vec3f colorf(VertexHandle) const override { return Vec3f(0); }
  Vec4f colorAf(VertexHandle) const override { return Vec4f(0); }
  Vec2f texcoord(VertexHandle) const override { return Vec2f(0); }
  Vec2f texcoord(HalfedgeHandle) const override { return Vec2f(0); }
  HalfedgeHandle getHeh(FaceHandle, VertexHandle) const override { return HalfedgeHandle(); }
  unsigned int get_face_texcoords(std::vector<Vec2f>&) const override { return 0; }
  Vec3uc color(EdgeHandle) const override { return Vec3uc(std::uint8_t{0}); }
  Vec4uc colorA(EdgeHandle) const override { return Vec4uc(std::uint8_t{0}); }
  Vec3ui colori(EdgeHandle) const override { return Vec3ui(0); }
  Vec4ui colorAi(EdgeHandle) const override { return Vec4ui(0); }
  Vec3f colorf(EdgeHandle) const override { return Vec3f(0); }
  Vec4f colorAf(EdgeHandle) const override { return Vec4f(0); }
  Attributes::StatusInfo status(VertexHandle) const override { return {}; }
  Attributes::StatusInfo status(FaceHandle) const override { return {}; }
  Attributes::StatusInfo status(EdgeHandle) const override { return {}; }
  Attributes::StatusInfo status(HalfedgeHandle) const override { return {}; }
  int get_halfedge_id(VertexHandle) override { return -1; }
  int get_halfedge_id(FaceHandle) override { return -1; }
  int get_next_halfedge_id(HalfedgeHandle) override { return -1; }
  int get_to_vertex_id(HalfedgeHandle) override { return -1; }
  int get_face_id(HalfedgeHandle) override { return -1; }

 private:
  template <typename Handle>
  static std::size_t at(Handle h) {
    return static_cast<std::size_t>(h.idx());
  }
  static Vec3d vec(const dvec3& v) { return {v.x, v.y, v.z}; }

  const MeshToWrite& mesh_;
  const BaseKernel kernel_;
};

void check(const MeshToWrite& mesh) {
  if (!mesh.normals.empty() && mesh.normals.size() != mesh.vertices.size())
    throw ArgumentError("as many normals as vertices are needed");
  if (!mesh.colors.empty() && mesh.colors.size() != mesh.triangles.size())
    throw ArgumentError("as many colours as triangles are needed");
  for (const auto& triangle : mesh.triangles) {
    for (const std::int32_t v : triangle) {
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.vertices.size())
        throw ArgumentError("triangle corner " + std::to_string(v) + " is no vertex");
    }
  }
}

}  // namespace

std::string write_mesh(const MeshToWrite& wanted, MeshFormat format) {
  using IO::Options;
  check(wanted);
  MeshToWrite mesh = wanted;
  if (format == MeshFormat::kOff) mesh.normals = {};  // its writer puts them where few others look
  const OpenMeshIo io;
  Exporter exporter(mesh);
  std::ostringstream out(std::ios::binary | std::ios::out);
  Options options;
  if (exporter.has_vertex_normals()) options += Options::VertexNormal;
  if (exporter.has_face_colors()) options += Options::FaceColor | Options::ColorAlpha;
  constexpr std::streamsize kDigits = 9;  // a float's text reads back to the same float
  bool done = false;
  switch (format) {
    case MeshFormat::kStl:
      done = IO::STLWriter().write(out, exporter, Options(Options::Binary), kDigits);
      break;
    case MeshFormat::kPly:
      options += Options::Binary | Options::LSB;
      done = IO::PLYWriter().write(out, exporter, options, kDigits);
      break;
    case MeshFormat::kObj:
      options -= Options::FaceColor | Options::ColorAlpha;  // would need a file of materials beside it
      done = IO::OBJWriter().write(out, exporter, options, kDigits);
      break;
    case MeshFormat::kOff:
      done = IO::OFFWriter().write(out, exporter, options, kDigits);
      break;
  }
  if (!done || !out) throw Error("OpenMesh cannot write the mesh");
  std::string bytes = std::move(out).str();
  // OpenMesh calls a file with colours of faces COFF, which elsewhere means colours of vertices.
  if (format == MeshFormat::kOff && bytes.starts_with("COFF")) bytes.erase(0, 1);
  return bytes;
}

}  // namespace trimray::tess
