#include "core/nurbs/shape_walk.h"

#include <array>
#include <bit>
#include <map>
#include <unordered_map>

#include "core/base/error.h"

namespace trimray::nurbs {
namespace {

constexpr int kMaxDepth = 512;
constexpr std::int64_t kMaxUses = 100'000'000;

using brep::Orientation;
using brep::ShapeKind;

bool turned(Orientation o) { return o == Orientation::kReversed; }
bool bounds_area(Orientation o) { return o == Orientation::kForward || o == Orientation::kReversed; }

class Walker {
 public:
  Walker(const brep::Model& model) : model_(model) { walk_.transforms.push_back({}); }

  Walk run(std::int32_t root) {
    visit(root, 0, false, -1, 0);
    return std::move(walk_);
  }

 private:
  static std::uint64_t key(std::int32_t a, std::int32_t b) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
  }

  // Index of parent * location; equal products share an index, so that shapes reached by different ways meet.
  std::int32_t placed(std::int32_t parent, std::int32_t location) {
    if (location < 0) return parent;
    const auto [it, fresh] = products_.try_emplace(key(parent, location), 0);
    if (!fresh) return it->second;
    const Transform& a = walk_.transforms[parent];
    const Transform& b = model_.locations[location];
    const Transform product{a.linear * b.linear, a.linear * b.translation + a.translation};
    std::array<std::uint64_t, 12> bits;
    for (int i = 0; i < 12; ++i) {
      const double x = i < 9 ? product.linear[i / 3][i % 3] : product.translation[i - 9];
      // The last bits may differ between ways; -0 and 0 are the same.
      bits[i] = x == 0.0 ? 0 : (std::bit_cast<std::uint64_t>(x) + 0x80) >> 8;
    }
    const auto [known, added] = by_bits_.try_emplace(bits, static_cast<std::int32_t>(walk_.transforms.size()));
    if (added) walk_.transforms.push_back(product);
    return it->second = known->second;
  }

  void visit(std::int32_t shape, std::int32_t transform, bool reversed, std::int32_t shell, int depth) {
    if (depth > kMaxDepth || ++uses_ > kMaxUses) throw FormatError("B-rep: the shapes nest too deep");
    const brep::Shape& s = model_.shapes[shape];
    if (s.kind == ShapeKind::kFace) return face(shape, transform, reversed, shell);
    if (s.kind == ShapeKind::kWire || s.kind == ShapeKind::kEdge || s.kind == ShapeKind::kVertex) return;
    const bool own = s.kind == ShapeKind::kShell;
    if (own) {
      shell = static_cast<std::int32_t>(walk_.shells.size());
      const std::int32_t at = static_cast<std::int32_t>(walk_.faces.size());
      walk_.shells.push_back({at, at});
    }
    for (const brep::ShapeUse& use : s.children)
      visit(use.shape, placed(transform, use.location), reversed != turned(use.orientation), shell, depth + 1);
    if (own) walk_.shells[shell].end = static_cast<std::int32_t>(walk_.faces.size());
  }

  void face(std::int32_t shape, std::int32_t transform, bool reversed, std::int32_t shell) {
    WalkFace f;
    f.shape = shape, f.transform = transform, f.reversed = reversed, f.shell = shell;
    if (shell < 0) {
      f.shell = static_cast<std::int32_t>(walk_.shells.size());
      const std::int32_t at = static_cast<std::int32_t>(walk_.faces.size());
      walk_.shells.push_back({at, at + 1});
    }
    for (const brep::ShapeUse& wire : model_.shapes[shape].children) {
      if (model_.shapes[wire.shape].kind != ShapeKind::kWire || !bounds_area(wire.orientation)) continue;
      const std::int32_t wire_transform = placed(transform, wire.location);
      std::vector<EdgeUse>& uses = f.wires.emplace_back();
      for (const brep::ShapeUse& use : model_.shapes[wire.shape].children) {
        if (++uses_ > kMaxUses) throw FormatError("B-rep: too many uses of edges");
        if (model_.shapes[use.shape].kind != ShapeKind::kEdge || !bounds_area(use.orientation)) continue;
        uses.push_back({edge(use.shape, placed(wire_transform, use.location)),
                        turned(use.orientation) != turned(wire.orientation)});
      }
      if (uses.empty()) f.wires.pop_back();
    }
    walk_.faces.push_back(std::move(f));
  }

  std::int32_t edge(std::int32_t shape, std::int32_t transform) {
    const auto [it, fresh] = edges_.try_emplace(key(shape, transform), static_cast<std::int32_t>(walk_.edges.size()));
    if (!fresh) return it->second;
    WalkEdge e;
    e.shape = shape, e.transform = transform;
    for (const brep::ShapeUse& use : model_.shapes[shape].children) {
      if (model_.shapes[use.shape].kind != ShapeKind::kVertex || !bounds_area(use.orientation)) continue;
      std::int32_t& end = e.vertex[turned(use.orientation) ? 1 : 0];
      if (end < 0) end = vertex(use.shape, placed(transform, use.location));
    }
    walk_.edges.push_back(e);
    return it->second;
  }

  std::int32_t vertex(std::int32_t shape, std::int32_t transform) {
    const auto [it, fresh] = vertices_.try_emplace(key(shape, transform), static_cast<std::int32_t>(walk_.vertices.size()));
    if (!fresh) return it->second;
    const brep::VertexData& data = model_.vertices[model_.shapes[shape].data];
    walk_.vertices.push_back({shape, transform, walk_.transforms[transform].point(data.point), data.tolerance});
    return it->second;
  }

  const brep::Model& model_;
  Walk walk_;
  std::unordered_map<std::uint64_t, std::int32_t> products_, edges_, vertices_;
  std::map<std::array<std::uint64_t, 12>, std::int32_t> by_bits_;
  std::int64_t uses_ = 0;
};

}  // namespace

Walk walk_shape(const brep::Model& model, std::int32_t root) { return Walker(model).run(root); }

}  // namespace trimray::nurbs
