#include "core/trace/closed_form_leaves.h"

#include <algorithm>

namespace trimray::trace {
namespace {

using nurbs::Coverage;

constexpr int kMaxDepth = 10;          // halvings of one face's uv box
constexpr int kMixedDepth = 6;         // of them for the sake of the trim loops
constexpr double kRightAngle = 1.571;  // a little more than pi / 2
constexpr double kWorthwhile = 0.8;    // a halving must bring the boxes' area below this share

double area(const Box3& box) {
  if (box.empty()) return 0.0;
  const dvec3 e = box.extent();
  return e.x * e.y + e.y * e.z + e.z * e.x;
}

struct Splitter {
  const nurbs::TrimIndex& trim;
  const ClosedForm& form;
  std::int32_t face;
  bool all_inside;
  double small;    // mm: cells this short are not cut for the sake of the loops
  dvec2 widest;    // cells are no wider in uv
  double flat_mm;  // nor farther than this from flat
  std::vector<ClosedLeaf>& out;

  ClosedLeaf leaf(const Box2& cell) const {
    ClosedLeaf leaf;
    leaf.core = leaf.uv = cell;
    const dvec2 widen = 1e-9 * (glm::max(glm::abs(cell.lower), glm::abs(cell.upper)) + cell.extent());
    leaf.uv.lower -= widen, leaf.uv.upper += widen;
    leaf.box = closed_form_box(form, leaf.uv);
    leaf.face = face;
    const Coverage coverage = all_inside ? Coverage::kInside : trim.coverage(face, leaf.uv);
    leaf.inside = coverage == Coverage::kInside;
    if (coverage == Coverage::kOutside) leaf.box = {};
    return leaf;
  }

  void split(const ClosedLeaf& parent, int depth) {
    const Box2& cell = parent.core;
    const dvec2 extent = cell.extent(), length = closed_form_lengths(form, cell);
    const bool wide_u = is_angle_u(form.kind) && extent.x > kRightAngle;
    const bool wide_v = is_angle_v(form.kind) && extent.y > kRightAngle;
    if (depth >= kMaxDepth) return out.push_back(parent);
    // The height of an arc over its chord is about an eighth of its length times its angle.
    const dvec2 rise(
        is_angle_u(form.kind) ? length.x * extent.x / 8.0 : 0.0,
        is_angle_v(form.kind) || form.kind == nurbs::SurfaceKind::kSphere ? length.y * extent.y / 8.0 : 0.0);
    const bool bent = std::max(rise.x, rise.y) > flat_mm;
    const bool large_u = extent.x > widest.x, large_v = extent.y > widest.y;
    const bool by_u = wide_u != wide_v     ? wide_u
                      : bent               ? rise.x >= rise.y
                      : large_u != large_v ? large_u
                                           : length.x >= length.y;
    const double middle = by_u ? 0.5 * (cell.lower.x + cell.upper.x) : 0.5 * (cell.lower.y + cell.upper.y);
    Box2 cells[2] = {cell, cell};
    if (by_u)
      cells[0].upper.x = cells[1].lower.x = middle;
    else
      cells[0].upper.y = cells[1].lower.y = middle;
    const ClosedLeaf halves[2] = {leaf(cells[0]), leaf(cells[1])};
    const bool mixed = !parent.inside && depth < kMixedDepth && std::max(length.x, length.y) > small;
    const bool hugs = area(halves[0].box) + area(halves[1].box) < kWorthwhile * area(parent.box);
    if (!wide_u && !wide_v && !bent && !large_u && !large_v && !mixed && !hugs) return out.push_back(parent);
    for (const ClosedLeaf& half : halves)
      if (!half.box.empty()) split(half, depth + 1);
  }
};

}  // namespace

void append_closed_leaves(const nurbs::NurbsStore& store, const nurbs::TrimIndex& trim, std::int32_t face,
                          const ClosedForm& form, double model_diagonal, const LeafDetail& detail,
                          std::vector<ClosedLeaf>& out) {
  const nurbs::Face& f = store.faces[face];
  const double flat_mm =
      detail.flatness < kInf ? detail.flatness * closed_form_box(form, f.uv_box).diagonal() : kInf;
  // The power of two next to the parts wanted.
  const dvec2 widest = detail.parts > 1 ? std::sqrt(2.0) / detail.parts * f.uv_box.extent() : dvec2(kInf);
  Splitter splitter{trim, form, face, f.iso_rectangle, model_diagonal / 64.0, widest, flat_mm, out};
  const ClosedLeaf whole = splitter.leaf(f.uv_box);
  if (!whole.box.empty()) splitter.split(whole, 0);
}

}  // namespace trimray::trace
