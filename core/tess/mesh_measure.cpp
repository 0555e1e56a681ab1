#include "core/tess/mesh_measure.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/closest.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/nurbs/surface_form.h"

namespace trimray::tess {
namespace {

using nurbs::NurbsStore;

constexpr int kMaxSteps = 30;
constexpr int kStarts = 24;

// Distance of p from the surface, downhill from `uv`: Gauss-Newton steps, damped until they help. What it
// gives is the distance of some point of the surface, so never less than the true distance.
double descend(const nurbs::SurfaceView& surface, const dvec3& p, dvec2 uv) {
  nurbs::SurfacePoint s = nurbs::evaluate(surface, uv);
  double best = glm::distance(s.p, p);
  double damping = 0.0;
  for (int step = 0; step < kMaxSteps; ++step) {
    const dvec3 d = p - s.p;
    const double uu = glm::dot(s.du, s.du), uv_ = glm::dot(s.du, s.dv), vv = glm::dot(s.dv, s.dv);
    const double a = uu * (1.0 + damping), b = vv * (1.0 + damping), det = a * b - uv_ * uv_;
    const dvec2 g(glm::dot(s.du, d), glm::dot(s.dv, d));
    dvec2 move(0.0);
    if (det > 1e-14 * a * b)
      move = dvec2(b * g.x - uv_ * g.y, a * g.y - uv_ * g.x) / det;
    else  // a pole: only one direction moves the point
      move = uu > vv ? dvec2(uu > 0.0 ? g.x / uu : 0.0, 0.0) : dvec2(0.0, vv > 0.0 ? g.y / vv : 0.0);
    const nurbs::SurfacePoint next = nurbs::evaluate(surface, uv + move);
    const double distance = glm::distance(next.p, p);
    if (!(distance < best)) {
      if (damping > 1e6) break;
      damping = damping == 0.0 ? 1e-2 : 10.0 * damping;
      continue;
    }
    // A damped step says nothing about how far there is to go.
    const bool settled = damping < 1e-3 && best - distance <= 1e-9 * best;
    uv += move, s = next, best = distance, damping *= 0.1;
    if (settled) break;
  }
  return best;
}

// All triangles of each face, with boxes, to find the nearest one.
class FaceTriangles {
 public:
  FaceTriangles(const NurbsStore& store, const TriMesh& mesh)
      : mesh_(mesh), first_(store.faces.size() + 1, 0) {
    for (const std::int32_t f : mesh.face) ++first_[f + 1];
    for (std::size_t f = 0; f + 1 < first_.size(); ++f) first_[f + 1] += first_[f];
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    list_.resize(mesh.face.size());
    for (std::size_t i = 0; i < mesh.face.size(); ++i) list_[next[mesh.face[i]]++] = i;
  }

  // Distance of p from the face's triangles, `best` where none is nearer than that.
  double nearest(std::int32_t face, const dvec3& p, double best) const {
    for (std::size_t k = first_[face]; k < first_[face + 1]; ++k) {
      const auto& t = mesh_.triangles[list_[k]];
      const std::array<dvec3, 3> c{mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]};
      const dvec3 lower = glm::min(glm::min(c[0], c[1]), c[2]), upper = glm::max(glm::max(c[0], c[1]), c[2]);
      if (glm::distance(p, glm::clamp(p, lower, upper)) < best)
        best = std::min(best, distance_to_triangle(p, c[0], c[1], c[2]));
    }
    return best;
  }

