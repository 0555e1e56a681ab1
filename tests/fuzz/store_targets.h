// The functions of targets.h that need the NURBS store.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/brep/bintools.h"
#include "core/nurbs/build_store.h"
#include "core/nurbs/store.h"
#include "core/nurbs/store_file.h"

namespace trimray::fuzz {

// A shape used many times over is legal and slow; fuzzing it finds only time-outs.
inline constexpr std::size_t kMaxFuzzUses = 20000;

// Uses that a walk down from the last shape meets.
inline std::size_t uses_of_root(const brep::Model& model) {
  std::vector<std::size_t> uses(model.shapes.size());
  for (std::size_t i = 0; i < model.shapes.size(); ++i) {
    for (const brep::ShapeUse& use : model.shapes[i].children) uses[i] += 1 + uses[use.shape];
  }
  return uses.empty() ? 0 : uses.back();
}

// The arrays that an importer would hand over: the last shape is the only prototype, placed once, and
// every second face carries a colour.
inline nurbs::BuildInput plain_input(const brep::Model& model) {
  nurbs::BuildInput input;
  input.prototype_shapes = {static_cast<std::int32_t>(model.shapes.size())};
  input.prototype_colors = {0.5f, 0.5f, 0.5f, 1.0f};
  for (std::size_t i = 0; i < model.shapes.size(); i += 2) {
    if (model.shapes[i].kind != brep::ShapeKind::kFace) continue;
    input.face_color_shapes.push_back(static_cast<std::int32_t>(i) + 1);
    input.face_colors.insert(input.face_colors.end(), {1.0f, 0.0f, 0.0f, 1.0f});
  }
  input.instance_prototypes = {0};
  input.instance_placements = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  input.instance_colors = {-1.0f, 0.0f, 0.0f, 1.0f};
  input.meta = "{}";
  return input;
}

// Bytes -> Model -> NurbsStore -> file -> NurbsStore. A stream that parses may still be refused by
// build_store with an Error; a store that it returns is valid and survives saving bit for bit.
inline void build_from_stream(std::span<const std::byte> bytes) {
  brep::Model model;
  try {
    model = brep::parse_bintools(bytes);
  } catch (const FormatError&) {
    return;
  }
  if (model.shapes.empty() || uses_of_root(model) > kMaxFuzzUses) return;
  nurbs::NurbsStore store;
  try {
    store = nurbs::build_store(bytes, plain_input(model));
  } catch (const Error&) {
    return;
  }
  nurbs::validate(store);
  const std::vector<std::byte> saved = nurbs::save_store(store);
  if (nurbs::save_store(nurbs::load_store(saved)) != saved)
    throw std::logic_error("a store changed when saved");
}

// Bytes -> NurbsStore. FormatError is the only way to refuse; what is accepted is valid. The checksum is put
// right first, since it would hide everything behind it.
inline void load_saved(std::span<const std::byte> bytes) {
  std::vector<std::byte> file(bytes.begin(), bytes.end());
  nurbs::reseal_store(file);
  nurbs::NurbsStore store;
  try {
    store = nurbs::load_store(file);
  } catch (const FormatError&) {
    return;
  }
  nurbs::validate(store);
  if (nurbs::save_store(store) != file) throw std::logic_error("a store file changed when loaded");
}

}  // namespace trimray::fuzz
