#include <algorithm>
#include <filesystem>

#include "core/tess/mesh_scan.h"
#include "core/tess/mesh_text.h"

namespace trimray::tess {

namespace {

constexpr std::uintmax_t kMaxLibraryBytes = 16 << 20;

struct Scanner {
  explicit Scanner(std::string_view bytes) : lines(bytes) {}
  Lines lines;
  MeshScan scan;
  std::string faces;  // goes behind the vertices
  std::string object, group, material;
  std::vector<std::int64_t> corners;

  void vertex(std::string_view rest) {
    dvec3 p;
    scan.clean += 'v';
    for (int i = 0; i < 3; ++i) {
      p[i] = lines.coordinate(take_word(rest));
      if (std::fabs(p[i]) > 3e38) lines.fail("a coordinate too large");  // OpenMesh reads float32
      scan.clean += ' ';
      append_number(scan.clean, p[i]);
    }
    scan.points.push_back(p);
    // Behind the point: nothing, a weight, or a colour.
    double rgb[3];
    int count = 0;
    while (count < 3 && Lines::number(take_word(rest), rgb[count]) && rgb[count] >= 0.0 && rgb[count] <= 1.0)
      ++count;
    if (count == 3) scan.point_colors.push_back(rgba(rgb, 3, true));
    scan.clean += '\n';
  }

  // Corners as "v", "v/vt", "v//vn" or "v/vt/vn"; negative ones count back from the last vertex so far.
  void face(std::string_view rest) {
    corners.clear();
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
      if (word[0] == '#') break;
      std::int64_t v = lines.integer(word.substr(0, word.find('/')));
      const auto count = static_cast<std::int64_t>(scan.points.size());
      if (v < 0) v += count + 1;
      if (v < 1) lines.fail("corner " + Lines::quoted(word) + " does not exist");
      largest = std::max(largest, v);
      corners.push_back(v);
    }
    if (corners.size() < 3) lines.fail("a face with fewer than three corners");
    // OpenMesh leaves out what comes again; so do we, so that both count alike.
    std::size_t kept = 0;
    if (corners.size() <= 8) {
      for (const std::int64_t v : corners) {
        if (std::find(corners.begin(), corners.begin() + kept, v) == corners.begin() + kept)
          corners[kept++] = v;
      }
      corners.resize(kept);
    } else {
      std::vector<std::int64_t> sorted = corners;
      std::sort(sorted.begin(), sorted.end());
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
        lines.fail("a face with a corner twice");
    }
    if (corners.size() < 3) {
      ++scan.left_out;
      return;
    }
    faces += 'f';
    for (const std::int64_t v : corners) {
      char buffer[24];
      faces += ' ';
      faces.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, v).ptr);
    }
    faces += '\n';
    if (scan.groups.empty()) scan.groups.push_back({name(), 0});
    scan.groups.back().end = ++scan.faces;
  }

  std::string name() const {
    std::string text = object;
    for (const std::string& part : {group, material}) {
      if (!part.empty() && part != text) text += (text.empty() ? "" : " ") + part;
    }
    return text;
  }
  void begin_group() {
    if (scan.groups.empty() || scan.groups.back().end == scan.faces) {
      if (!scan.groups.empty() &&
          (scan.groups.size() > 1 ? scan.groups[scan.groups.size() - 2].end : 0) == scan.groups.back().end)
        scan.groups.back().name = name();
      else
        scan.groups.push_back({name(), scan.faces});
    }
  }

  void library(std::string_view rest, const std::string& folder) {
    const std::string_view file = trimmed(rest);
    if (folder.empty() || file.empty() || file.find('/') != std::string_view::npos) return;
    const std::filesystem::path path = std::filesystem::path(folder) / std::string(file);
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return;
    if (std::filesystem::file_size(path, error) > kMaxLibraryBytes || error) return;
    faces += "mtllib " + path.string() + '\n';
  }

  std::int64_t largest = 0;
};

}  // namespace

MeshScan scan_obj(std::string_view bytes, const std::string& folder) {
  Scanner s(bytes);
  std::string_view line;
  std::string joined;
  while (s.lines.next(line)) {
    if (!line.empty() && line.back() == '\\') {
      joined.clear();
      while (!line.empty() && line.back() == '\\') {
        joined.append(line.substr(0, line.size() - 1)) += ' ';
        if (!s.lines.next(line)) s.lines.fail("cut off");
      }
      line = joined.append(line);
    }
    std::string_view rest = line;
    const std::string_view word = take_word(rest);
    if (word == "v") {
      s.vertex(rest);
    } else if (word == "f" || word == "fo") {
      s.face(rest);
    } else if (word == "o") {
      s.object = trimmed(rest), s.group.clear(), s.begin_group();
    } else if (word == "g") {
      s.group = trimmed(rest), s.begin_group();
    } else if (word == "usemtl") {
      s.material = trimmed(rest), s.begin_group();
      s.faces += "usemtl " + std::string(take_word(rest)) + '\n';
    } else if (word == "mtllib") {
      s.library(rest, folder);
    } else if (word.find('\0') != std::string_view::npos) {
      s.lines.fail("not a text");
    }
  }
  if (s.largest > static_cast<std::int64_t>(s.scan.points.size())) {
    throw FormatError("corner " + std::to_string(s.largest) + " of " + std::to_string(s.scan.points.size()) +
                      " vertices does not exist");
  }
  if (s.scan.point_colors.size() != s.scan.points.size()) s.scan.point_colors.clear();
  s.scan.clean += s.faces;
  return std::move(s.scan);
}

}  // namespace trimray::tess
