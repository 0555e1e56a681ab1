// The file of a store: one header, then every array in the order of NurbsStore.
//
//   header   8 bytes magic, u32 byte-order mark, u32 version, u64 bytes after the header, u64 checksum of
//   these array    u64 count, then its elements: plain numbers as they lie in memory, records field by field
//   (so that
//            no padding is written and no bool or enum is read from an arbitrary byte)
#include "core/nurbs/store_file.h"

#include <bit>
#include <cstring>

#include "core/base/error.h"
#include "core/nurbs/store.h"

namespace trimray::nurbs {
namespace {

constexpr char kMagic[8] = {'T', 'R', 'M', 'S', 'T', 'O', 'R', 'E'};
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::uint32_t kVersion = 3;
constexpr std::size_t kHeader = 32;

// Four lanes of multiply and rotate over 32-byte blocks; the length is mixed in. Not cryptographic.
std::uint64_t checksum(std::span<const std::byte> bytes) {
  constexpr std::uint64_t a = 0x9E3779B185EBCA87u, b = 0xC2B2AE3D27D4EB4Fu;
  std::uint64_t lane[4] = {a, b, a ^ b, bytes.size() * b + 1};
  const auto mix = [&](const std::byte* from) {
    for (int i = 0; i < 4; ++i) {
      std::uint64_t word;
      std::memcpy(&word, from + 8 * i, 8);
      lane[i] = std::rotl(lane[i] + word * b, 31) * a;
    }
  };
  std::size_t at = 0;
  for (; at + 32 <= bytes.size(); at += 32) mix(bytes.data() + at);
  std::byte tail[32] = {};
  if (at < bytes.size()) std::memcpy(tail, bytes.data() + at, bytes.size() - at);
  mix(tail);
  std::uint64_t h = 0;
  for (const std::uint64_t l : lane) h = (std::rotl(h, 27) ^ l) * a + b;
  return h ^ (h >> 29);
}

class Writer {
 public:
  std::vector<std::byte> out;

  template <typename T>
  void plain(const T& value) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
    const std::size_t at = out.size();
    out.resize(at + sizeof(T));
    std::memcpy(out.data() + at, &value, sizeof(T));
  }
  void flag(const bool& value) { plain<std::uint8_t>(value ? 1 : 0); }
  template <typename T>
  void choice(const T& value, T) {
    plain(static_cast<std::uint8_t>(value));
  }
  template <typename T>
  void block(const T& array) {
    plain<std::uint64_t>(array.size());
    const std::size_t at = out.size(), bytes = array.size() * sizeof(array[0]);
    out.resize(at + bytes);
    if (bytes > 0) std::memcpy(out.data() + at, array.data(), bytes);
  }
  template <typename T, typename Each>
  void records(const std::vector<T>& array, std::size_t, const Each& each) {
    plain<std::uint64_t>(array.size());
    for (const T& record : array) each(*this, record);
  }
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : in_(bytes) {}

  template <typename T>
  void plain(T& value) {
    need(sizeof(T));
    std::memcpy(&value, in_.data() + at_, sizeof(T));
    at_ += sizeof(T);
  }
  void flag(bool& value) {
    std::uint8_t byte = 0;
    plain(byte);
    if (byte > 1) throw FormatError("NURBS store file: a flag is neither 0 nor 1");
    value = byte == 1;
  }
  template <typename T>
  void choice(T& value, T last) {
    std::uint8_t byte = 0;
    plain(byte);
    if (byte > static_cast<std::uint8_t>(last)) throw FormatError("NURBS store file: an unknown kind");
    value = static_cast<T>(byte);
  }
  template <typename T>
  void block(T& array) {
    const std::size_t n = count(sizeof(array[0]));
    array.resize(n);
    if (n > 0) std::memcpy(array.data(), in_.data() + at_, n * sizeof(array[0]));
    at_ += n * sizeof(array[0]);
  }
  // least: bytes that a record takes at least, so that a wrong count cannot ask for much memory.
  template <typename T, typename Each>
  void records(std::vector<T>& array, std::size_t least, const Each& each) {
    array.resize(count(least));
    for (T& record : array) each(*this, record);
  }
  void end() const {
    if (at_ != in_.size()) throw FormatError("NURBS store file: bytes behind the end");
  }

