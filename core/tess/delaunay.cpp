#include "core/tess/delaunay.h"

#include <algorithm>
#include <cmath>

#include <CDT.h>

namespace trimray::tess {
namespace {

using Cdt = CDT::Triangulation<double>;

Cdt make(const std::vector<dvec2>& points, const std::vector<std::array<int, 2>>& sides,
         CDT::IntersectingConstraintEdges::Enum crossing) {
  Cdt cdt(CDT::VertexInsertionOrder::Auto, crossing, 0.0);
  cdt.insertVertices(
      points.begin(), points.end(), [](const dvec2& p) { return p.x; }, [](const dvec2& p) { return p.y; });
  cdt.insertEdges(
      sides.begin(), sides.end(), [](const auto& s) { return static_cast<CDT::VertInd>(s[0]); },
      [](const auto& s) { return static_cast<CDT::VertInd>(s[1]); });
  return cdt;
}

void take_inside(Cdt& cdt, Delaunay& out) {
  cdt.eraseOuterTrianglesAndHoles();
  out.triangles.reserve(cdt.triangles.size());
  for (const CDT::Triangle& t : cdt.triangles)
    out.triangles.push_back(
        {static_cast<int>(t.vertices[0]), static_cast<int>(t.vertices[1]), static_cast<int>(t.vertices[2])});
  out.outcome = out.triangles.empty() ? Delaunay::Outcome::kFailed : Delaunay::Outcome::kDone;
}

double turn(dvec2 a, dvec2 b, dvec2 c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

// Do two sides share more than an end?
bool cross(const std::vector<dvec2>& points, const std::array<int, 2>& s, const std::array<int, 2>& t) {
  if ((s[0] == t[0] && s[1] == t[1]) || (s[0] == t[1] && s[1] == t[0])) return false;
  const dvec2 a = points[s[0]], b = points[s[1]], c = points[t[0]], d = points[t[1]];
  const double abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
  const bool shared = s[0] == t[0] || s[0] == t[1] || s[1] == t[0] || s[1] == t[1];
  if (shared) {
    // Along one line, and on the same side of the shared end.
    const int at = s[0] == t[0] || s[0] == t[1] ? s[0] : s[1];
    const dvec2 o = points[at], x = points[s[0] == at ? s[1] : s[0]] - o,
                y = points[t[0] == at ? t[1] : t[0]] - o;
    return x.x * y.y - x.y * y.x == 0.0 && glm::dot(x, y) > 0.0;
  }
  return ((abc >= 0.0) != (abd > 0.0) || abc == 0.0 || abd == 0.0) &&
         ((cda >= 0.0) != (cdb > 0.0) || cda == 0.0 || cdb == 0.0) && abc * abd <= 0.0 && cda * cdb <= 0.0;
}

// All pairs, by a sweep along x.
std::vector<std::pair<int, int>> crossing_pairs(const std::vector<dvec2>& points,
                                                const std::vector<std::array<int, 2>>& sides) {
  struct Span {
    double x0, x1, y0, y1;
    int side;
  };
  std::vector<Span> spans;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const dvec2 a = points[sides[i][0]], b = points[sides[i][1]];
    spans.push_back({std::min(a.x, b.x), std::max(a.x, b.x), std::min(a.y, b.y), std::max(a.y, b.y),
                     static_cast<int>(i)});
  }
  std::sort(spans.begin(), spans.end(),
            [](const Span& a, const Span& b) { return std::tie(a.x0, a.side) < std::tie(b.x0, b.side); });
  std::vector<std::pair<int, int>> pairs;
  constexpr std::size_t kEnough = 10000;  // of a hostile file's
  for (std::size_t i = 0; i < spans.size() && pairs.size() < kEnough; ++i)
    for (std::size_t j = i + 1; j < spans.size() && spans[j].x0 <= spans[i].x1; ++j)
      if (spans[j].y0 <= spans[i].y1 && spans[i].y0 <= spans[j].y1 &&
          cross(points, sides[spans[i].side], sides[spans[j].side]))
        pairs.push_back({std::min(spans[i].side, spans[j].side), std::max(spans[i].side, spans[j].side)});
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace

Delaunay triangulate(const std::vector<dvec2>& points, const std::vector<std::array<int, 2>>& sides) {
  Delaunay out;
  try {
    Cdt cdt = make(points, sides, CDT::IntersectingConstraintEdges::NotAllowed);
    // A side that runs through a point was cut there, without a word.
    bool cut = false;
    for (const auto& s : sides)
      cut = cut || !cdt.fixedEdges.count(
                       CDT::Edge(static_cast<CDT::VertInd>(s[0] + 3), static_cast<CDT::VertInd>(s[1] + 3)));
    if (!cut) {
      take_inside(cdt, out);
      return out;
    }
  } catch (const CDT::Error&) {
  }
  out.crossings = crossing_pairs(points, sides);
  if (!out.crossings.empty()) out.outcome = Delaunay::Outcome::kCrossing;
  return out;
}

Delaunay triangulate_crossing(std::vector<dvec2>& points, const std::vector<std::array<int, 2>>& sides) {
  Delaunay out;
  try {
    Cdt cdt = make(points, sides, CDT::IntersectingConstraintEdges::TryResolve);
    take_inside(cdt, out);
    for (std::size_t i = points.size(); i < cdt.vertices.size(); ++i)
      points.push_back({cdt.vertices[i].x, cdt.vertices[i].y});
  } catch (const CDT::Error&) {
    out = {};
  }
  return out;
}

}  // namespace trimray::tess
