// Every tolerance of the project, declared once, with unit and origin.
#pragma once

namespace trimray {

// Newton stops when the step in the face's uv, times the tangent, is below this fraction of the
// model's diagonal: two orders below the 1e-9 that we promise for t.
inline constexpr double kNewtonTol = 1e-12;

// Promised accuracy of a hit distance, as a fraction of the model's diagonal.
inline constexpr double kHitTol = 1e-9;

// Lower bound of an edge's band, as a fraction of the prototype's diagonal: what rounding alone can
// put between a ray's hit and the edge it was aimed at.
inline constexpr double kMinBand = 1e-9;

}  // namespace trimray
