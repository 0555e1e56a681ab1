#include "core/tess/face_polygon.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trimray::tess {

using nurbs::CoEdge;
using nurbs::Edge;
using nurbs::Face;
using nurbs::NurbsStore;

namespace {

class PolygonBuilder {
 public:
  PolygonBuilder(const NurbsStore& store, const Chart& chart, const Wireframe& wireframe)
      : store_(store), chart_(chart), wireframe_(wireframe) {}

  void add_loop(const nurbs::Loop& loop, FacePolygon& out) {
    // Copies of other loops, one period on, stand on a degenerate edge alone; here loops are whole as they
    // are.
    bool all_degenerate = true;
    for (std::int32_t c = loop.coedges.begin; c < loop.coedges.end; ++c)
      all_degenerate = all_degenerate && store_.edges[store_.coedges[c].edge].degenerate;
    if (all_degenerate) return;
    std::vector<BoundaryPoint> points;
    std::vector<Stretch> stretches;
    for (std::int32_t c = loop.coedges.begin; c < loop.coedges.end; ++c) {
      const CoEdge& coedge = store_.coedges[c];
      if (wireframe_.polyline(coedge.edge).at.empty()) continue;  // no length to speak of
      stretches.push_back({points.size(), 0, store_.edges[coedge.edge].degenerate});
      add_coedge(coedge, points);
      stretches.back().last = points.size() - 1;
    }
    if (points.empty()) return;
    fit_poles(points, stretches);
    join(points, stretches);
    for (const BoundaryPoint& b : points) out.box.add(b.p);
    if (points.size() >= 2) out.loops.push_back(std::move(points));
  }

 private:
  // The points of one use.
  struct Stretch {
    std::size_t first, last;
    bool degenerate;
  };

  // All samples of one use, in loop order, the last included.
  void add_coedge(const CoEdge& coedge, std::vector<BoundaryPoint>& points) const {
    const EdgePolyline& line = wireframe_.polyline(coedge.edge);
    const Edge& edge = store_.edges[coedge.edge];
    const int n = line.segments();
    for (int k = 0; k <= n; ++k) {
      const int sample = coedge.reversed ? n - k : k;
      BoundaryPoint b;
      b.place = line.points[sample];
      b.p = sample_in_chart(store_, chart_, coedge, line.at[sample], b.place);
      if (k == 0 || k == n) stay_near(chart_.from_face(pcurve_point(store_, coedge, line.at[sample])), b.p);
      b.edge = coedge.edge;
      b.segment = k == n ? -1 : coedge.reversed ? n - 1 - k : k;
      if (b.segment >= 0) b.side_deviation = line.deviation[b.segment];
      if (sample == 0 || sample == n || edge.degenerate)
        b.vertex = wireframe_.one[edge.vertex[sample == n ? 1 : 0] - wireframe_.vertex_begin];
      else
        b.vertex = inner_key(coedge.edge, sample);
      points.push_back(b);
    }
  }

  // Where a face is narrow beside its vertex's tolerance the vertex's foot may be anywhere; then the
  // p-curve's end stands, where the next one begins.
  void stay_near(dvec2 end, dvec2& foot) const {
    constexpr double kFar = 1e-3;
    const dvec2 move = glm::abs(foot - end), extent = chart_.surface().domain.extent();
    if (!(move.x <= kFar * extent.x && move.y <= kFar * extent.y)) foot = end;
  }

  // A pole's line runs from where the use before it ends to where the next one begins: these ends are feet of
  // exact points, but the line's own are no better than its p-curve.
  static void fit_poles(std::vector<BoundaryPoint>& points, const std::vector<Stretch>& stretches) {
    const std::size_t n = stretches.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Stretch &before = stretches[(i + n - 1) % n], &s = stretches[i], &after = stretches[(i + 1) % n];
      if (!s.degenerate || before.degenerate || after.degenerate) continue;
      const dvec2 from = points[before.last].p - points[s.first].p,
                  to = points[after.first].p - points[s.last].p;
      const auto count = static_cast<double>(s.last - s.first);
      for (std::size_t k = s.first; k <= s.last; ++k) {
        const double t = count > 0.0 ? static_cast<double>(k - s.first) / count : 0.0;
        points[k].p += (1.0 - t) * from + t * to;
      }
    }
  }

