#include "core/nurbs/shape_walk.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

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
  Walker(const brep::Model& model) : model_(model) { transform_index({}); }

  Walk run(std::int32_t root) {
    visit(root, 0, 0, false, -1, 0);
    return std::move(walk_);
  }

 private:
  static std::uint64_t key(std::int32_t a, std::int32_t b) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
  }

  // Index of parent * location.
  std::int32_t placed(std::int32_t parent, std::int32_t location) {
    if (location < 0) return parent;
    const auto [it, fresh] = products_.try_emplace(key(parent, location), 0);
    if (!fresh) return it->second;
    const Transform& a = walk_.transforms[parent];
    const Transform& b = model_.locations[location];
    const Transform product{a.linear * b.linear, a.linear * b.translation + a.translation};
    return it->second = transform_index(product);
  }

  // Products that only rounding tells apart (a placement times its inverse, two ways to one place) are one:
  // else the shapes reached by these ways would not know each other.
  std::int32_t transform_index(const Transform& product) {
    const double x = product.translation.x;
    const auto cell =
        std::isnan(x) ? 0 : static_cast<std::int64_t>(std::floor(std::clamp(x, -1e12, 1e12) * 0x1p20));
    for (std::int64_t near = cell - 1; near <= cell + 1; ++near) {
      const auto found = by_place_.find(near);
      if (found == by_place_.end()) continue;
      for (const std::int32_t i : found->second)
        if (same_placement(walk_.transforms[i], product)) return i;
    }
    const auto added = static_cast<std::int32_t>(walk_.transforms.size());
    walk_.transforms.push_back(product);
    by_place_[cell].push_back(added);
    return added;
  }

  static bool same_placement(const Transform& a, const Transform& b) {
    constexpr double kRounding = 1e-13;
    const double length = std::max(glm::length(a.translation), 1.0);
    bool same = glm::distance(a.translation, b.translation) <= kRounding * length;
    for (int i = 0; i < 3; ++i)
      same &= glm::distance(a.linear[i], b.linear[i]) <= kRounding * glm::length(a.linear[i]);
    return same;
  }

  // outer: the transform of what holds the shape.
  void visit(std::int32_t shape, std::int32_t transform, std::int32_t outer, bool reversed,
             std::int32_t shell, int depth) {
    if (depth > kMaxDepth || ++uses_ > kMaxUses) throw FormatError("B-rep: the shapes nest too deep");
    const brep::Shape& s = model_.shapes[shape];
    if (s.kind == ShapeKind::kFace) return face(shape, transform, outer, reversed, shell);
    if (s.kind == ShapeKind::kWire || s.kind == ShapeKind::kEdge || s.kind == ShapeKind::kVertex) return;
    const bool own = s.kind == ShapeKind::kShell;
    if (own) {
      shell = static_cast<std::int32_t>(walk_.shells.size());
      const std::int32_t at = static_cast<std::int32_t>(walk_.faces.size());
      walk_.shells.push_back({{at, at}, solid_, false});
    }
    const std::int32_t outer_solid = solid_;
    if (s.kind == ShapeKind::kSolid) solid_ = solids_++;
    for (const brep::ShapeUse& use : s.children)
      visit(use.shape, placed(transform, use.location), transform, reversed != turned(use.orientation), shell,
            depth + 1);
    solid_ = outer_solid;
    if (own) walk_.shells[shell].faces.end = static_cast<std::int32_t>(walk_.faces.size());
  }

  void face(std::int32_t shape, std::int32_t transform, std::int32_t outer, bool reversed,
            std::int32_t shell) {
    WalkFace f;
    f.shape = shape, f.transform = transform, f.shell = shell;
    // A mirrored shell or solid turns its faces; a face's own location does not, since its orientation speaks
    // of the surface as placed.
    f.reversed = reversed != (glm::determinant(walk_.transforms[outer].linear) < 0.0);
    if (shell < 0) {
      f.shell = static_cast<std::int32_t>(walk_.shells.size());
      const std::int32_t at = static_cast<std::int32_t>(walk_.faces.size());
      walk_.shells.push_back({{at, at + 1}, solid_, true});
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
    const auto [it, fresh] =
        edges_.try_emplace(key(shape, transform), static_cast<std::int32_t>(walk_.edges.size()));
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
    const auto [it, fresh] =
        vertices_.try_emplace(key(shape, transform), static_cast<std::int32_t>(walk_.vertices.size()));
    if (!fresh) return it->second;
    const brep::VertexData& data = model_.vertices[model_.shapes[shape].data];
    walk_.vertices.push_back(
        {shape, transform, walk_.transforms[transform].point(data.point), data.tolerance});
    return it->second;
  }

  const brep::Model& model_;
  Walk walk_;
  std::unordered_map<std::uint64_t, std::int32_t> products_, edges_, vertices_;
  std::unordered_map<std::int64_t, std::vector<std::int32_t>>
      by_place_;  // x of the translation in cells of 2^-20 mm
  std::int64_t uses_ = 0;
  std::int32_t solid_ = -1, solids_ = 0;  // the solid that is walked through, and how many there were
};

}  // namespace

Walk walk_shape(const brep::Model& model, std::int32_t root) { return Walker(model).run(root); }

}  // namespace trimray::nurbs
