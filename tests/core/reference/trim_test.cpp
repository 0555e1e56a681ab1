// Trims with holes, and the edge rule on a cube whose p-curves are wrong.
#include <gtest/gtest.h>

#include <random>

#include "core/nurbs/link_edges.h"
#include "core/nurbs/make_store.h"
#include "core/reference/reference.h"

namespace trimray::reference_test {
namespace {

using nurbs::CoEdge;
using nurbs::Edge;
using nurbs::Face;
using nurbs::NurbsStore;
using trace::Hit;
using trace::Ray;

std::int32_t count(const auto& array) { return static_cast<std::int32_t>(array.size()); }

// Puts faces, edges and p-curves into a store piece by piece.
struct Builder {
  NurbsStore store;

  std::int32_t vertex(dvec3 p) {
    store.vertices.push_back({p, 0.0});
    return count(store.vertices) - 1;
  }
  std::int32_t edge(std::int32_t v0, std::int32_t v1, const std::vector<std::vector<dvec4>>& pieces,
                    double band) {
    Edge e;
    e.vertex[0] = v0, e.vertex[1] = v1, e.band = band;
    e.pieces.begin = count(store.edge_pieces);
    for (const auto& ctrl : pieces) {
      const std::int32_t begin = count(store.edge_ctrl_h);
      store.edge_ctrl_h.insert(store.edge_ctrl_h.end(), ctrl.begin(), ctrl.end());
      store.edge_pieces.push_back({{begin, count(store.edge_ctrl_h)}, 0.0, 1.0});
    }
    e.pieces.end = count(store.edge_pieces);
    store.edges.push_back(e);
    return count(store.edges) - 1;
  }
  void begin_face(const nurbs::SurfaceForm& surface, bool reversed) {
    Face f;
    f.surface = nurbs::append_surface(store, surface);
    f.prototype = 0, f.shell = 0, f.reversed = reversed;
    f.loops = {count(store.loops), count(store.loops)};
    store.faces.push_back(f);
  }
  void begin_loop() {
    store.loops.push_back({count(store.faces) - 1, {count(store.coedges), count(store.coedges)}});
    store.faces.back().loops.end = count(store.loops);
  }
  void use(std::int32_t edge, bool reversed, const std::vector<dvec3>& pcurve) {
    CoEdge c;
    c.edge = edge, c.loop = count(store.loops) - 1, c.face = count(store.faces) - 1, c.reversed = reversed;
    const std::int32_t begin = count(store.trim_ctrl_h);
    store.trim_ctrl_h.insert(store.trim_ctrl_h.end(), pcurve.begin(), pcurve.end());
    c.pieces = {count(store.trim_pieces), count(store.trim_pieces) + 1};
    store.trim_pieces.push_back({{begin, count(store.trim_ctrl_h)}, 0.0, 1.0});
    for (const dvec3& h : pcurve) store.faces.back().uv_box.add(dvec2(h) / h.z);
    store.coedges.push_back(c);
    store.loops.back().coedges.end = count(store.coedges);
  }
  NurbsStore finish(const Box3& bounds) {
    nurbs::link_edges(store);
    store.shells.push_back({0, {0, count(store.faces)}, true});
    nurbs::Prototype p;
    p.faces = {0, count(store.faces)}, p.edges = {0, count(store.edges)},
    p.vertices = {0, count(store.vertices)};
    p.shells = {0, 1}, p.bounds = bounds;
    store.prototypes.push_back(p);
    store.instances.push_back({});
    store.instances.back().prototype = 0;
    store.meta = "{}";
    nurbs::validate(store);
    return store;
  }
};

dvec3 point_of(int corner, double size) {
  return size * dvec3(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
}

// A cube of side 10 on the origin. Faces alternate between forward and reversed surfaces; the loops run the
// way that composed or plain orientations give. p-curves miss the edges by up to `error` mm.
NurbsStore cube(double error, bool composed) {
  std::mt19937_64 engine(5);
  auto jitter = [&] { return std::uniform_real_distribution<double>(-error, error)(engine); };
  Builder b;
  for (int k = 0; k < 8; ++k) b.vertex(point_of(k, 10.0));
  std::int32_t edge_of[8][8];
  for (int a = 0; a < 8; ++a)
    for (int axis = 0; axis < 3; ++axis) {
      const int c = a | (1 << axis);
      if (a == c) continue;
      edge_of[a][c] = edge_of[c][a] =
          b.edge(a, c, {{dvec4(point_of(a, 10.0), 1.0), dvec4(point_of(c, 10.0), 1.0)}}, 3.0 * error + 1e-8);
    }
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      dvec3 outward(0.0), x(0.0);
      outward[axis] = side ? 1.0 : -1.0, x[(axis + 1) % 3] = 1.0;
      const bool reversed = (axis + side) % 2 == 0;
      const dvec3 z = reversed ? -outward : outward, y = glm::cross(z, x);
      const dvec3 origin = side ? 10.0 * outward : dvec3(0.0);
      b.begin_face(nurbs::make_plane({origin, x, z}), reversed);
      b.begin_loop();
      auto uv = [&](int corner) {
        const dvec3 d = point_of(corner, 10.0) - origin;
        return dvec2(glm::dot(d, x), glm::dot(d, y));
      };
      // Corners of the face, counterclockwise in uv.
      std::vector<int> corners;
      for (int k = 0; k < 8; ++k)
        if (((k >> axis) & 1) == side) corners.push_back(k);
      const dvec2 middle = 0.25 * (uv(corners[0]) + uv(corners[1]) + uv(corners[2]) + uv(corners[3]));
      std::sort(corners.begin(), corners.end(), [&](int i, int j) {
        const dvec2 p = uv(i) - middle, q = uv(j) - middle;
        return std::atan2(p.y, p.x) < std::atan2(q.y, q.x);
      });
      if (composed && reversed) std::reverse(corners.begin(), corners.end());
      for (int k = 0; k < 4; ++k) {
        const int from = corners[k], to = corners[(k + 1) % 4];
        const dvec2 p = uv(from) + dvec2(jitter(), jitter()), q = uv(to) + dvec2(jitter(), jitter());
        b.use(edge_of[from][to], from > to, {dvec3(p, 1.0), dvec3(q, 1.0)});
      }
    }
  return b.finish({dvec3(0.0), dvec3(10.0)});
}

dvec3 random_direction(std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  return glm::normalize(dvec3(normal(engine), normal(engine), normal(engine)));
}

// Both conventions for the loops of reversed faces, exact and sloppy p-curves: rays aimed at edges and
// vertices at offsets of 1e-9 ... 1e-2 mm enter and leave alternately.
TEST(EdgeRule, keepsParityEvenOnASloppyCube) {
  for (bool composed : {false, true})
    for (double error : {0.0, 1e-3}) {
      const NurbsStore store = cube(error, composed);
      std::mt19937_64 engine(11);
      std::uniform_real_distribution<double> unit(0.0, 1.0);
      int hit = 0, near_hit = 0;
      for (int k = 0; k < 600; ++k) {
        const int a = static_cast<int>(engine() % 8), c = a ^ (1 << (engine() % 3));
        const double along = k % 5 == 0 ? 0.0 : unit(engine);
        const dvec3 d = random_direction(engine);
        const double offset = k % 7 == 0 ? 0.0 : std::pow(10.0, -9.0 + 7.0 * unit(engine));
        const dvec3 aim =
            glm::mix(point_of(a, 10.0), point_of(c, 10.0), along) + offset * random_direction(engine);
        std::vector<Hit> hits;
        reference::cast_all(store, {aim - 40.0 * d, d}, hits);
        ASSERT_EQ(hits.size() % 2, 0u) << "composed " << composed << " error " << error << " ray " << k;
        for (std::size_t i = 0; i < hits.size(); ++i)
          if (hits.size() == 2 && std::abs(hits[1].t - hits[0].t) > 0.1) {
            EXPECT_EQ(glm::dot(hits[i].normal, d) > 0, i == 1);
          }
        hit += !hits.empty();
        for (const Hit& h : hits) near_hit += std::abs(h.t - 40.0) < 0.02;
      }
      EXPECT_GT(hit, 200);
      EXPECT_LT(hit, 599);
      EXPECT_GT(near_hit, 150);
    }
}

// Rays through the true cube at least a micron inside or outside an edge: the path, not the p-curve, decides.
TEST(EdgeRule, followsThePathNotThePCurve) {
  const NurbsStore store = cube(1e-3, true);
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int k = 0; k < 300; ++k) {
    const double gap = std::pow(10.0, -6.0 + 4.0 * unit(engine)) * (k % 2 ? 1 : -1);
    const dvec3 aim(unit(engine) * 8 + 1, gap, 10.0);  // beside the top edge along x; inside where gap > 0
    std::vector<Hit> hits;
    reference::cast_all(store, {aim + dvec3(0, 0, 20), dvec3(0, 0, -1)}, hits);
    ASSERT_EQ(hits.size(), gap > 0 ? 2u : 0u) << gap;
    if (gap > 0) {
      EXPECT_NEAR(hits[0].t, 20.0, 1e-12);
      EXPECT_NEAR(hits[1].t, 30.0, 1e-12);
    }
  }
}

// A square plate with a round and a square hole; loops of holes run clockwise.
TEST(Trim, holesAreOpen) {
  Builder b;
  b.begin_face(nurbs::make_plane({}), false);
  auto polygon = [&](const std::vector<dvec2>& points) {
    b.begin_loop();
    const std::int32_t first = count(b.store.vertices);
    const int n = static_cast<int>(points.size());
    for (const dvec2& p : points) b.vertex(dvec3(p, 0.0));
    for (int k = 0; k < n; ++k) {
      const int next = (k + 1) % n;
      const std::int32_t e =
          b.edge(first + k, first + next, {{dvec4(points[k], 0, 1), dvec4(points[next], 0, 1)}}, 1e-6);
      b.use(e, false, {dvec3(points[k], 1.0), dvec3(points[next], 1.0)});
    }
  };
  polygon({{-10, -10}, {10, -10}, {10, 10}, {-10, 10}});
  polygon({{4, 4}, {4, 7}, {7, 7}, {7, 4}});
  b.begin_loop();
  const dvec2 center(-3, -2);
  const double radius = 5.0, h = std::sqrt(0.5);
  const dvec2 arc[9] = {{1, 0}, {1, -1}, {0, -1}, {-1, -1}, {-1, 0}, {-1, 1}, {0, 1}, {1, 1}, {1, 0}};
  std::int32_t corner[4];
  for (int q = 0; q < 4; ++q) corner[q] = b.vertex(dvec3(center + radius * arc[2 * q], 0.0));
  for (int q = 0; q < 4; ++q) {
    std::vector<dvec4> ctrl;
    std::vector<dvec3> pcurve;
    for (int i = 0; i < 3; ++i) {
      const double w = i == 1 ? h : 1.0;
      const dvec2 p = center + radius * arc[2 * q + i];
      ctrl.push_back(w * dvec4(p, 0.0, 1.0)), pcurve.push_back(w * dvec3(p, 1.0));
    }
    b.use(b.edge(corner[q], corner[(q + 1) % 4], {ctrl}, 1e-6), false, pcurve);
  }
  const NurbsStore store = b.finish({dvec3(-10, -10, 0), dvec3(10, 10, 0)});

  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> place(-11.0, 11.0);
  int inside = 0;
  for (int k = 0; k < 3000; ++k) {
    dvec2 p(place(engine), place(engine));
    if (k % 3 == 0) {  // within the band of the circle
      const double turn = place(engine);
      p = center + (radius + 1e-7 * place(engine)) * dvec2(std::cos(turn), std::sin(turn));
    }
    const bool expected = std::abs(p.x) <= 10 && std::abs(p.y) <= 10 && glm::length(p - center) >= radius &&
                          !(p.x >= 4 && p.x <= 7 && p.y >= 4 && p.y <= 7);
    std::vector<Hit> hits;
    reference::cast_all(store, {dvec3(p, 3.0), dvec3(0, 0, -1)}, hits);
    ASSERT_EQ(hits.size(), expected ? 1u : 0u) << p.x << ' ' << p.y;
    inside += expected;
  }
  EXPECT_GT(inside, 1000);
}

}  // namespace
}  // namespace trimray::reference_test
