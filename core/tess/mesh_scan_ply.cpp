#include <bit>
#include <cstring>
#include <optional>

#include "core/tess/mesh_scan.h"
#include "core/tess/mesh_text.h"

namespace trimray::tess {

namespace {

static_assert(std::endian::native == std::endian::little);

enum class Encoding { kText, kLittle, kBig };

struct Type {
  int size = 0;   // bytes
  char kind = 0;  // i, u, f
};

struct Property {
  std::string name;
  Type type;
  Type count;  // of a list; size 0: a single value
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::kText;
  std::vector<Element> elements;
};

Type type_of(std::string_view name, const Lines& lines) {
  if (name == "char" || name == "int8") return {1, 'i'};
  if (name == "uchar" || name == "uint8") return {1, 'u'};
  if (name == "short" || name == "int16") return {2, 'i'};
  if (name == "ushort" || name == "uint16") return {2, 'u'};
  if (name == "int" || name == "int32") return {4, 'i'};
  if (name == "uint" || name == "uint32") return {4, 'u'};
  if (name == "float" || name == "float32") return {4, 'f'};
  if (name == "double" || name == "float64") return {8, 'f'};
  lines.fail(Lines::quoted(name) + " is no type");
}

Header read_header(Lines& lines) {
  std::string_view line;
  if (!lines.next(line) || line != "ply") throw FormatError("no PLY file");
  Header header;
  bool encoded = false;
  while (lines.next(line)) {
    const std::string_view word = take_word(line);
    if (word == "format") {
      const std::string_view name = take_word(line);
      encoded = true;
      if (name == "binary_little_endian")
        header.encoding = Encoding::kLittle;
      else if (name == "binary_big_endian")
        header.encoding = Encoding::kBig;
      else if (name != "ascii")
        lines.fail(Lines::quoted(name) + " is no encoding");
    } else if (word == "element") {
      Element e;
      e.name = take_word(line);
      e.count = lines.integer(take_word(line));
      if (e.count < 0) lines.fail("a negative count");
      header.elements.push_back(std::move(e));
    } else if (word == "property") {
      if (header.elements.empty()) lines.fail("a property of nothing");
      Property p;
      std::string_view type = take_word(line);
      if (type == "list") {
        p.count = type_of(take_word(line), lines);
        if (p.count.kind == 'f') lines.fail("a count that is no integer");
        type = take_word(line);
      }
      p.type = type_of(type, lines);
      p.name = take_word(line);
      header.elements.back().properties.push_back(std::move(p));
    } else if (word == "end_header") {
      if (!encoded) lines.fail("no format given");
      return header;
    } else if (word != "comment" && word != "obj_info" && !word.empty()) {
      lines.fail(Lines::quoted(word) + " is no line of a PLY header");
    }
  }
  throw FormatError("cut off within the header");
}

// The values behind the header, one after another.
class Values {
 public:
  Values(std::string_view bytes, Encoding encoding) : rest_(bytes), encoding_(encoding) {}

  double next(Type type) {
    if (encoding_ == Encoding::kText) {
      const std::string_view word = take_word(rest_);
      double value = 0.0;
      if (word.empty()) throw FormatError("cut off: " + where());
      if (!Lines::number(word, value))
        throw FormatError(where() + ": " + Lines::quoted(word) + " is no number");
      return value;
    }
    const auto size = static_cast<std::size_t>(type.size);
    if (rest_.size() < size) throw FormatError("cut off: " + where());
    unsigned char raw[8] = {};
    for (std::size_t i = 0; i < size; ++i)
      raw[encoding_ == Encoding::kBig ? size - 1 - i : i] = static_cast<unsigned char>(rest_[i]);
    rest_.remove_prefix(size);
    if (type.kind == 'f') return size == 4 ? as<float>(raw) : as<double>(raw);
    if (size == 1) return type.kind == 'i' ? as<std::int8_t>(raw) : as<std::uint8_t>(raw);
    if (size == 2) return type.kind == 'i' ? as<std::int16_t>(raw) : as<std::uint16_t>(raw);
    return type.kind == 'i' ? as<std::int32_t>(raw) : as<std::uint32_t>(raw);
  }
  // Length of a list whose values are still to come.
  std::int64_t length(const Property& p) {
    const double n = next(p.count);
    const double most = static_cast<double>(rest_.size()) / (encoding_ == Encoding::kText ? 1 : p.type.size);
    if (!(n >= 0.0 && n <= most) || n != std::floor(n))
      throw FormatError(where() + ": a list of a wrong length");
    return static_cast<std::int64_t>(n);
  }
  void at(const char* what, std::int64_t number) { what_ = what, number_ = number; }
  std::string where() const { return std::string(what_) + " " + std::to_string(number_); }

