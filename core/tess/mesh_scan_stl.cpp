#include <array>
#include <bit>
#include <cctype>
#include <cstring>

#include "core/tess/mesh_scan.h"
#include "core/tess/mesh_text.h"

namespace trimray::tess {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kHead = 84, kRecord = 50;
// OpenMesh welds corners nearer than FLT_MIN; from here up, different floats are farther apart than that.
constexpr float kTiny = 1e-30f;

using Corners = std::array<float, 9>;

// Writes the triangle as a binary record, unless two corners are one.
void add(MeshScan& scan, Corners c) {
  for (float& x : c) {
    if (std::fabs(x) < kTiny) x = 0.0f;
  }
  const auto same = [&](int a, int b) {
    return c[3 * a] == c[3 * b] && c[3 * a + 1] == c[3 * b + 1] && c[3 * a + 2] == c[3 * b + 2];
  };
  if (same(0, 1) || same(1, 2) || same(0, 2)) {
    ++scan.left_out;
    return;
  }
  char record[kRecord] = {};
  std::memcpy(record + 12, c.data(), sizeof c);
  scan.clean.append(record, kRecord);
  ++scan.faces;
}

void scan_binary(std::string_view bytes, MeshScan& scan) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  const std::size_t there = (bytes.size() - kHead) / kRecord;
  if (there < count) {
    throw FormatError("cut off: " + std::to_string(count) + " triangles declared, " + std::to_string(there) +
                      " there");
  }
  scan.binary = true;
  scan.clean.reserve(kHead + kRecord * static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    Corners c;
    std::memcpy(c.data(), bytes.data() + kHead + kRecord * i + 12, sizeof c);
    for (const float x : c) {
      if (!std::isfinite(x))
        throw FormatError("triangle " + std::to_string(i) + ": a coordinate is not finite");
    }
    add(scan, c);
  }
}

bool begins(std::string_view line, std::string_view word) {
  if (line.size() < word.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(line[i])) != word[i]) return false;
  }
  return line.size() == word.size() || std::isspace(static_cast<unsigned char>(line[word.size()]));
}

void scan_text(std::string_view bytes, MeshScan& scan) {
  Lines lines(bytes);
  std::string_view line;
  bool in_solid = false;
  int corner = -1;  // of the open loop; -1: none is open
  Corners c{};
  const auto end_solid = [&] { scan.groups.back().end = scan.faces, in_solid = false; };
  while (lines.next(line)) {
    if (line.empty()) continue;
    if (begins(line, "vertex")) {
      if (corner < 0 || corner > 2) lines.fail("a vertex too many, or outside of a loop");
      line.remove_prefix(6);
      for (int i = 0; i < 3; ++i) {
        const auto x = static_cast<float>(lines.coordinate(take_word(line)));
        if (!std::isfinite(x)) lines.fail("a coordinate too large for STL");
        c[3 * corner + i] = x;
      }
      ++corner;
    } else if (begins(line, "outer")) {
      if (corner >= 0 || !in_solid) lines.fail("a loop within another, or outside of a solid");
      corner = 0;
    } else if (begins(line, "endloop")) {
      if (corner != 3) lines.fail("a loop without three vertices");
      add(scan, c);
      corner = -1;
    } else if (begins(line, "solid")) {
      if (in_solid) lines.fail("a solid within another");
      in_solid = true;
      scan.groups.push_back({std::string(trimmed(line.substr(5))), 0});
    } else if (begins(line, "endsolid") || begins(line, "end")) {
      if (!in_solid || corner >= 0) lines.fail("a solid ends that has not begun, or within a loop");
      end_solid();
    } else if (!begins(line, "facet") && !begins(line, "endfacet") && !begins(line, "color")) {
      lines.fail(Lines::quoted(line) + " is no line of an STL file");
    }
  }
  if (in_solid) throw FormatError("cut off: the last solid has no end");
}

}  // namespace

MeshScan scan_stl(std::string_view bytes) {
  MeshScan scan;
  scan.clean.assign(kHead, '\0');
  std::uint32_t count = 0;
  if (bytes.size() >= kHead) std::memcpy(&count, bytes.data() + 80, 4);
  // Binary files may begin with "solid" too; their size tells.
  const bool exact =
      bytes.size() >= kHead && bytes.size() == kHead + kRecord * static_cast<std::size_t>(count);
  const std::string_view text = trimmed(bytes.substr(0, 512));
  if (!exact && begins(text.substr(0, 6), "solid") &&
      bytes.substr(0, 512).find('\0') == std::string_view::npos)
    scan_text(bytes, scan);
  else if (bytes.size() >= kHead)
    scan_binary(bytes, scan);
  else
    throw FormatError("too short for an STL file");
  if (scan.faces > UINT32_MAX) throw FormatError("too many triangles");
  const auto faces = static_cast<std::uint32_t>(scan.faces);
  std::memcpy(scan.clean.data() + 80, &faces, 4);
  return scan;
}

}  // namespace trimray::tess
