#include "core/tess/corner_normals.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/nurbs/surface_form.h"
#include "core/tess/corner_sets.h"
#include "core/tess/mesh_measure.h"
#include "core/tess/mesh_sides.h"

namespace trimray::tess {
namespace {

using nurbs::NurbsStore;

// Below this ratio of the two tangents' lengths over the triangle, or sine between them, a corner is
// singular: a pole or an apex.
constexpr double kSingular = 1e-6;
// How far into the triangle a pole's normal is taken, as a fraction of the way to its middle.
constexpr double kNudge = 1e-3;

dvec3 unit(const dvec3& n) {
  const double length = glm::length(n);
  return length > 0.0 && length < kInf ? n / length : dvec3(0.0);
}

// (0, 0, 0) where the surface has no normal.
dvec3 surface_normal(const nurbs::SurfaceView& surface, const std::array<dvec2, 3>& uv, int corner) {
  const dvec2 middle = (uv[0] + uv[1] + uv[2]) / 3.0;
  const dvec2 width = glm::max(glm::max(uv[0], uv[1]), uv[2]) - glm::min(glm::min(uv[0], uv[1]), uv[2]);
  for (const double nudge : {0.0, kNudge, 0.1}) {
    const nurbs::SurfacePoint s = nurbs::evaluate(surface, uv[corner] + nudge * (middle - uv[corner]));
    const double along_u = glm::length(s.du), along_v = glm::length(s.dv);
    const dvec3 n = glm::cross(s.du, s.dv);
    const bool pole = nudge == 0.0 && (!(along_u * width.x > kSingular * along_v * width.y) ||
                                       !(along_v * width.y > kSingular * along_u * width.x));
    if (!pole && glm::length(n) > kSingular * along_u * along_v) return unit(n);
  }
  return dvec3(0.0);
}

// Exact normals and the angles at the corners of one triangle.
void corners_of(const NurbsStore& store, const TriMesh& mesh, std::size_t i, dvec3* normals, double* angles) {
  const auto& t = mesh.triangles[i];
  const dvec3 p[3] = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  const nurbs::Face& face = store.faces[mesh.face[i]];
  const dvec3 flat = unit(glm::cross(p[1] - p[0], p[2] - p[0]));
  const bool exact = face.surface >= 0 && face.triangles.size() == 0 && face.status == nurbs::FaceStatus::kOk;
  for (int k = 0; k < 3; ++k) {
    dvec3 n(0.0);
    if (exact) {
      n = surface_normal(nurbs::view(store, store.surfaces[face.surface]), mesh.corner_uv[i], k);
      if (face.reversed) n = -n;
    }
    normals[k] = n != dvec3(0.0) ? n : flat != dvec3(0.0) ? flat : dvec3(0.0, 0.0, 1.0);
    const dvec3 a = unit(p[(k + 1) % 3] - p[k]), b = unit(p[(k + 2) % 3] - p[k]);
    angles[k] = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
  }
}

}  // namespace

std::vector<dvec3> corner_normals(const NurbsStore& store, const TriMesh& mesh, int threads) {
  check_mesh_fits(store, mesh);
  const std::size_t count = 3 * mesh.triangles.size();
  const std::vector<Side> sides = sorted_sides(mesh.vertices.size(), mesh.triangles);
  std::vector<dvec3> own(count);
  std::vector<double> angles(count);
  parallel_ranges(mesh.triangles.size(), 256, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) corners_of(store, mesh, i, &own[3 * i], &angles[3 * i]);
  });

  // Corners that agree across an edge belong together.
  const double agree = std::cos(kCreaseAngle);
  CornerSets sets(count);
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (edge_use({sides.data() + begin, end - begin}) != EdgeUse::kPaired) return;
    const Side &a = sides[begin], &b = sides[begin + 1];  // they run against each other
    const std::size_t a0 = 3 * std::size_t(a.triangle) + a.corner;
    const std::size_t a1 = 3 * std::size_t(a.triangle) + (a.corner + 1) % 3;
    const std::size_t b0 = 3 * std::size_t(b.triangle) + b.corner;
    const std::size_t b1 = 3 * std::size_t(b.triangle) + (b.corner + 1) % 3;
    if (glm::dot(own[a0], own[b1]) >= agree) sets.unite(a0, b1);
    if (glm::dot(own[a1], own[b0]) >= agree) sets.unite(a1, b0);
  });
  std::vector<dvec3> sums(count, dvec3(0.0));
  for (std::size_t c = 0; c < count; ++c) sums[sets.root(c)] += angles[c] * own[c];
  std::vector<dvec3> result(count);
  for (std::size_t c = 0; c < count; ++c) {
    const dvec3 mean = unit(sums[sets.root(c)]);
    // Around the apex of a cone neighbours agree and the whole does not: there each corner keeps its own.
    result[c] = glm::dot(mean, own[c]) >= std::cos(2.0 * kCreaseAngle) ? mean : own[c];
  }
  return result;
}

}  // namespace trimray::tess
