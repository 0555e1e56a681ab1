#include <algorithm>

#include "core/tess/mesh_scan.h"
#include "core/tess/mesh_text.h"

namespace trimray::tess {

namespace {

// The next line that says something, without its comment.
bool next_data(Lines& lines, std::string_view& line) {
  while (lines.next(line)) {
    line = trimmed(line.substr(0, line.find('#')));
    if (!line.empty()) return true;
  }
  return false;
}

// Colour behind a face: 3 or 4 numbers, fractions when one has a point. A single one is an index into a
// table that is not there.
bool face_color(std::string_view rest, Rgba& color) {
  double c[4];
  int count = 0;
  const bool fractions = rest.find('.') != std::string_view::npos;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
    if (count == 4 || !Lines::number(word, c[count])) return false;
    ++count;
  }
  if (count < 3) return false;
  color = rgba(c, count, fractions);
  return true;
}

}  // namespace

Rgba rgba(const double* c, int count, bool fractions) {
  Rgba color{0, 0, 0, 255};
  for (int i = 0; i < count; ++i) {
    const double x = fractions ? 255.0 * c[i] : c[i];
    color[i] = static_cast<std::uint8_t>(std::clamp(x == x ? x + 0.5 : 0.0, 0.0, 255.0));
  }
  return color;
}

MeshScan scan_off(std::string_view bytes) {
  Lines lines(bytes);
  std::string_view line;
  if (!next_data(lines, line)) throw FormatError("no OFF file");
  std::string_view kind = take_word(line);
  if (!kind.ends_with("OFF")) throw FormatError("no OFF file");
  kind.remove_suffix(3);
  bool normals = false, colors = false;
  for (const char c : kind) {
    if (c == '4' || c == 'n') throw FormatError("OFF with other than three coordinates is not read");
    normals = normals || c == 'N', colors = colors || c == 'C';
  }
  if (trimmed(line) == "BINARY") throw FormatError("binary OFF is not read");
  if (line = trimmed(line); line.empty() && !next_data(lines, line)) throw FormatError("cut off");
  const std::int64_t points = lines.integer(take_word(line)), faces = lines.integer(take_word(line));
  // A point takes at least "0 0 0" and an end of line, a face as much.
  const auto most = static_cast<std::int64_t>(bytes.size() / 6 + 1);
  if (points < 0 || faces < 0 || points > most || faces > most)
    throw FormatError("cut off, or counts are wrong");

  MeshScan scan;
  for (std::int64_t i = 0; i < points; ++i) {
    if (!next_data(lines, line))
      throw FormatError("cut off: " + std::to_string(i) + " of " + std::to_string(points) + " vertices");
    dvec3 p;
    for (int k = 0; k < 3; ++k) {
      p[k] = lines.coordinate(take_word(line));
      if (std::fabs(p[k]) > 3e38) lines.fail("a coordinate too large");  // OpenMesh reads float32
      append_number(scan.clean, p[k]);
      scan.clean += k < 2 ? ' ' : '\n';
    }
    scan.points.push_back(p);
    for (int k = 0; normals && k < 3; ++k) take_word(line);
    Rgba color;
    if (colors && face_color(line, color)) scan.point_colors.push_back(color);
  }
  if (scan.point_colors.size() != scan.points.size()) scan.point_colors.clear();
  for (std::int64_t i = 0; i < faces; ++i) {
    if (!next_data(lines, line))
      throw FormatError("cut off: " + std::to_string(i) + " of " + std::to_string(faces) + " faces");
    const std::int64_t corners = lines.integer(take_word(line));
    if (corners < 0 || corners > static_cast<std::int64_t>(line.size())) lines.fail("not that many corners");
    if (corners < 3) {
      ++scan.left_out;
      continue;
    }
    scan.clean += std::to_string(corners);
    for (std::int64_t k = 0; k < corners; ++k) {
      const std::int64_t v = lines.integer(take_word(line));
      if (v < 0 || v >= points) lines.fail("corner " + std::to_string(v) + " does not exist");
      (scan.clean += ' ') += std::to_string(v);
    }
    scan.clean += '\n';
    ++scan.faces;
    Rgba color;
    if (face_color(line, color)) {
      scan.face_colors.resize(scan.faces - 1, Rgba{0, 0, 0, 0});
      scan.face_colors.push_back(color);
    }
  }
  if (!scan.face_colors.empty()) scan.face_colors.resize(scan.faces, Rgba{0, 0, 0, 0});
  scan.clean.insert(0, "OFF\n" + std::to_string(points) + ' ' + std::to_string(scan.faces) + " 0\n");
  return scan;
}

}  // namespace trimray::tess
