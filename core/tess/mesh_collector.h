// What OpenMesh's readers hand over, kept as it comes: no half-edges, so that no polygon is refused for
// being the third on its edge, doubled, or turned the other way.
#pragma once

#include <cstdint>
#include <vector>

#include <OpenMesh/Core/IO/importer/BaseImporter.hh>

#include "core/base/error.h"
#include "core/base/types.h"

namespace trimray::tess {

class MeshCollector final : public OpenMesh::IO::BaseImporter {
 public:
  std::vector<dvec3> points;
  std::vector<std::int32_t> corners;     // of all polygons
  std::vector<std::int64_t> ends;        // by polygon, into corners
  std::vector<OpenMesh::Vec3uc> colors;  // by polygon
  std::vector<std::uint8_t> has_color;   // by polygon

  OpenMesh::VertexHandle add_vertex(const OpenMesh::Vec3f& p) override {
    points.push_back({p[0], p[1], p[2]});
    if (points.size() > INT32_MAX) throw FormatError("too many vertices");
    return OpenMesh::VertexHandle(static_cast<int>(points.size()) - 1);
  }
  OpenMesh::VertexHandle add_vertex(const OpenMesh::Vec3d& p) override {
    return add_vertex(OpenMesh::Vec3f(p));
  }
  OpenMesh::VertexHandle add_vertex() override { return add_vertex(OpenMesh::Vec3f(0.0f, 0.0f, 0.0f)); }
  void set_point(OpenMesh::VertexHandle v, const OpenMesh::Vec3f& p) override {
    points.at(static_cast<std::size_t>(v.idx())) = {p[0], p[1], p[2]};
  }
  OpenMesh::FaceHandle add_face(const VHandles& polygon) override {
    for (const OpenMesh::VertexHandle v : polygon) {
      if (v.idx() < 0 || static_cast<std::size_t>(v.idx()) >= points.size()) {
        throw FormatError("face " + std::to_string(ends.size()) + ": corner " + std::to_string(v.idx()) +
                          " of " + std::to_string(points.size()) + " vertices does not exist");
      }
      corners.push_back(v.idx());
    }
    ends.push_back(static_cast<std::int64_t>(corners.size()));
    return OpenMesh::FaceHandle(static_cast<int>(ends.size()) - 1);
  }
  void set_color(OpenMesh::FaceHandle f, const OpenMesh::Vec3uc& color) override {
    const auto i = static_cast<std::size_t>(f.idx());
    colors.resize(ends.size()), has_color.resize(ends.size());
    colors.at(i) = color, has_color.at(i) = 1;
  }
  std::size_t n_vertices() const override { return points.size(); }
  std::size_t n_faces() const override { return ends.size(); }
  std::size_t n_edges() const override { return 0; }

  // What a reader of plain polygons does not call, or says what is not kept.
  OpenMesh::HalfedgeHandle add_edge(OpenMesh::VertexHandle, OpenMesh::VertexHandle) override {
    return OpenMesh::HalfedgeHandle();
  }
  OpenMesh::FaceHandle add_face(OpenMesh::HalfedgeHandle) override { return OpenMesh::FaceHandle(); }
  void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle,
                          const std::vector<OpenMesh::Vec2f>&) override {}
  void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle,
                          const std::vector<OpenMesh::Vec3f>&) override {}
  void set_face_texindex(OpenMesh::FaceHandle, int) override {}
  void set_halfedge(OpenMesh::VertexHandle, OpenMesh::HalfedgeHandle) override {}
  void set_normal(OpenMesh::VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_normal(OpenMesh::VertexHandle, const OpenMesh::Vec3d&) override {}
  void set_normal(OpenMesh::FaceHandle, const OpenMesh::Vec3f&) override {}
  void set_normal(OpenMesh::FaceHandle, const OpenMesh::Vec3d&) override {}
  void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec4f&) override {}
  void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec3f&) override {}
  void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec4f&) override {}
  void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec3f&) override {}
  void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec4f&) override {}
  void set_texcoord(OpenMesh::VertexHandle, const OpenMesh::Vec2f&) override {}
  void set_texcoord(OpenMesh::HalfedgeHandle, const OpenMesh::Vec2f&) override {}
  void set_texcoord(OpenMesh::VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_texcoord(OpenMesh::HalfedgeHandle, const OpenMesh::Vec3f&) override {}
  void set_status(OpenMesh::VertexHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_status(OpenMesh::HalfedgeHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_status(OpenMesh::EdgeHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_status(OpenMesh::FaceHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_next(OpenMesh::HalfedgeHandle, OpenMesh::HalfedgeHandle) override {}
  void set_face(OpenMesh::HalfedgeHandle, OpenMesh::FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void add_texture_information(int, std::string) override {}
};

}  // namespace trimray::tess
