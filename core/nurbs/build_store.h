// From the parsed B-rep to the NurbsStore.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/brep/topology.h"
#include "core/nurbs/store.h"

namespace trimray::nurbs {

// What stands beside the byte stream (importer/model.py, BrepModel). Shape indices are 1-based positions
// in the stream. Colours are sRGB-encoded RGBA, a negative red meaning none.
struct BuildInput {
  std::vector<std::int32_t> prototype_shapes;   // root shape of each prototype
  std::vector<float> prototype_colors;          // 4 per prototype
  std::vector<std::int32_t> face_color_shapes;  // faces (by TShape) that carry a colour ...
  std::vector<float> face_colors;               // ... 4 each
  std::vector<std::int32_t> instance_prototypes;
  std::vector<double> instance_placements;  // 12 per instance: rows of the 3x4 matrix
  std::vector<float> instance_colors;       // 4 per instance
  std::string meta;
};

// Builds the store of a whole model. A face that cannot be represented gets a FaceStatus and stays in
// the numbering; nothing is dropped. Faces are numbered prototype by prototype, in the order in which
// a depth-first walk from the prototype's root shape meets them.
// Throws FormatError when the stream is damaged, ArgumentError when the arrays do not fit it.
NurbsStore build_store(std::span<const std::byte> brep, const BuildInput& input);

// The same from a parsed stream.
NurbsStore build_store(const brep::Model& model, const BuildInput& input);

}  // namespace trimray::nurbs
