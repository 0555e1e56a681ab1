#include "core/distance/closed_foot.h"

#include <cmath>

namespace trimray::distance {

using nurbs::SurfaceKind;

int closed_feet(const trace::ClosedForm& form, const dvec3& q, ClosedFoot (&out)[2]) {
  const dvec3 d = q - form.location;
  const double x = glm::dot(d, form.x), y = glm::dot(d, form.y), z = glm::dot(d, form.z);
  if (form.kind == SurfaceKind::kPlane) {
    out[0] = {{x, y}, form.location + x * form.x + y * form.y};
    return 1;
  }
  const double rho = std::hypot(x, y);
  // The meridian that q lies in; on the axis any.
  const dvec3 radial = rho > 0.0 ? (x * form.x + y * form.y) / rho : form.x;
  const double u = rho > 0.0 ? std::atan2(y, x) : 0.0;
  constexpr double kHalfTurn = 3.14159265358979323846;
  const auto at = [&](double r, double h) { return form.location + r * radial + h * form.z; };
  switch (form.kind) {
    case SurfaceKind::kCylinder:
      out[0] = {{u, z}, at(form.r1, z)};
      return 1;
    case SurfaceKind::kSphere: {
      const double length = std::hypot(rho, z), scale = length > 0.0 ? form.r1 / length : 0.0;
      out[0] = {{u, std::atan2(z, rho)}, length > 0.0 ? at(scale * rho, scale * z) : at(form.r1, 0.0)};
      return 1;
    }
    case SurfaceKind::kCone: {
      // Both straight lines of the meridian plane; r is negative beyond the apex.
      const double v = (rho - form.r1) * form.sin_a + z * form.cos_a,
                   w = (-rho - form.r1) * form.sin_a + z * form.cos_a;
      out[0] = {{u, v}, at(form.r1 + v * form.sin_a, v * form.cos_a)};
      out[1] = {{u + kHalfTurn, w}, at(-form.r1 - w * form.sin_a, w * form.cos_a)};
      return 2;
    }
    case SurfaceKind::kTorus: {
      const auto tube = [&](double side, ClosedFoot& foot) {
        const double a = side * rho - form.r1, length = std::hypot(a, z),
                     s = length > 0.0 ? form.r2 / length : 0.0;
        const double da = length > 0.0 ? s * a : form.r2, dz = s * z;
        foot.uv = {side > 0.0 ? u : u + kHalfTurn, std::atan2(z, a)};
        foot.p = at(side * (form.r1 + da), dz);
      };
      tube(1.0, out[0]);
      if (form.r1 >= form.r2) return 1;
      tube(-1.0, out[1]);
      return 2;
    }
    default:
      return 0;
  }
}

}  // namespace trimray::distance