 private:
  const TriMesh& mesh_;
  std::vector<std::size_t> first_, list_;
};

struct Worst {
  double to_surface = 0.0, from_surface = 0.0;
};

Worst measure_triangle(const nurbs::SurfaceView& surface, const TriMesh& mesh, const FaceTriangles& all,
                       std::size_t index, int n) {
  const auto& t = mesh.triangles[index];
  const std::array<dvec3, 3> p{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  const auto& uv = mesh.corner_uv[index];
  // Nothing is asked of others because of rounding alone.
  double enough = mesh.deviation.empty() ? 0.0 : mesh.deviation[index];
  for (const dvec3& c : p) enough = std::max(enough, 1e-13 * glm::length(c));
  Worst worst;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      const double a = double(i) / n, b = double(j) / n, c = double(n - i - j) / n;
      const dvec3 point = a * p[0] + b * p[1] + c * p[2];
      const dvec2 at = a * uv[0] + b * uv[1] + c * uv[2];
      const dvec3 exact = nurbs::evaluate_point(surface, at);
      double from = distance_to_triangle(exact, p[0], p[1], p[2]);
      if (from > enough && from > worst.from_surface) from = all.nearest(mesh.face[index], exact, from);
      worst.from_surface = std::max(worst.from_surface, from);
      // A point's distance from the surface is at most that from `exact`: ask only when that could matter.
      if (!(glm::distance(exact, point) > worst.to_surface)) continue;
      double distance = descend(surface, point, at);
      for (int k = 0; k < 3 && distance > worst.to_surface; ++k)
        distance = std::min(distance, descend(surface, point, 0.5 * (at + uv[k])));
      if (distance > worst.to_surface && distance > enough) {
        // Where uv runs very unevenly (beside a pole) the way down leads astray: start from the nearest of
        // many.
        for (int k = 0; k <= kStarts && distance > worst.to_surface; ++k) {
          dvec2 start = at;
          double least = kInf;
          for (int l = 0; k + l <= kStarts; ++l) {
            const double x = double(k) / kStarts, y = double(l) / kStarts;
            const dvec2 q = x * uv[0] + y * uv[1] + (1.0 - x - y) * uv[2];
            const double d = glm::distance(nurbs::evaluate_point(surface, q), point);
            if (d < least) least = d, start = q;
          }
          distance = std::min(distance, descend(surface, point, start));
        }
      }
      worst.to_surface = std::max(worst.to_surface, distance);
    }
  }
  return worst;
}

// A number for a triangle that depends on nothing else (splitmix64).
std::uint64_t shuffled(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

}  // namespace

void check_mesh_fits(const NurbsStore& store, const TriMesh& mesh) {
  const std::size_t n = mesh.triangles.size();
  if (mesh.corner_uv.size() != n || mesh.face.size() != n)
    throw ArgumentError("the mesh's arrays differ in length");
  const auto within = [](std::int32_t i, std::size_t count) {
    return i >= 0 && static_cast<std::size_t>(i) < count;
  };
  for (std::size_t i = 0; i < n; ++i) {
    for (const std::int32_t v : mesh.triangles[i])
      if (!within(v, mesh.vertices.size()))
        throw ArgumentError("triangle " + std::to_string(i) + " names vertex " + std::to_string(v) + " of " +
                            std::to_string(mesh.vertices.size()));
    if (!within(mesh.face[i], store.faces.size()))
      throw ArgumentError("triangle " + std::to_string(i) + " names face " + std::to_string(mesh.face[i]) +
                          " of " + std::to_string(store.faces.size()));
  }
}

DeviationMeasure measure_deviation(const NurbsStore& store, const TriMesh& mesh,
                                   const MeasureOptions& options) {
  check_mesh_fits(store, mesh);
  if (!mesh.deviation.empty() && mesh.deviation.size() != mesh.triangles.size())
    throw ArgumentError("the mesh's arrays differ in length");
  if (options.subdivisions < 1 || options.subdivisions > 1000)
    throw ArgumentError("subdivisions must be in 1..1000");
  const std::size_t count = mesh.triangles.size();
  const double share = options.most_triangles > 0 && count > 0
                           ? static_cast<double>(options.most_triangles) / static_cast<double>(count)
                           : 1.0;
  DeviationMeasure result{std::vector<double>(count, kNaN), std::vector<double>(count, kNaN)};
  const FaceTriangles all(store, mesh);
  parallel_ranges(count, 64, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const nurbs::Face& face = store.faces[mesh.face[i]];
      if (face.surface < 0 || face.triangles.size() > 0 || face.status != nurbs::FaceStatus::kOk) continue;
      if (share < 1.0 && static_cast<double>(shuffled(i ^ (options.seed << 40)) >> 11) * 0x1p-53 >= share)
        continue;
      const Worst worst = measure_triangle(nurbs::view(store, store.surfaces[face.surface]), mesh, all, i,
                                           options.subdivisions);
      result.to_surface[i] = worst.to_surface, result.from_surface[i] = worst.from_surface;
    }
  });
  return result;
}

std::vector<FaceCover> measure_cover(const NurbsStore& store, const TriMesh& mesh) {
  check_mesh_fits(store, mesh);
  std::vector<FaceCover> faces(store.faces.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& uv = mesh.corner_uv[i];
    const dvec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    const double area = 0.5 * (a.x * b.y - a.y * b.x);
    FaceCover& f = faces[mesh.face[i]];
    ++f.triangles;
    f.uv_area += area;
    f.turned_over += !(store.faces[mesh.face[i]].reversed ? area < 0.0 : area > 0.0);
  }
  return faces;
}

}  // namespace trimray::tess
