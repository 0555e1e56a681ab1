#include "core/trace/extent_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/nurbs/surface.h"
#include "core/trace/extent.h"

namespace trimray::trace {

namespace {

using nurbs::Face;
using nurbs::NurbsStore;
using nurbs::SurfaceKind;

constexpr int kCurveSteps = 8;     // per Bezier piece of an edge
constexpr int kMaxGridSteps = 40;  // per direction of a face

// Steps between a and b that respect the knots, as many as the degree asks for.
std::vector<double> grid_line(const NurbsStore& store, const nurbs::Range& knots, int degree, double a,
                              double b) {
  std::vector<double> stops{a};
  for (std::int32_t i = knots.begin; i < knots.end; ++i) {
    const double k = store.knots[i];
    if (k > stops.back() && k < b) stops.push_back(k);
  }
  stops.push_back(b);
  const int spans = static_cast<int>(stops.size()) - 1;
  const int per_span = std::max(1, std::min(std::max(degree, 2) + 1, kMaxGridSteps / spans));
  const int stride = std::max(1, spans / kMaxGridSteps);
  std::vector<double> line;
  for (int i = 0; i < spans; i += stride) {
    const double lower = stops[i], upper = stops[std::min(i + stride, spans)];
    for (int j = 0; j < per_span; ++j) line.push_back(lower + (upper - lower) * j / per_span);
  }
  line.push_back(b);
  return line;
}

}  // namespace

std::vector<Neighbour> mesh_corners(const NurbsStore& store, const nurbs::Range& faces, int threads) {
  const auto for_corners = [&](const auto& use) {
    for (std::int32_t f = faces.begin; f < faces.end; ++f) {
      const nurbs::Range& mesh = store.faces[f].triangles;
      for (std::int32_t t = mesh.begin; t < mesh.end; ++t)
        for (const std::int32_t v : store.mesh_triangles[t]) use(v);
    }
  };
  std::int32_t first = std::numeric_limits<std::int32_t>::max(), last = -1;
  for_corners([&](std::int32_t v) { first = std::min(first, v), last = std::max(last, v); });
  if (last < 0) return {};
  std::vector<char> met(static_cast<std::size_t>(last - first) + 1, 0);
  std::vector<Neighbour> items;
  for_corners([&](std::int32_t v) {
    if (!std::exchange(met[v - first], 1)) items.push_back({glm::vec3(store.mesh_vertices[v]), v});
  });
  arrange_neighbours(items, kCornersAtOnce, threads);
  return items;
}

Samples sample_corners(const NurbsStore& store, std::span<const Neighbour> corners, std::size_t k) {
  const auto rest = corners.subspan(k * kCornersAtOnce);
  Samples s;
  for (const Neighbour& v : rest.first(std::min(rest.size(), kCornersAtOnce)))
    s.points.push_back(store.mesh_vertices[v.index]);
  return s;
}

Samples sample_piece(const NurbsStore& store, std::int32_t index) {
  const nurbs::CurvePiece& piece = store.edge_pieces[index];
  Samples s;
  s.piece = index;
  const int steps = piece.ctrl.size() <= 2 ? 1 : kCurveSteps;
  for (int i = 0; i <= steps; ++i)
    s.points.push_back(edge_piece_point(store, piece, static_cast<double>(i) / steps));
  for (std::size_t i = 1; i < s.points.size(); ++i)
    s.gap = std::max(s.gap, glm::distance(s.points[i - 1], s.points[i]));
  return s;
}

bool bulges(const NurbsStore& store, const Face& face) {
  switch (store.surfaces[face.surface].kind) {
    case SurfaceKind::kPlane:
    case SurfaceKind::kCylinder:
    case SurfaceKind::kCone:
    case SurfaceKind::kExtrusion:
      return face.loops.size() == 0;
    case SurfaceKind::kMesh:
      return false;
    default:
      return true;
  }
}

bool face_contains(const nurbs::TrimIndex& trims, const NurbsStore& store, std::int32_t face,
                   const dvec2& uv) {
  const Face& f = store.faces[face];
  if (!f.uv_box.contains(uv)) return false;
  return f.iso_rectangle || f.loops.size() == 0 || trims.inside(face, uv);
}

Samples sample_face(const NurbsStore& store, const nurbs::TrimIndex& trims, std::int32_t index) {
  const Face& face = store.faces[index];
  const nurbs::Surface& surface = store.surfaces[face.surface];
  Samples s;
  s.face = index;
  if (face.uv_box.empty() || !std::isfinite(face.uv_box.diagonal())) return s;
  const auto us =
      grid_line(store, surface.knots_u, surface.degree_u, face.uv_box.lower.x, face.uv_box.upper.x);
  const auto vs =
      grid_line(store, surface.knots_v, surface.degree_v, face.uv_box.lower.y, face.uv_box.upper.y);
  for (std::size_t i = 1; i < us.size(); ++i) s.step.x = std::max(s.step.x, us[i] - us[i - 1]);
  for (std::size_t i = 1; i < vs.size(); ++i) s.step.y = std::max(s.step.y, vs[i] - vs[i - 1]);
  std::vector<dvec3> row(vs.size()), previous;
  for (std::size_t i = 0; i < us.size(); ++i) {
    for (std::size_t j = 0; j < vs.size(); ++j) {
      row[j] = nurbs::evaluate(store, surface, {us[i], vs[j]}).p;
      if (!std::isfinite(row[j].x + row[j].y + row[j].z)) {
        s.points.clear(), s.uv.clear();
        return s;
      }
      if (j > 0) s.gap = std::max(s.gap, glm::distance(row[j], row[j - 1]));
      if (i > 0) s.gap = std::max(s.gap, glm::distance(row[j], previous[j]));
      if (!face_contains(trims, store, index, {us[i], vs[j]})) continue;
      s.points.push_back(row[j]), s.uv.push_back({us[i], vs[j]});
    }
    previous = row;
  }
  return s;
}

}  // namespace trimray::trace