 private:
  void need(std::size_t bytes) const {
    if (bytes > in_.size() - at_) throw FormatError("NURBS store file: cut short");
  }
  std::size_t count(std::size_t bytes_each) {
    std::uint64_t n = 0;
    plain(n);
    if (n > (in_.size() - at_) / bytes_each) throw FormatError("NURBS store file: a count exceeds the file");
    return static_cast<std::size_t>(n);
  }

  std::span<const std::byte> in_;
  std::size_t at_ = 0;
};

// The field lists below serve both directions: S is const for the writer.
void range(auto& file, auto& r) { file.plain(r.begin), file.plain(r.end); }

void vec(auto& file, auto& v) {
  for (int i = 0; i < v.length(); ++i) file.plain(v[i]);
}

void box(auto& file, auto& b) { vec(file, b.lower), vec(file, b.upper); }

void color(auto& file, auto& c) {
  for (int i = 0; i < 4; ++i) file.plain(c[i]);
}

void surface(auto& file, auto& f) {
  file.choice(f.kind, SurfaceKind::kNone), file.choice(f.basis, SurfaceKind::kNone);
  file.plain(f.conic);
  file.flag(f.rational), file.flag(f.periodic_u), file.flag(f.periodic_v);
  file.choice(f.map_u, ParamMap::kHyperbolic), file.choice(f.map_v, ParamMap::kHyperbolic);
  file.plain(f.degree_u), file.plain(f.degree_v), file.plain(f.count_u), file.plain(f.count_v);
  range(file, f.knots_u), range(file, f.knots_v), range(file, f.ctrl);
  file.plain(f.period_u), file.plain(f.period_v), file.plain(f.offset);
  box(file, f.domain);
  vec(file, f.location), vec(file, f.x_axis), vec(file, f.y_axis), vec(file, f.z_axis);
  file.plain(f.r1), file.plain(f.r2), file.plain(f.semi_angle);
}

void conic(auto& file, auto& c) {
  file.choice(c.kind, ConicKind::kHyperbola);
  vec(file, c.location), vec(file, c.x_axis), vec(file, c.y_axis);
  file.plain(c.r1), file.plain(c.r2);
}

void face(auto& file, auto& f) {
  file.plain(f.surface), file.plain(f.prototype), file.plain(f.shell), file.plain(f.shape);
  range(file, f.loops), range(file, f.triangles);
  file.choice(f.status, FaceStatus::kUnsupported);
  file.flag(f.reversed), file.flag(f.iso_rectangle);
  box(file, f.uv_box);
  color(file, f.color);
}

void coedge(auto& file, auto& c) {
  file.plain(c.edge), file.plain(c.loop), file.plain(c.face);
  file.flag(c.reversed), file.flag(c.seam);
  range(file, c.pieces);
  file.plain(c.conic);
}

void edge(auto& file, auto& e) {
  range(file, e.pieces);
  file.plain(e.vertex[0]), file.plain(e.vertex[1]);
  range(file, e.coedges);
  file.plain(e.conic), file.plain(e.tolerance), file.plain(e.band);
  file.flag(e.degenerate), file.flag(e.smooth);
}

void shell(auto& file, auto& s) {
  file.plain(s.prototype);
  range(file, s.faces);
  file.flag(s.closed), file.flag(s.lone);
  file.plain(s.solid);
}

void prototype(auto& file, auto& p) {
  range(file, p.faces), range(file, p.edges), range(file, p.vertices), range(file, p.shells);
  box(file, p.bounds);
  color(file, p.color);
}

void instance(auto& file, auto& n) {
  file.plain(n.prototype);
  for (int i = 0; i < 3; ++i) vec(file, n.placement.linear[i]);
  vec(file, n.placement.translation);
  color(file, n.color);
}

static_assert(sizeof(Loop) == 12 && sizeof(CurvePiece) == 24 && sizeof(Vertex) == 32,
              "written as blocks: no padding");
static_assert(sizeof(dvec4) == 32 && sizeof(dvec3) == 24 && sizeof(Triangle) == 12);

void arrays(auto& file, auto& store) {
  file.records(store.surfaces, 200, [](auto& f, auto& x) { surface(f, x); });
  file.block(store.knots);
  file.block(store.ctrl_h);
  file.records(store.conics, 89, [](auto& f, auto& x) { conic(f, x); });
  file.records(store.faces, 83, [](auto& f, auto& x) { face(f, x); });
  file.block(store.loops);
  file.records(store.coedges, 20, [](auto& f, auto& x) { coedge(f, x); });
  file.block(store.trim_pieces);
  file.block(store.trim_ctrl_h);
  file.records(store.edges, 40, [](auto& f, auto& x) { edge(f, x); });
  file.block(store.edge_coedges);
  file.block(store.edge_pieces);
  file.block(store.edge_ctrl_h);
  file.block(store.vertices);
  file.block(store.mesh_vertices);
  file.block(store.mesh_triangles);
  file.records(store.shells, 13, [](auto& f, auto& x) { shell(f, x); });
  file.records(store.prototypes, 96, [](auto& f, auto& x) { prototype(f, x); });
  file.records(store.instances, 116, [](auto& f, auto& x) { instance(f, x); });
  file.block(store.meta);
}

template <typename T>
void put(std::span<std::byte> bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

template <typename T>
T get(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

}  // namespace

std::vector<std::byte> save_store(const NurbsStore& store) {
  Writer file;
  file.out.reserve(
      kHeader + store.surfaces.size() * 300 + (store.knots.size() + 4 * store.ctrl_h.size()) * 8 +
      store.faces.size() * 80 + store.coedges.size() * 28 + store.edges.size() * 52 +
      store.conics.size() * 89 + store.trim_pieces.size() * 24 + store.trim_ctrl_h.size() * 24 +
      store.edge_pieces.size() * 24 + store.edge_ctrl_h.size() * 32 + store.vertices.size() * 32 +
      store.mesh_vertices.size() * 24 + store.mesh_triangles.size() * 12 + store.instances.size() * 128 +
      store.meta.size() + 4096);
  file.out.resize(kHeader);
  arrays(file, store);
  std::vector<std::byte>& bytes = file.out;
  std::memcpy(bytes.data(), kMagic, sizeof kMagic);
  put(bytes, 8, kByteOrder);
  put(bytes, 12, kVersion);
  reseal_store(bytes);
  return std::move(file.out);
}

void reseal_store(std::span<std::byte> file) {
  if (file.size() < kHeader) return;
  put<std::uint64_t>(file, 16, file.size() - kHeader);
  put<std::uint64_t>(file, 24, checksum(file.subspan(kHeader)));
}

NurbsStore load_store(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeader || std::memcmp(bytes.data(), kMagic, sizeof kMagic) != 0)
    throw FormatError("not a NURBS store file");
  if (get<std::uint32_t>(bytes, 8) != kByteOrder)
    throw FormatError("NURBS store file: of a machine with another byte order");
  if (get<std::uint32_t>(bytes, 12) != kVersion)
    throw FormatError("NURBS store file: version " + std::to_string(get<std::uint32_t>(bytes, 12)) +
                      ", expected " + std::to_string(kVersion));
  if (get<std::uint64_t>(bytes, 16) != bytes.size() - kHeader)
    throw FormatError("NURBS store file: wrong length");
  if (get<std::uint64_t>(bytes, 24) != checksum(bytes.subspan(kHeader)))
    throw FormatError("NURBS store file: wrong checksum");
  NurbsStore store;
  Reader file(bytes.subspan(kHeader));
  arrays(file, store);
  file.end();
  validate(store);
  return store;
}

}  // namespace trimray::nurbs
