// The section "TShapes": vertices, edges, faces and what is made of them, children first.
#include "core/brep/sections.h"

#include <algorithm>

namespace trimray::brep {
namespace {

// GeomAbs_Shape: 0 is C0, 1 is G1, and up to 6 for CN.
constexpr std::uint8_t kFirstSmooth = 1, kLastContinuity = 6;

std::uint8_t read_continuity(ByteReader& in) {
  const std::uint8_t value = in.byte();
  if (value > kLastContinuity) in.fail("unknown continuity");
  return value;
}

std::int32_t read_location(ByteReader& in, const StreamTables& tables) {
  return in.optional_index(tables.locations, "location");
}

std::int32_t entry(ByteReader& in, const std::vector<std::int32_t>& table, const char* what) {
  return table[in.index(table.size(), what)];
}

VertexData read_vertex(ByteReader& in, const StreamTables& tables) {
  VertexData vertex;
  vertex.tolerance = in.real();
  vertex.point = in.vec3();
  // Where the vertex lies on curves and surfaces: redundant, checked and dropped.
  while (const std::uint8_t code = in.byte()) {
    in.real();  // parameter
    switch (code) {
      case 1:
        in.optional_index(tables.curves3.size(), "curve");
        break;
      case 2:
        in.index(tables.curves2.size(), "2D curve");
        in.index(tables.surfaces.size(), "surface");
        break;
      case 3:
        in.real();  // second parameter
        in.index(tables.surfaces.size(), "surface");
        break;
      default:
        in.fail("unknown point representation");
    }
    read_location(in, tables);
  }
  return vertex;
}

// One curve on a surface, or the two of a seam (code 3) with the continuity across it.
PCurve read_pcurve(ByteReader& in, const StreamTables& tables, bool seam, bool& smooth) {
  PCurve pcurve;
  pcurve.curve = entry(in, tables.curves2, "2D curve");
  if (seam) {
    pcurve.curve2 = entry(in, tables.curves2, "2D curve");
    smooth = read_continuity(in) >= kFirstSmooth;
  }
  pcurve.surface = entry(in, tables.surfaces, "surface");
  pcurve.location = read_location(in, tables);
  pcurve.first = in.real();
  pcurve.last = in.real();
  // Versions 2 and 3 repeat the two end points in uv.
  if (tables.version == 2 || tables.version == 3) in.skip(32);
  return pcurve;
}

void read_curve_on_edge(ByteReader& in, const StreamTables& tables, EdgeData& edge) {
  const std::int32_t stream_index = in.optional_index(tables.curves3.size(), "curve");
  const std::int32_t location = read_location(in, tables);
  const double first = in.real(), last = in.real();
  if (stream_index < 0) return;
  edge.curve3 = tables.curves3[stream_index];
  edge.location = location;
  edge.first = first;
  edge.last = last;
}

EdgeData read_edge(ByteReader& in, const StreamTables& tables) {
  EdgeData edge;
  edge.tolerance = in.real();
  edge.same_parameter = in.flag();
  edge.same_range = in.flag();
  edge.degenerated = in.flag();
  bool any_smooth = false, any_sharp = false;
  while (const std::uint8_t code = in.byte()) {
    switch (code) {
      case 1:
        read_curve_on_edge(in, tables, edge);
        break;
      case 2:
      case 3: {
        bool smooth = false;
        edge.pcurves.push_back(read_pcurve(in, tables, code == 3, smooth));
        any_smooth |= smooth;
        break;
      }
      case 4: {  // regularity across two surfaces
        const bool smooth = read_continuity(in) >= kFirstSmooth;
        for (int side = 0; side < 2; ++side) {
          in.index(tables.surfaces.size(), "surface");
          read_location(in, tables);
        }
        (smooth ? any_smooth : any_sharp) = true;
        break;
      }
      case 5:
        in.index(tables.polygons3, "polygon");
        read_location(in, tables);
        break;
      case 6:
      case 7:
        in.index(tables.polygons_on_mesh, "polygon");
        if (code == 7) in.index(tables.polygons_on_mesh, "polygon");
        in.index(tables.meshes, "triangulation");
        read_location(in, tables);
        break;
      default:
        in.fail("unknown curve representation");
    }
  }
  edge.smooth = any_smooth && !any_sharp;
  return edge;
}

FaceData read_face(ByteReader& in, const StreamTables& tables) {
  FaceData face;
  face.natural_restriction = in.flag();
  face.tolerance = in.real();
  const std::int32_t surface = in.optional_index(tables.surfaces.size(), "surface");
  if (surface >= 0) face.surface = tables.surfaces[surface];
  face.location = read_location(in, tables);
  // 0: written without triangulations, 1: has none, 2: its index follows
  const std::uint8_t code = in.byte();
  if (code > 2) in.fail("unknown triangulation mark");
  if (code == 2) face.mesh = in.index(tables.meshes, "triangulation");
  return face;
}

// What OpenCascade lets stand in what; bit k of an entry allows children of kind k.
bool may_contain(ShapeKind parent, ShapeKind child) {
  constexpr auto bit = [](ShapeKind k) { return 1u << static_cast<unsigned>(k); };
  switch (parent) {
    case ShapeKind::kCompound:
      return true;
    case ShapeKind::kCompSolid:
      return child == ShapeKind::kSolid;
    case ShapeKind::kSolid:
      return bit(child) & (bit(ShapeKind::kShell) | bit(ShapeKind::kEdge) | bit(ShapeKind::kVertex));
    case ShapeKind::kShell:
      return child == ShapeKind::kFace;
    case ShapeKind::kFace:
      return bit(child) & (bit(ShapeKind::kWire) | bit(ShapeKind::kVertex));
    case ShapeKind::kWire:
      return child == ShapeKind::kEdge;
    case ShapeKind::kEdge:
      return child == ShapeKind::kVertex;
    case ShapeKind::kVertex:
      return false;
  }
  return false;
}

class ShapeReader {
 public:
  ShapeReader(ByteReader& in, Model& model, const StreamTables& tables, std::int32_t count)
      : in_(in), model_(model), tables_(tables), count_(count) {
    model_.shapes.reserve(count);
    depths_.reserve(count);
    uses_.reserve(count);
  }