 private:
  template <typename T>
  static double as(const unsigned char* raw) {
    T value;
    std::memcpy(&value, raw, sizeof value);
    return static_cast<double>(value);
  }
  std::string_view rest_;
  Encoding encoding_;
  const char* what_ = "";
  std::int64_t number_ = 0;
};

// Index of a colour's channel; -1: another property.
int channel_of(std::string_view name) {
  constexpr std::string_view kNames[] = {"red", "green", "blue", "alpha"};
  if (name.starts_with("diffuse_")) name.remove_prefix(8);
  for (int i = 0; i < 4; ++i) {
    if (name == kNames[i]) return i;
  }
  return -1;
}

struct Color {
  double c[4] = {0, 0, 0, 255};
  int seen = 0;  // bits
  void set(int channel, double value, Type type) {
    c[channel] = type.kind == 'f' ? 255.0 * value : value;
    seen |= 1 << channel;
  }
  bool complete() const { return (seen & 7) == 7; }
};

template <typename T>
void append(std::string& text, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  text.append(raw, sizeof value);
}

void skip(Values& values, const Property& p) {
  const std::int64_t n = p.count.size ? values.length(p) : 1;
  for (std::int64_t i = 0; i < n; ++i) values.next(p.type);
}

void read_vertices(const Element& e, Values& values, MeshScan& scan) {
  for (std::int64_t i = 0; i < e.count; ++i) {
    values.at("vertex", i);
    dvec3 point{0.0};
    int seen = 0;
    Color color;
    for (const Property& p : e.properties) {
      const int axis = p.name.size() == 1 ? p.name[0] - 'x' : -1;
      if (p.count.size) {
        skip(values, p);
      } else if (axis >= 0 && axis < 3) {
        point[axis] = values.next(p.type), seen |= 1 << axis;
        if (!std::isfinite(point[axis])) throw FormatError(values.where() + ": a coordinate is not finite");
      } else if (const int channel = channel_of(p.name); channel >= 0) {
        color.set(channel, values.next(p.type), p.type);
      } else {
        values.next(p.type);
      }
    }
    if (seen != 7) throw FormatError("vertices without x, y and z");
    scan.points.push_back(point);
    if (color.complete()) scan.point_colors.push_back(rgba(color.c, 4, false));
  }
}

void read_faces(const Element& e, Values& values, std::string& clean, MeshScan& scan) {
  for (std::int64_t i = 0; i < e.count; ++i) {
    values.at("face", i);
    Color color;
    std::int64_t corners = -1;
    for (const Property& p : e.properties) {
      if (p.count.size && (p.name == "vertex_indices" || p.name == "vertex_index") && corners < 0) {
        corners = values.length(p);
        if (corners >= 3) append(clean, static_cast<std::int32_t>(corners));
        for (std::int64_t k = 0; k < corners; ++k) {
          const double v = values.next(p.type);
          if (!(v >= 0.0 && v < 2147483647.0) || v != std::floor(v))
            throw FormatError(values.where() + ": a corner that is no vertex");
          if (corners >= 3) append(clean, static_cast<std::int32_t>(v));
        }
      } else if (const int channel = p.count.size ? -1 : channel_of(p.name); channel >= 0) {
        color.set(channel, values.next(p.type), p.type);
      } else {
        skip(values, p);
      }
    }
    if (corners < 0) throw FormatError("faces without a list of corners");
    if (corners < 3) {
      ++scan.left_out;
      continue;
    }
    ++scan.faces;
    if (color.complete()) scan.face_colors.push_back(rgba(color.c, 4, false));
  }
}

}  // namespace

MeshScan scan_ply(std::string_view bytes) {
  Lines lines(bytes);
  const Header header = read_header(lines);
  MeshScan scan;
  scan.binary = header.encoding != Encoding::kText;
  std::string faces;
  Values values(bytes.substr(std::min(lines.at(), bytes.size())), header.encoding);
  bool vertices_read = false, faces_read = false;
  for (const Element& e : header.elements) {
    // Every value takes at least a byte.
    if (e.properties.empty() ? e.count > 0
                             : e.count > static_cast<std::int64_t>(bytes.size() / e.properties.size()))
      throw FormatError("cut off: " + std::to_string(e.count) + " of element " + Lines::quoted(e.name) +
                        " declared");
    if (e.name == "vertex" && !vertices_read) {
      read_vertices(e, values, scan);
      vertices_read = true;
    } else if (e.name == "face" && !faces_read) {
      read_faces(e, values, faces, scan);
      faces_read = true;
    } else if (e.name == "tristrips" && e.count > 0) {
      throw FormatError("triangle strips are not read");
    } else {
      for (std::int64_t i = 0; i < e.count; ++i) {
        values.at("element", i);
        for (const Property& p : e.properties) skip(values, p);
      }
    }
  }
  if (!vertices_read) throw FormatError("no vertices");
  if (scan.point_colors.size() != scan.points.size()) scan.point_colors.clear();
  scan.clean = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(scan.points.size()) +
               "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
               std::to_string(scan.faces) + "\nproperty list int int vertex_indices\nend_header\n";
  for (const dvec3& p : scan.points) {
    for (int k = 0; k < 3; ++k) append(scan.clean, std::fabs(p[k]) < 3e38 ? static_cast<float>(p[k]) : 0.0f);
  }
  scan.clean += faces;
  return scan;
}

}  // namespace trimray::tess
