#include "core/tess/mesh_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <OpenMesh/Core/IO/reader/OBJReader.hh>
#include <OpenMesh/Core/IO/reader/OFFReader.hh>
#include <OpenMesh/Core/IO/reader/PLYReader.hh>
#include <OpenMesh/Core/IO/reader/STLReader.hh>

#include "core/base/error.h"
#include "core/tess/mesh_collector.h"
#include "core/tess/mesh_scan.h"
#include "core/tess/open_mesh_io.h"
#include "core/tess/polygon.h"

namespace trimray::tess {

namespace {

constexpr std::size_t kMaxColors = 1024;  // colours that become groups of their own

MeshScan scan(std::string_view bytes, MeshFormat format, const std::string& folder) {
  switch (format) {
    case MeshFormat::kStl:
      return scan_stl(bytes);
    case MeshFormat::kObj:
      return scan_obj(bytes, folder);
    case MeshFormat::kPly:
      return scan_ply(bytes);
    case MeshFormat::kOff:
      return scan_off(bytes);
  }
  throw ArgumentError("no such format");
}

void read_with_openmesh(std::string&& clean, MeshFormat format, MeshCollector& collector) {
  using OpenMesh::IO::Options;
  const OpenMeshIo io;
  std::istringstream in(std::move(clean), std::ios::binary | std::ios::in);
  Options options(format == MeshFormat::kStl ? Options::Binary : Options::FaceColor);
  bool done = false;
  switch (format) {
    case MeshFormat::kStl:
      done = OpenMesh::IO::STLReader().read(in, collector, options);
      break;
    case MeshFormat::kObj:
      done = OpenMesh::IO::OBJReader().read(in, collector, options);
      break;
    case MeshFormat::kPly:
      done = OpenMesh::IO::PLYReader().read(in, collector, options);
      break;
    case MeshFormat::kOff:
      done = OpenMesh::IO::OFFReader().read(in, collector, options);
      break;
  }
  if (!done) throw FormatError("OpenMesh cannot read it");
}

// By polygon: its colour, alpha 0 for none. Empty: no polygon has one.
std::vector<Rgba> polygon_colors(const MeshScan& scan, const MeshCollector& collector) {
  if (!scan.face_colors.empty()) return scan.face_colors;
  const std::size_t count = collector.ends.size();
  std::vector<Rgba> colors;
  if (!collector.has_color.empty()) {
    colors.resize(count, Rgba{0, 0, 0, 0});
    for (std::size_t i = 0; i < collector.has_color.size(); ++i) {
      const auto& c = collector.colors[i];
      if (collector.has_color[i]) colors[i] = {c[0], c[1], c[2], 255};
    }
  } else if (!scan.point_colors.empty()) {
    // The mean of the corners.
    colors.resize(count);
    std::size_t begin = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto end = static_cast<std::size_t>(collector.ends[i]);
      unsigned sum[4] = {};
      for (std::size_t k = begin; k < end; ++k) {
        for (int c = 0; c < 4; ++c) sum[c] += scan.point_colors[collector.corners[k]][c];
      }
      const auto corners = static_cast<unsigned>(std::max<std::size_t>(end - begin, 1));
      for (int c = 0; c < 4; ++c) colors[i][c] = static_cast<std::uint8_t>(sum[c] / corners);
      begin = end;
    }
  }
  return colors;
}

std::array<float, 4> mean_color(const std::vector<Rgba>& colors, std::span<const std::size_t> polygons) {
  double sum[4] = {}, count = 0.0;
  for (const std::size_t p : polygons) {
    if (colors[p][3] == 0) continue;
    for (int c = 0; c < 4; ++c) sum[c] += colors[p][c];
    ++count;
  }
  if (count == 0.0) return FileGroup{}.color;
  std::array<float, 4> mean;
  for (int c = 0; c < 4; ++c) mean[c] = static_cast<float>(sum[c] / count / 255.0);
  return mean;
}

// Puts the polygons into the order of the groups (the file's own ones, then by colour within each) and cuts
// them into triangles.
class Builder {
 public:
  Builder(const MeshScan& scan, const MeshCollector& collector, MeshFile& file)
      : collector_(collector), file_(file), colors_(polygon_colors(scan, collector)) {
    std::size_t distinct = 0;
    if (!colors_.empty()) {
      std::vector<Rgba> all = colors_;
      std::sort(all.begin(), all.end());
      distinct = static_cast<std::size_t>(std::unique(all.begin(), all.end()) - all.begin());
    }
    file_.mixed_colors = distinct > kMaxColors;
    std::vector<MeshScan::Group> groups = scan.groups;
    if (groups.empty()) groups.push_back({"", scan.faces});
    std::size_t begin = 0;
    for (const MeshScan::Group& group : groups) {
      std::vector<std::size_t> polygons;
      for (; begin < static_cast<std::size_t>(group.end); ++begin) polygons.push_back(begin);
      if (!polygons.empty()) add_group(group.name, polygons);
    }
  }

