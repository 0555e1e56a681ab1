// The functions of targets.h that need the tessellator.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/base/error.h"
#include "core/nurbs/store.h"
#include "core/nurbs/store_file.h"
#include "core/tess/mesh_check.h"
#include "core/tess/mesh_measure.h"
#include "core/tess/tessellate.h"

namespace trimray::fuzz {

// Control points, of surfaces and curves, that a fuzzed store may have: more only makes it slow.
inline constexpr std::size_t kMaxFuzzPoints = 5000;

// Bytes -> NurbsStore -> the mesh of every prototype, coarse. Whatever loads can be meshed: the arrays fit
// one another and the store, and no deviation is negative or NaN.
inline void mesh_saved(std::span<const std::byte> bytes) {
  std::vector<std::byte> file(bytes.begin(), bytes.end());
  nurbs::reseal_store(file);
  nurbs::NurbsStore store;
  try {
    store = nurbs::load_store(file);
  } catch (const FormatError&) {
    return;
  }
  if (store.ctrl_h.size() + store.edge_ctrl_h.size() + store.trim_ctrl_h.size() > kMaxFuzzPoints) return;
  for (std::size_t p = 0; p < store.prototypes.size(); ++p) {
    const double size = store.prototypes[p].bounds.diagonal();
    if (!(size > 0.0 && size < 1e100)) continue;
    const tess::Tessellation t = tess::tessellate(store, static_cast<std::int32_t>(p),
                                                  tess::UniformTolerance(0.05 * size), {.threads = 1});
    tess::check_mesh_fits(store, t.mesh);
    (void)tess::check(t.mesh);
    if (t.mesh.deviation.size() != t.mesh.triangles.size())
      throw std::logic_error("the mesh's arrays differ in length");
    for (const double d : t.mesh.deviation)
      if (!(d >= 0.0)) throw std::logic_error("a deviation that is no number");
  }
}

}  // namespace trimray::fuzz