  // Where one use ends and the next begins at the same vertex and place there is one point. At a pole there
  // are two, and where the model's loop is open too.
  void join(std::vector<BoundaryPoint>& points, const std::vector<Stretch>& stretches) const {
    Box2 box;
    for (const BoundaryPoint& b : points) box.add(b.p);
    const dvec2 near = 1e-6 * box.extent();
    std::vector<bool> drop(points.size(), false);
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      const std::size_t end = stretches[i].last;
      BoundaryPoint& last = points[end];
      BoundaryPoint& first = points[(end + 1) % points.size()];
      last.edge = last.segment = -1, last.side_deviation = kInf;
      if (last.vertex != first.vertex) continue;
      const auto apart = [&] {
        const dvec2 gap = glm::abs(last.p - first.p);
        return gap.x > near.x || gap.y > near.y;
      };
      // p-curves that do not meet: the vertex's foot is where both should be, but at a pole.
      if (apart() && !stretches[i].degenerate && !stretches[(i + 1) % stretches.size()].degenerate)
        last.p = chart_.project(last.place, last.p), first.p = chart_.project(first.place, first.p);
      drop[end] = !apart();
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!drop[i]) points[kept++] = points[i];
    points.resize(kept);
  }

  const NurbsStore& store_;
  const Chart& chart_;
  const Wireframe& wireframe_;
};

// A face without loops is its surface's whole domain: a rectangle whose opposite sides are one where the
// surface is periodic, and whose sides may be poles.
class NaturalBorder {
 public:
  NaturalBorder(const Chart& chart, const Box2& box, const EdgeLimits& limits, FacePolygon& out)
      : chart_(chart), box_(box), limits_(limits), out_(out) {}

  void add() {
    const nurbs::Surface& s = chart_.surface();
    const dvec2 a = box_.lower, c = box_.upper, b{c.x, a.y}, d{a.x, c.y};
    const std::vector<double> along_u = places(a, b, d, c), along_v = places(a, d, b, c);
    std::vector<BoundaryPoint> loop;
    side(a, b, along_u, loop), side(b, c, along_v, loop);
    std::vector<double> back_u = reversed(along_u), back_v = reversed(along_v);
    side(c, d, back_u, loop), side(d, a, back_v, loop);
    number(loop, s.periodic_u || closes(a, d, b, c), s.periodic_v || closes(a, b, d, c));
    for (const BoundaryPoint& p : loop) out_.box.add(p.p);
    out_.loops.push_back(std::move(loop));
  }

 private:
  static std::vector<double> reversed(const std::vector<double>& t) {
    std::vector<double> r;
    for (auto i = t.rbegin(); i != t.rend(); ++i) r.push_back(1.0 - *i);
    return r;
  }

  // Is the side a-b the same curve as the side c-d?
  bool closes(dvec2 a, dvec2 b, dvec2 c, dvec2 d) const {
    double size = 0.0, gap = 0.0;
    for (int i = 0; i <= 8; ++i) {
      const dvec3 x = chart_.point(a + i / 8.0 * (b - a)), y = chart_.point(c + i / 8.0 * (d - c));
      size = std::max(size, glm::distance(x, chart_.point(0.5 * (a + d)))),
      gap = std::max(gap, glm::distance(x, y));
    }
    return gap <= 1e-9 * size;
  }

  // Places on both of two opposite sides that serve the two of them.
  std::vector<double> places(dvec2 a, dvec2 b, dvec2 c, dvec2 d) const {
    constexpr int kAtoms = 32;
    double total = 0.0;
    for (int i = 0; i < kAtoms; ++i) {
      double most = 0.0;
      for (const auto& ends : {std::pair{a, b}, std::pair{c, d}}) {
        const dvec2 from = ends.first, to = ends.second;
        const auto at = [&](double t) { return chart_.at(from + t * (to - from)); };
        const nurbs::SurfacePoint x = at(double(i) / kAtoms), m = at((i + 0.5) / kAtoms),
                                  y = at((i + 1.0) / kAtoms);
        Box3 place;
        place.add(x.p), place.add(y.p);
        const double sag = glm::distance(m.p, 0.5 * (x.p + y.p));
        most = std::max(most, std::sqrt(sag / (0.9 * limits_.tolerance->at(place))));
        const dvec3 n = glm::cross(x.du, x.dv), k = glm::cross(y.du, y.dv);
        const double turn = std::atan2(glm::length(glm::cross(n, k)), glm::dot(n, k));
        most = std::max(most, turn / std::min(std::numbers::pi / 2, limits_.angle));
      }
      total += most;
    }
    const int count = std::max(3, static_cast<int>(std::ceil(std::min(total, 1e4))));
    std::vector<double> t;
    for (int i = 0; i <= count; ++i) t.push_back(double(i) / count);
    return t;
  }