 private:
  void add_group(const std::string& name, const std::vector<std::size_t>& polygons) {
    if (colors_.empty() || file_.mixed_colors) {
      add_polygons(name, polygons);
      return;
    }
    // In the order in which the colours appear.
    std::map<Rgba, std::size_t> place;
    std::vector<std::vector<std::size_t>> parts;
    for (const std::size_t p : polygons) {
      const auto [it, fresh] = place.emplace(colors_[p], parts.size());
      if (fresh) parts.emplace_back();
      parts[it->second].push_back(p);
    }
    for (const auto& part : parts) add_polygons(name, part);
  }
  void add_polygons(const std::string& name, std::span<const std::size_t> polygons) {
    for (const std::size_t p : polygons) {
      const std::int64_t begin = p ? collector_.ends[p - 1] : 0, end = collector_.ends[p];
      const std::span<const std::int32_t> corners(collector_.corners.data() + begin,
                                                  collector_.corners.data() + end);
      const std::size_t before = file_.triangles.size();
      if (corners.size() >= 3) triangulate_polygon(file_.vertices, corners, file_.triangles);
      if (file_.triangles.size() == before) ++file_.left_out;
    }
    if (file_.triangles.size() > INT32_MAX) throw FormatError("too many triangles");
    const auto end = static_cast<std::int32_t>(file_.triangles.size());
    if (end == (file_.groups.empty() ? 0 : file_.groups.back().end)) return;
    FileGroup group{name, end};
    if (!colors_.empty()) group.color = mean_color(colors_, polygons);
    file_.groups.push_back(std::move(group));
  }

  const MeshCollector& collector_;
  MeshFile& file_;
  std::vector<Rgba> colors_;
};

}  // namespace

MeshFormat mesh_format(std::string_view name) {
  if (name == "stl") return MeshFormat::kStl;
  if (name == "obj") return MeshFormat::kObj;
  if (name == "ply") return MeshFormat::kPly;
  if (name == "off") return MeshFormat::kOff;
  throw ArgumentError("unknown triangle format '" + std::string(name) + "'");
}

MeshFile read_mesh(std::string_view bytes, MeshFormat format, const std::string& folder) {
  MeshScan seen = scan(bytes, format, folder);
  MeshFile file;
  file.binary = seen.binary;
  file.faces = seen.faces + seen.left_out;
  file.left_out = seen.left_out;
  MeshCollector collector;
  if (seen.faces > 0) {
    read_with_openmesh(std::move(seen.clean), format, collector);
    const bool exact = format != MeshFormat::kStl;
    if (collector.ends.size() != static_cast<std::size_t>(seen.faces) ||
        (exact && collector.points.size() != seen.points.size())) {
      throw FormatError("OpenMesh read " + std::to_string(collector.ends.size()) + " of " +
                        std::to_string(seen.faces) + " faces and " + std::to_string(collector.points.size()) +
                        " of " + std::to_string(seen.points.size()) + " vertices");
    }
    file.vertices = exact ? std::move(seen.points) : std::move(collector.points);
    Builder(seen, collector, file);
  }
  if (file.groups.empty()) file.groups.push_back({});
  return file;
}

MeshFile read_mesh_file(const std::string& path, MeshFormat format) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in || bytes.empty()) throw FormatError("cannot be read");
  return read_mesh(bytes, format, std::filesystem::path(path).parent_path().string());
}

}  // namespace trimray::tess
