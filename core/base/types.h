// Vectors and matrices are GLM's; these are the names the project uses for them.
#pragma once

#include <cstdint>
#include <limits>

#include <glm/glm.hpp>

namespace trimray {

using glm::dmat3;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;

inline constexpr double kInf = std::numeric_limits<double>::infinity();
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::int32_t kNoFace = -1;

// Rigid or affine placement: columns are the images of the axes, then the origin (mm).
// point -> linear * p + translation.
struct Transform {
  dmat3 linear{1.0};
  dvec3 translation{0.0};
  dvec3 point(dvec3 p) const { return linear * p + translation; }
  dvec3 vector(dvec3 v) const { return linear * v; }
};

}  // namespace trimray
