#include "core/trace/edge_rule_loops.h"

#include <span>

#include "core/base/box.h"
#include "core/nurbs/trim_bezier.h"

namespace trimray::trace {
namespace {

// The side of a loop is the same all along it, so a coarse polyline will do to ask for it.
constexpr int kSamplesPerPiece = 8;
constexpr int kVotes = 15;
constexpr double kAside = 1e-3;  // distance from the polyline, in lengths of its edge

struct Polyline {
  std::vector<dvec2> points;
  Box2 box;
};

Polyline sample(const nurbs::NurbsStore& store, const nurbs::Loop& loop) {
  Polyline line;
  for (std::int32_t c = loop.coedges.begin; c < loop.coedges.end; ++c) {
    for (std::int32_t p = store.coedges[c].pieces.begin; p < store.coedges[c].pieces.end; ++p) {
      const nurbs::Range r = store.trim_pieces[p].ctrl;
      const std::span<const dvec3> ctrl_h(store.trim_ctrl_h.data() + r.begin,
                                          static_cast<std::size_t>(r.size()));
      const int samples = ctrl_h.size() == 2 ? 1 : kSamplesPerPiece;
      for (int i = 0; i <= samples; ++i) {
        const dvec3 h = nurbs::evaluate_bezier<dvec3>(ctrl_h, static_cast<double>(i) / samples);
        const dvec2 point(h.x / h.z, h.y / h.z);
        if (!line.points.empty() && line.points.back() == point) continue;
        line.points.push_back(point);
        line.box.add(point);
      }
    }
  }
  return line;
}

double signed_area(const Polyline& line) {
  double sum = 0.0;
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const dvec2 a = line.points[i] - line.points[0],
                b = line.points[(i + 1) % line.points.size()] - line.points[0];
    sum += a.x * b.y - a.y * b.x;
  }
  return 0.5 * sum;
}

bool inside(const std::vector<Polyline>& loops, dvec2 p) {
  bool in = false;
  for (const Polyline& line : loops) {
    if (line.points.empty() || p.y < line.box.lower.y || p.y > line.box.upper.y || p.x > line.box.upper.x)
      continue;
    for (std::size_t i = 0, j = line.points.size() - 1; i < line.points.size(); j = i++) {
      const dvec2 a = line.points[i], b = line.points[j];
      if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y))) in = !in;
    }
  }
  return in;
}

}  // namespace

std::vector<int> loop_signs(const nurbs::NurbsStore& store, std::int32_t face_index) {
  const nurbs::Face& face = store.faces[face_index];
  std::vector<Polyline> loops;
  for (std::int32_t l = face.loops.begin; l < face.loops.end; ++l)
    loops.push_back(sample(store, store.loops[l]));
  std::vector<int> signs;
  for (const Polyline& line : loops) signs.push_back(signed_area(line) < 0.0 ? -1 : 1);
  if (loops.size() < 2) return signs;

  // Several loops: ask on both sides of some edges of each. Where loops touch, a vote may be lost.
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const std::vector<dvec2>& points = loops[l].points;
    const std::size_t step = points.size() / kVotes + 1;
    int votes = 0;
    for (std::size_t i = 0; i < points.size(); i += step) {
      const dvec2 a = points[i], d = points[(i + 1) % points.size()] - a;
      const dvec2 aside = kAside * dvec2(-d.y, d.x), middle = a + 0.5 * d;
      votes +=
          static_cast<int>(inside(loops, middle + aside)) - static_cast<int>(inside(loops, middle - aside));
    }
    if (votes != 0) signs[l] = votes > 0 ? 1 : -1;
  }
  return signs;
}

}  // namespace trimray::trace