  void read_one() {
    Shape shape;
    const std::uint8_t code = in_.byte();
    if (code > static_cast<std::uint8_t>(ShapeKind::kVertex)) in_.fail("unknown kind of shape");
    shape.kind = static_cast<ShapeKind>(code);
    if (shape.kind == ShapeKind::kVertex) {
      shape.data = append(model_.vertices, read_vertex(in_, tables_));
    } else if (shape.kind == ShapeKind::kEdge) {
      shape.data = append(model_.edges, read_edge(in_, tables_));
    } else if (shape.kind == ShapeKind::kFace) {
      shape.data = append(model_.faces, read_face(in_, tables_));
    }
    for (int i = 0; i < 7; ++i) {  // free, modified, checked, orientable, closed, infinite, convex
      const bool value = in_.flag();
      if (i == 4) shape.closed = value;
    }
    read_children(shape);
    model_.shapes.push_back(std::move(shape));
  }

 private:
  template <typename T>
  static std::int32_t append(std::vector<T>& list, T&& item) {
    list.push_back(std::move(item));
    return static_cast<std::int32_t>(list.size()) - 1;
  }

  void read_children(Shape& shape) {
    const auto position = static_cast<std::int32_t>(model_.shapes.size());
    int depth = 0;
    std::int64_t uses = 0;
    for (std::uint8_t code = in_.byte(); code != '*'; code = in_.byte()) {
      if (code > 3) in_.fail("unknown orientation");
      // Stored counting from the last shape: count for the first one, 1 for the last one.
      const std::int32_t stored = in_.index(static_cast<std::size_t>(count_), "shape");
      ShapeUse use;
      use.shape = count_ - 1 - stored;
      if (use.shape >= position) in_.fail("child does not stand before its parent");
      if (!may_contain(shape.kind, model_.shapes[use.shape].kind)) in_.fail("child of a wrong kind");
      use.orientation = static_cast<Orientation>(code);
      use.location = read_location(in_, tables_);
      depth = std::max(depth, depths_[use.shape] + 1);
      uses += 1 + uses_[use.shape];
      if (uses > kMaxShapeUses) in_.fail("too many uses of shapes");
      shape.children.push_back(use);
    }
    if (depth > kMaxShapeDepth) in_.fail("shapes nested too deeply");
    depths_.push_back(depth);
    uses_.push_back(uses);
  }

  ByteReader& in_;
  Model& model_;
  const StreamTables& tables_;
  std::int32_t count_;
  std::vector<int> depths_;         // longest way down from each shape
  std::vector<std::int64_t> uses_;  // uses that a walk down from each shape meets
};

}  // namespace

void read_shapes(ByteReader& in, Model& model, const StreamTables& tables) {
  in.accept("\n");
  const std::int32_t count = in.section("TShapes", 9);
  ShapeReader reader(in, model, tables, count);
  for (std::int32_t i = 0; i < count; ++i) reader.read_one();
  if (in.left() != 0) in.fail("bytes after the last shape");
}

}  // namespace trimray::brep
