#include "core/nurbs/trim.h"

#include <bit>
#include <cmath>

#include "core/base/parallel.h"
#include "core/nurbs/trim_grid.h"

namespace trimray::nurbs {
namespace {

enum class Rule : std::uint8_t { kNothing, kBox, kLoops };

struct FaceTrim {
  Rule rule = Rule::kNothing;
  Box2 box;  // kBox: lower <= uv < upper, the half-open rule's own answer; infinite where nothing ends
  dvec2 middle{0.0}, period{0.0};
  TrimGrid grid;
};

// A direction that runs all the way round has no end to be outside of.
bool full_period(double extent, double period) { return period > 0.0 && extent >= period * (1.0 - 1e-9); }

double wrapped(double x, double middle, double period) {
  const double turns = (x - middle) / period + 0.5;
  if (turns >= 0.0 && turns < 1.0) return x;  // most are, and floor() is a call
  return x - period * std::floor(turns);
}

FaceTrim make_face_trim(const NurbsStore& store, std::int32_t index) {
  FaceTrim out;
  const Face& face = store.faces[index];
  if (face.status != FaceStatus::kOk) return out;
  Surface none;
  const Surface& surface = face.surface >= 0 ? store.surfaces[face.surface] : none;
  const bool untrimmed = face.loops.size() == 0;
  const Box2 box = untrimmed && face.uv_box.empty() ? surface.domain : face.uv_box;
  if (!box.empty()) out.middle = box.center();
  if (surface.periodic_u) out.period.x = surface.period_u;
  if (surface.periodic_v) out.period.y = surface.period_v;
  if (!untrimmed && !face.iso_rectangle) {
    out.rule = Rule::kLoops;
    out.grid = TrimGrid(cut_trim_loops(store, index));
    return out;
  }
  out.rule = box.empty() ? Rule::kNothing : Rule::kBox;
  out.box = box;
  for (int axis = 0; axis < 2; ++axis) {
    if (full_period(box.extent()[axis], out.period[axis])) {
      out.box.lower[axis] = -kInf, out.box.upper[axis] = kInf;
    } else if (untrimmed) {
      // No edge runs here (a pole, or a closed surface): the domain's own end belongs to the face, and
      // rounding must not throw a root off it.
      const double margin = 1e-12 * (1.0 + box.extent()[axis]);
      out.box.lower[axis] -= margin, out.box.upper[axis] += margin;
    }
  }
  return out;
}

}  // namespace

struct TrimIndex::Impl {
  std::vector<FaceTrim> faces;
};

TrimIndex::TrimIndex(const NurbsStore& store, int threads) : impl_(std::make_unique<Impl>()) {
  impl_->faces.resize(store.faces.size());
  parallel_ranges(store.faces.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      impl_->faces[i] = make_face_trim(store, static_cast<std::int32_t>(i));
  });
}
TrimIndex::TrimIndex(TrimIndex&&) noexcept = default;
TrimIndex& TrimIndex::operator=(TrimIndex&&) noexcept = default;
TrimIndex::~TrimIndex() = default;

bool TrimIndex::inside(std::int32_t face, dvec2 uv) const {
  const FaceTrim& f = impl_->faces[face];
  if (f.rule == Rule::kLoops) return f.grid.inside(uv);
  return f.rule == Rule::kBox && uv.x >= f.box.lower.x && uv.x < f.box.upper.x && uv.y >= f.box.lower.y &&
         uv.y < f.box.upper.y;
}

std::uint32_t TrimIndex::inside(std::int32_t face, const double* u, const double* v,
                                std::uint32_t which) const {
  const FaceTrim& f = impl_->faces[face];
  if (f.rule == Rule::kLoops) return f.grid.inside(u, v, which);
  if (f.rule == Rule::kNothing) return 0;
  std::uint32_t result = 0;
  for (std::uint32_t rest = which; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    if (u[i] >= f.box.lower.x && u[i] < f.box.upper.x && v[i] >= f.box.lower.y && v[i] < f.box.upper.y)
      result |= 1u << i;
  }
  return result;
}

dvec2 TrimIndex::wrap(std::int32_t face, dvec2 uv) const {
  const FaceTrim& f = impl_->faces[face];
  for (int axis = 0; axis < 2; ++axis)
    if (f.period[axis] > 0.0) uv[axis] = wrapped(uv[axis], f.middle[axis], f.period[axis]);
  return uv;
}

void TrimIndex::wrap(std::int32_t face, double* u, double* v, std::uint32_t which) const {
  const FaceTrim& f = impl_->faces[face];
  for (int axis = 0; axis < 2; ++axis) {
    if (!(f.period[axis] > 0.0)) continue;
    double* const x = axis == 0 ? u : v;
    for (std::uint32_t rest = which; rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      x[i] = wrapped(x[i], f.middle[axis], f.period[axis]);
    }
  }
}

bool TrimIndex::wraps(std::int32_t face) const {
  const dvec2& period = impl_->faces[face].period;
  return period.x > 0.0 || period.y > 0.0;
}

Coverage TrimIndex::coverage(std::int32_t face, const Box2& query) const {
  const FaceTrim& f = impl_->faces[face];
  if (f.rule == Rule::kNothing || query.empty()) return Coverage::kOutside;
  if (f.rule == Rule::kLoops) {
    const int covered = f.grid.coverage(query);
    return covered > 0 ? Coverage::kInside : covered < 0 ? Coverage::kOutside : Coverage::kMixed;
  }
  if (query.upper.x < f.box.lower.x || query.lower.x >= f.box.upper.x || query.upper.y < f.box.lower.y ||
      query.lower.y >= f.box.upper.y)
    return Coverage::kOutside;
  const bool within = query.lower.x >= f.box.lower.x && query.upper.x < f.box.upper.x &&
                      query.lower.y >= f.box.lower.y && query.upper.y < f.box.upper.y;
  return within ? Coverage::kInside : Coverage::kMixed;
}

}  // namespace trimray::nurbs
