// The seeds of a tile: first hits where the raster pass says they are. Wrong seeds find nothing, or a hit
// that is not the nearest; the leaves see to both.
#include <algorithm>
#include <bit>
#include <cmath>

#include "core/hybrid/tile_tracer.h"
#include "core/trace/closed_form_lanes.h"

namespace trimray::hybrid {
namespace {

// Rays that look for one patch, or for one face with a closed form (patch -1).
struct Group {
  const InstanceView* view = nullptr;
  std::int32_t face = kNoFace, patch = -1;
  int count = 0;
  std::int32_t slots[trace::kLanes];
  trace::SeedLanes seeds;
};

// A fraction of a box's side, whatever the buffer holds.
double fraction(float x) { return x >= -0.5f && x <= 1.5f ? static_cast<double>(x) : 0.5; }

}  // namespace

void TileTracer::seeds() {
  if (view_.seeds == nullptr) return;
  const raster::SeedBuffers& seeds = *view_.seeds;
  constexpr int kGroups = 16;
  Group groups[kGroups];
  int open = 0, last = 0, next = 0;
  const auto flush = [&](Group& g) {
    if (g.count > 0)
      g.patch < 0 ? seeded_closed(*g.view, g.face, {g.slots, static_cast<std::size_t>(g.count)})
                  : seeded_patch(*g.view, g.patch, g.seeds, {g.slots, static_cast<std::size_t>(g.count)});
    g.count = 0;
  };
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(tile_.y0 + y) * seeds.width_px + tile_.x0 + x;
      const std::uint32_t id = seeds.id[pixel];
      if (id == 0 || id > seeds.targets.size()) continue;
      const raster::SeedTarget& target = seeds.targets[id - 1];
      if (target.instance < 0 || target.instance >= static_cast<std::int32_t>(view_.instances.size()))
        continue;
      const InstanceView& view = view_.instances[target.instance];
      const trace::PrototypeScene& prototype = *view.prototype;
      if (target.face < prototype.first_face || target.face >= prototype.first_face + prototype.face_count())
        continue;
      const bool own = seeds.process == raster::SeedProcess::kUv;
      const Box2& box = prototype.store.faces[target.face].uv_box;
      const dvec2 uv = box.lower + box.extent() * dvec2(fraction(own ? seeds.uv[2 * pixel] : target.u),
                                                        fraction(own ? seeds.uv[2 * pixel + 1] : target.v));
      const bool closed = prototype.form(target.face).kind != nurbs::SurfaceKind::kNone;
      const std::int32_t patch = closed ? -1 : prototype.patches.patch_at(target.face, uv);
      if (!closed && patch < 0) continue;
      const auto fits = [&](const Group& g) {
        return g.face == target.face && g.patch == patch && g.view == &view;
      };
      if (open == 0 || !fits(groups[last])) {
        last = 0;
        while (last < open && !fits(groups[last])) ++last;
        if (last == open) {
          if (open < kGroups) {
            ++open;
          } else {
            last = next, next = (next + 1) % kGroups;
            flush(groups[last]);
          }
          groups[last].view = &view, groups[last].face = target.face, groups[last].patch = patch;
        }
      }
      Group& g = groups[last];
      for (std::size_t p = 0; p < tile_.places.size(); ++p) {
        g.slots[g.count] = static_cast<std::int32_t>(p * kTileSlots) + y * kMaxTile + x;
        g.seeds.u[g.count] = uv.x, g.seeds.v[g.count] = uv.y;
        if (++g.count == trace::kLanes) flush(g);
      }
    }
  for (int i = 0; i < open; ++i) flush(groups[i]);
}

void TileTracer::seeded_patch(const InstanceView& view, std::int32_t patch, trace::SeedLanes& seeds,
                              std::span<const std::int32_t> slots) {
  trace::RayLanes lanes;
  LaneScales scales;
  const int count = rays(view, slots, lanes, scales);
  for (int k = count; k < trace::kLanes; ++k) seeds.u[k] = seeds.u[0], seeds.v[k] = seeds.v[0];
  trace::SeededRoots roots;
  view.prototype->patches.solve_seeded(patch, lanes, seeds, roots);
  stats_.solves += slots.size(), stats_.newton_roots += slots.size(), stats_.newton_steps += roots.steps;
  std::int32_t primitives[trace::kLanes];
  std::uint32_t open = 0;
  for (std::uint32_t rest = roots.one & lanes.active; rest != 0; rest &= rest - 1) {
    const int k = std::countr_zero(rest);
    const std::int32_t primitive = primitives[k] = view.prototype->leaf_primitive[roots.leaf[k]];
    state_.know(slots[k], {view.index, kNoFace, primitive, patch, roots.param_u[k], roots.param_v[k]});
    if (primitive >= 0 && roots.t[k] >= 0.0) open |= 1u << k;  // else outside the loops, or behind the eye
  }
  while (open != 0) {
    // Neighbouring rays mostly meet the same leaf.
    const std::int32_t primitive = primitives[std::countr_zero(open)];
    std::uint32_t same = 0;
    for (std::uint32_t rest = open; rest != 0; rest &= rest - 1)
      if (primitives[std::countr_zero(rest)] == primitive) same |= rest & (~rest + 1);
    open &= ~same;
    const ScenePrimitive& p = view.prototype->primitives[primitive];
    const bool reversed = view.prototype->store.faces[p.face].reversed;
    std::uint64_t tests = 0;
    const std::uint32_t in = view.prototype->inside(p, view.prototype->patches.leaves()[p.leaf].uv_face,
                                                    roots.u, roots.v, same, &tests);
    for (std::uint32_t rest = in; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const dvec3 n{roots.normal_x[k], roots.normal_y[k], roots.normal_z[k]};
      consider(view, slots[k], roots.t[k], scales, k, p.face, {roots.u[k], roots.v[k]}, reversed ? -n : n);
      ++stats_.seeded;
    }
  }
}

// The whole face at once: a closed form knows all of its roots.
void TileTracer::seeded_closed(const InstanceView& view, std::int32_t face,
                               std::span<const std::int32_t> slots) {
  const trace::ClosedForm& form = view.prototype->form(face);
  if (!trace::solves_closed_form_lanes(form.kind)) return;
  trace::RayLanes lanes;
  LaneScales scales;
  rays(view, slots, lanes, scales);
  trace::ClosedRootLanes roots;
  closed_form_lanes(form, lanes, form.uv, kZeros, kInfinities, roots);
  stats_.solves += slots.size();
  const bool reversed = view.prototype->store.faces[face].reversed;
  for (const std::int32_t slot : slots) state_.know(slot, {view.index, face, -1, -1, 0.0, 0.0});
  // A ray whose first root counts is done.
  std::uint32_t open = lanes.active;
  for (int r = 0; r < trace::kLaneRoots; ++r) {
    const std::uint32_t found = roots.found[r] & open;
    if (found == 0) continue;
    view.prototype->trim.wrap(face, roots.u[r], roots.v[r], found);
    const std::uint32_t in = view.prototype->inside(face, roots.u[r], roots.v[r], found);
    for (std::uint32_t rest = in; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const dvec3 n{roots.normal_x[r][k], roots.normal_y[r][k], roots.normal_z[r][k]};
      consider(view, slots[k], roots.t[r][k], scales, k, face, {roots.u[r][k], roots.v[r][k]},
               reversed ? -n : n);
      ++stats_.seeded;
    }
    open &= ~in;
  }
}

}  // namespace trimray::hybrid
