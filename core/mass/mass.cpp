#include "core/mass/mass.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace trimray::mass {
namespace {

using nurbs::NurbsStore;

// Where moments are taken from, and how far the body reaches from there.
struct Base {
  dvec3 origin{0.0};
  double reach = 1.0;
};

Base base_of(const nurbs::Prototype& part) {
  if (part.bounds.empty() || !std::isfinite(part.bounds.diagonal())) return {};
  return {part.bounds.center(), 0.5 * part.bounds.diagonal()};
}

FaceIntegrals integrate_triangles(const NurbsStore& store, const nurbs::Face& face, const Base& base,
                                  const dmat3* cofactor) {
  IntegralSums sums;
  for (std::int32_t t = face.triangles.begin; t < face.triangles.end; ++t) {
    dvec3 c[3];
    for (int k = 0; k < 3; ++k) c[k] = store.mesh_vertices[store.mesh_triangles[t][k]] - base.origin;
    dvec3 normal = glm::cross(c[1] - c[0], c[2] - c[0]);
    if (cofactor != nullptr) normal = *cofactor * normal;
    // Of the tetrahedron between the triangle and the origin.
    const double volume = glm::dot(c[0], normal) / 6.0;
    const dvec3 total = c[0] + c[1] + c[2], first = 0.25 * volume * total;
    Integrals x{0.5 * glm::length(normal), volume, first.x, first.y, first.z};
    for (int i = 0, k = kSecond; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++k)
        x[k] =
            volume / 20.0 * (total[i] * total[j] + c[0][i] * c[0][j] + c[1][i] * c[1][j] + c[2][i] * c[2][j]);
    sums.add(x);
  }
  FaceIntegrals r{sums.value(), largest_integrals(base.reach)};
  for (double& e : r.error) e *= 4e-15 * r.value[kArea] * (1.0 + glm::length(base.origin) / base.reach);
  return r;
}

FaceIntegrals integrate(const NurbsStore& store, std::int32_t f, const dmat3* cofactor = nullptr) {
  const nurbs::Face& face = store.faces[f];
  const Base base = base_of(store.prototypes[face.prototype]);
  return face.is_mesh() ? integrate_triangles(store, face, base, cofactor)
                        : integrate_face(store, f, base.origin, base.reach, cofactor);
}

const FaceIntegrals kNoIntegrals = [] {
  FaceIntegrals none;
  none.value.fill(kNaN), none.error.fill(kNaN);
  return none;
}();

bool is_measured(const nurbs::Face& face) { return face.status == nurbs::FaceStatus::kOk; }

// A face whose area the placement of an instance changes by no single factor.
struct Stretched {
  std::int32_t face, instance;
};

dmat3 cofactor_of(const dmat3& m) {
  return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

// The factor of lengths, 0 where there is none for all directions.
double scale_of(const dmat3& m) {
  const dmat3 square = glm::transpose(m) * m;
  const double scale = (square[0][0] + square[1][1] + square[2][2]) / 3.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(square[i][j] - (i == j ? scale : 0.0)) <= 1e-13 * scale)) return 0.0;
  return std::sqrt(scale);
}

}  // namespace

MassProperties measure_mass(const NurbsStore& store, int threads) {
  const std::size_t count = store.faces.size();
  MassProperties r;
  r.faces.resize(count, kNoIntegrals);
  parallel_ranges(count, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f)
      if (is_measured(store.faces[f])) r.faces[f] = integrate(store, static_cast<std::int32_t>(f));
  });
  for (std::size_t f = 0; f < count; ++f)
    if (!is_measured(store.faces[f])) r.left_out.push_back(static_cast<std::int32_t>(f));

  // Shells, then prototypes.
  r.shell_volume.resize(store.shells.size(), kNaN), r.shell_volume_error.resize(store.shells.size(), kNaN);
  std::vector<Moments> bodies(store.prototypes.size());
  for (std::size_t p = 0; p < bodies.size(); ++p) {
    const nurbs::Prototype& part = store.prototypes[p];
    IntegralSums value, error;
    for (std::int32_t s = part.shells.begin; s < part.shells.end; ++s) {
      const nurbs::Range range = store.shells[s].faces;
      const auto first = store.faces.begin() + range.begin, last = store.faces.begin() + range.end;
      if (!store.shells[s].closed || !std::all_of(first, last, is_measured)) continue;
      Sum volume, volume_error;
      for (std::int32_t f = range.begin; f < range.end; ++f) {
        value.add(r.faces[f].value), error.add(r.faces[f].error);
        volume.add(r.faces[f].value[kVolume]), volume_error.add(r.faces[f].error[kVolume]);
      }
      r.shell_volume[s] = volume.value(), r.shell_volume_error[s] = volume_error.value();
    }
    r.origins.push_back(base_of(part).origin);
    bodies[p] = moments_of(value.value(), error.value(), r.origins.back());
  }

  // Instances: areas by one factor where there is one.
  std::vector<Stretched> stretched;
  Sum area, area_error;
  for (std::size_t i = 0; i < store.instances.size(); ++i) {
    const nurbs::Instance& instance = store.instances[i];
    const double scale = scale_of(instance.placement.linear), factor = scale * scale;
    const nurbs::Range range = store.prototypes[instance.prototype].faces;
    for (std::int32_t f = range.begin; f < range.end; ++f) {
      if (!is_measured(store.faces[f])) continue;
      if (scale > 0.0)
        area.add(factor * r.faces[f].value[kArea]), area_error.add(factor * r.faces[f].error[kArea]);
      else
        stretched.push_back({f, static_cast<std::int32_t>(i)});
    }
    const Moments body = placed(bodies[instance.prototype], instance.placement);
    r.moments = i == 0 ? body : r.moments + body;
  }
  std::vector<FaceIntegrals> again(stretched.size());
  parallel_ranges(stretched.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const dmat3 cofactor = cofactor_of(store.instances[stretched[k].instance].placement.linear);
      again[k] = integrate(store, stretched[k].face, &cofactor);
    }
  });
  for (const FaceIntegrals& x : again) area.add(x.value[kArea]), area_error.add(x.error[kArea]);
  r.area = area.value(), r.area_error = area_error.value();
  return r;
}

}  // namespace trimray::mass
