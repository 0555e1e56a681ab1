#include "core/reference/paths.h"

#include <algorithm>
#include <cmath>

#include "core/reference/winding.h"

namespace trimray::reference {
namespace {

using Curve4 = std::vector<dvec4>;

constexpr double kSteepest = 1e-4;  // sine between path and line below which the path has no sides

// c becomes the upper half; the lower one is returned.
Curve4 halve(Curve4& c) {
  Curve4 low(c.size());
  for (std::size_t r = 0; r < c.size(); ++r) {
    low[r] = c[0];
    for (std::size_t i = 0; i + r + 1 < c.size(); ++i) c[i] = 0.5 * (c[i] + c[i + 1]);
  }
  return low;
}

dvec3 point_at(Curve4 c, double x) {
  for (std::size_t r = 1; r < c.size(); ++r)
    for (std::size_t i = 0; i + r < c.size(); ++i) c[i] = (1.0 - x) * c[i] + x * c[i + 1];
  return dvec3(c[0]) / c[0].w;
}

Box3 hull_box(const Curve4& c) {
  Box3 box;
  for (const dvec4& h : c) box.add(dvec3(h) / h.w);
  return box;
}

// The closest point to the line of a short or nearly straight stretch: samples, then golden section.
void closest(const Curve4& c, NearStretch& out) {
  auto across = [&](double x) { return glm::length(dvec2(point_at(c, x))); };
  constexpr int kSamples = 16;
  int best = 0;
  for (int k = 1; k <= kSamples; ++k)
    if (across(double(k) / kSamples) < across(double(best) / kSamples)) best = k;
  double a = std::max(0.0, (best - 1.0) / kSamples), b = std::min(1.0, (best + 1.0) / kSamples);
  for (int k = 0; k < 60; ++k) {
    const double x = a + 0.381966011250105 * (b - a), y = b - 0.381966011250105 * (b - a);
    (across(x) <= across(y) ? b : a) = across(x) <= across(y) ? y : x;
  }
  const double x = 0.5 * (a + b);
  out.t = point_at(c, x).z, out.distance = across(x);
  // The path's direction across the line, unless the line runs nearly along the path.
  const dvec3 along = point_at(c, std::min(1.0, x + 1e-3)) - point_at(c, std::max(0.0, x - 1e-3));
  const dvec2 chord(along), here(point_at(c, x));
  if (!(glm::length(chord) > kSteepest * glm::length(along))) return;
  const double left = here.x * chord.y - here.y * chord.x;  // of the line's point, the origin
  out.side = left > 0.0 ? 1 : left < 0.0 ? -1 : 0;
}

void search(Curve4 c, bool link, double band, std::int32_t edge, std::vector<NearStretch>& out) {
  const Box3 box = hull_box(c);
  const dvec2 lower(box.lower), upper(box.upper);
  const dvec2 gap = glm::max(dvec2(0.0), glm::max(lower, -upper));
  if (glm::length(gap) > band) return;
  const bool within = glm::length(glm::max(glm::abs(lower), glm::abs(upper))) <= band;
  if (!within && glm::length(upper - lower) > 0.01 * band) {
    Curve4 low = halve(c);
    search(std::move(low), link, band, edge, out);
    return search(std::move(c), link, band, edge, out);
  }
  NearStretch here{edge, box.lower.z, box.upper.z, 0.0, kInf};
  closest(c, here);
  if (here.distance > band) return;
  if (link) here.side = 0;

  // Stretches come in the order of the path: join what touches, or lies within two bands along the line.
  if (!out.empty() && out.back().edge == edge && here.t_lower <= out.back().t_upper + 2.0 * band &&
      here.t_upper >= out.back().t_lower - 2.0 * band) {
    NearStretch& last = out.back();
    last.t_lower = std::min(last.t_lower, here.t_lower), last.t_upper = std::max(last.t_upper, here.t_upper);
    if (here.distance < last.distance) last.t = here.t, last.distance = here.distance, last.side = here.side;
    return;
  }
  out.push_back(here);
}

}  // namespace

EdgePath edge_path(const nurbs::NurbsStore& store, std::int32_t edge) {
  const nurbs::Edge& e = store.edges[edge];
  EdgePath path;
  path.band = e.band;
  auto add = [&](Curve4 curve, bool link) {
    path.curves.push_back(std::move(curve));
    path.links.push_back(link);
  };
  for (std::int32_t k = e.pieces.begin; k < e.pieces.end; ++k) {
    const nurbs::Range ctrl = store.edge_pieces[k].ctrl;
    Curve4 curve(store.edge_ctrl_h.begin() + ctrl.begin, store.edge_ctrl_h.begin() + ctrl.end);
    if (!path.curves.empty()) add({path.curves.back().back(), curve.front()}, true);
    add(std::move(curve), false);
  }
  auto vertex = [&](int k) { return dvec4(store.vertices[e.vertex[k]].point, 1.0); };
  const bool bare = path.curves.empty();
  const dvec4 last = bare ? dvec4(0.0) : path.curves.back().back();
  if (bare && e.vertex[0] >= 0) add({vertex(0), vertex(e.vertex[1] >= 0 ? 1 : 0)}, true);
  if (!bare && e.vertex[0] >= 0) add({vertex(0), path.curves.front().front()}, true);
  if (!bare && e.vertex[1] >= 0) add({last, vertex(1)}, true);
  for (const Curve4& c : path.curves) path.box.add(hull_box(c));
  return path;
}

void near_stretches(const EdgePath& path, std::int32_t edge, const Line& line,
                    std::vector<NearStretch>& out) {
  if (path.curves.empty() || !line.meets(path.box, path.band)) return;
  for (std::size_t k = 0; k < path.curves.size(); ++k) {
    Curve4 c;
    for (const dvec4& h : path.curves[k]) c.push_back(line.project(Vec4(h)));
    search(std::move(c), path.links[k], path.band, edge, out);
  }
}

int path_crossings(const EdgePath& path, const Line& line) {
  int sum = 0;
  std::vector<dvec2> c;
  for (const Curve4& curve : path.curves) {
    c.clear();
    for (const dvec4& h : curve) c.push_back(dvec2(line.project(Vec4(h))));
    sum += half_line_crossings(c);
  }
  return sum;
}

}  // namespace trimray::reference