  void side(dvec2 from, dvec2 to, const std::vector<double>& t, std::vector<BoundaryPoint>& loop) const {
    for (std::size_t i = 0; i + 1 < t.size(); ++i) {
      BoundaryPoint b;
      b.p = from + t[i] * (to - from);
      b.place = chart_.point(b.p);
      loop.push_back(b);
    }
  }

  // One vertex for all points at one place: the two ends of a period, and a pole.
  void number(std::vector<BoundaryPoint>& loop, bool closed_u, bool closed_v) const {
    Box3 size;
    for (const BoundaryPoint& b : loop) size.add(b.place);
    size.add(chart_.point(box_.center()));
    const double same = 1e-9 * size.diagonal();
    const auto is_pole = [&](int d, double value) {
      dvec2 p = box_.center();
      p[d] = value;
      dvec2 q = p;
      q[1 - d] = box_.lower[1 - d] + 0.2 * box_.extent()[1 - d];
      return glm::distance(chart_.point(p), chart_.point(q)) <= same;
    };
    bool pole[2][2];
    for (int d = 0; d < 2; ++d)
      pole[d][0] = is_pole(d, box_.lower[d]), pole[d][1] = is_pole(d, box_.upper[d]);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      for (std::size_t j = 0; j < i && loop[i].vertex == -1; ++j) {
        bool one = false;
        for (int d = 0; d < 2; ++d) {
          const bool closed = d == 0 ? closed_u : closed_v;
          const double period = box_.extent()[d];
          const dvec2 gap = glm::abs(loop[i].p - loop[j].p);
          one = one || (closed && std::abs(gap[d] - period) <= 1e-9 * period &&
                        gap[1 - d] <= 1e-9 * box_.extent()[1 - d]);
          for (int k = 0; k < 2; ++k) {
            const double border = k == 0 ? box_.lower[d] : box_.upper[d];
            one = one || (pole[d][k] && loop[i].p[d] == border && loop[j].p[d] == border);
          }
          // The four corners of a torus are one.
          one = one || (closed_u && closed_v && gap.x >= (1 - 1e-9) * box_.extent().x &&
                        gap.y >= (1 - 1e-9) * box_.extent().y);
        }
        if (one) loop[i].vertex = loop[j].vertex, loop[i].place = loop[j].place;
      }
      if (loop[i].vertex == -1) {
        out_.own_vertices.push_back(loop[i].place);
        loop[i].vertex = -1 - static_cast<VertexKey>(out_.own_vertices.size());
      }
    }
    for (BoundaryPoint& b : loop) ++b.vertex;  // -1 stood for "none yet"
  }

  const Chart& chart_;
  Box2 box_;
  const EdgeLimits& limits_;
  FacePolygon& out_;
};

}  // namespace

FacePolygon make_polygon(const NurbsStore& store, std::int32_t face, const Chart& chart,
                         const Wireframe& wireframe, const EdgeLimits& limits) {
  const Face& f = store.faces[face];
  FacePolygon out;
  if (f.loops.size() == 0) {
    Box2 box{chart.from_face(f.uv_box.lower), chart.from_face(f.uv_box.upper)};
    NaturalBorder(chart, box, limits, out).add();
    return out;
  }
  PolygonBuilder builder(store, chart, wireframe);
  for (std::int32_t l = f.loops.begin; l < f.loops.end; ++l) builder.add_loop(store.loops[l], out);
  return out;
}

}  // namespace trimray::tess
