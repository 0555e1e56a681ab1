// What a PointIndex promises on free-form surfaces, meshes, placements and damaged stores.
#include <algorithm>
#include <cstring>

#include "core/nurbs/mesh_store.h"
#include "tests/core/distance/probes.h"
#include "tests/core/tess/trimmed_stores.h"

namespace trimray::distance {
namespace {

using nurbs::NurbsStore;

// A wavy spline surface over [0, 4]^2; creases: a knot of full multiplicity in u.
nurbs::SurfaceForm wavy(unsigned seed, bool rational, bool creases) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const std::vector<double> u = creases ? std::vector<double>{0, 0, 0, 0, 2, 2, 2, 4, 4, 4, 4}
                                        : std::vector<double>{0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4},
                            v{0, 0, 0, 1, 2, 4, 4, 4};
  const int count_u = static_cast<int>(u.size()) - 4, count_v = static_cast<int>(v.size()) - 3;
  std::vector<dvec4> ctrl;
  for (int i = 0; i < count_u; ++i)
    for (int j = 0; j < count_v; ++j) {
      const double w = rational ? 1.0 + 0.6 * unit(random) : 1.0;
      const double x = 4.0 * i / (count_u - 1) + 0.2 * unit(random),
                   y = 4.0 * j / (count_v - 1) + 0.2 * unit(random);
      ctrl.push_back(dvec4(w * dvec3(x, y, 1.2 * unit(random)), w));
    }
  return nurbs::make_bspline(3, 2, u, v, ctrl);
}

nurbs::TrimLoop square(double lower, double upper) {
  return nurbs::polygon({{lower, lower}, {upper, lower}, {upper, upper}, {lower, upper}});
}

class Wavy : public testing::TestWithParam<int> {};

TEST_P(Wavy, IsBetweenTheBoundsOfManyPoints) {
  const unsigned seed = GetParam();
  const nurbs::SurfaceForm form = wavy(seed, seed % 2 == 1, seed % 4 >= 2);
  const NurbsStore store = nurbs::trimmed_face(
      form, {square(0.25, 3.75), nurbs::turned(nurbs::ellipse({1.8, 2.2}, 0.7, 0.5))}, seed % 3 == 0);
  std::vector<dvec3> queries = random_points(120, {2, 2, 0}, 3.0, seed);
  for (const dvec3& far : random_points(20, {2, 2, 0}, 60.0, seed)) queries.push_back(far);
  expect_between_bounds(store, queries, 200);
}

// Every random descent from many starts ends no nearer than what was found: the global minimum.
TEST_P(Wavy, NoDescentFindsANearerPoint) {
  const unsigned seed = GetParam();
  nurbs::FaceSpec face{wavy(seed, seed % 2 == 1, seed % 4 >= 2), {{0, 0}, {4, 4}}};
  face.natural = true;
  const auto store = shared(nurbs::make_store(std::span(&face, 1)));
  const PointIndex index(store);
  const nurbs::SurfaceView surface = nurbs::view(*store, store->surfaces[0]);
  for (const dvec3& q : random_points(40, {2, 2, 0}, 2.5, seed)) {
    const Nearest n = index.nearest(q);
    EXPECT_EQ(n.gap, 0.0);
    double least = kInf;
    for (int i = 0; i <= 24; ++i)
      for (int j = 0; j <= 24; ++j) {
        // Coordinate descent with shrinking steps: slow, and it cannot be fooled.
        dvec2 uv(i / 6.0, j / 6.0);
        double d = glm::distance(nurbs::evaluate_point(surface, uv), q);
        if (d > least + 0.4) continue;
        for (double step = 0.1; step > 1e-9;) {
          bool better = false;
          for (const dvec2& move : {dvec2(step, 0), dvec2(-step, 0), dvec2(0, step), dvec2(0, -step)}) {
            const dvec2 next = glm::clamp(uv + move, dvec2(0.0), dvec2(4.0));
            const double e = glm::distance(nurbs::evaluate_point(surface, next), q);
            if (e < d) d = e, uv = next, better = true;
          }
          if (!better) step *= 0.5;
        }
        least = std::min(least, d);
      }
    EXPECT_LE(n.distance - least, 1e-12 * index.diagonal());
    EXPECT_GE(n.distance - least, -1e-7);
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, Wavy, testing::Range(0, 8));

TEST(PointIndex, PointsOfTheModelAreAtNoDistance) {
  const auto store = shared(nurbs::trimmed_face(wavy(3, true, false), {square(0.5, 3.5)}));
  const PointIndex index(store);
  const nurbs::TrimIndex trims(*store);
  for (const dvec3& r : random_points(500, {2, 2, 0}, 1.5)) {
    const dvec2 uv(r.x, r.y);
    ASSERT_TRUE(trims.inside(0, uv));
    const dvec3 p = nurbs::evaluate(*store, store->surfaces[0], uv).p;
    const Nearest n = index.nearest(p);
    EXPECT_LE(n.distance, 1e-12 * index.diagonal());
  }
  for (std::size_t piece = 0; piece < store->edge_pieces.size(); ++piece) {
    const Nearest n = index.nearest(path_point(*store, static_cast<std::int32_t>(piece), 0.3));
    EXPECT_LE(n.distance, 1e-12 * index.diagonal());
    EXPECT_GE(n.edge, 0);
  }
}

TEST(PointIndex, EdgesOnlyIsTheDistanceFromTheEdgesPaths) {
  const NurbsStore store = nurbs::trimmed_face(wavy(5, false, false), {square(0.5, 3.5)});
  const PointIndex index(shared(store));
  double spacing = 0.0;
  std::vector<dvec3> cloud;
  for (std::size_t piece = 0; piece < store.edge_pieces.size(); ++piece)
    for (int i = 0; i <= 1000; ++i) {
      cloud.push_back(path_point(store, static_cast<std::int32_t>(piece), i / 1000.0));
      if (i > 0) spacing = std::max(spacing, glm::distance(cloud.back(), cloud[cloud.size() - 2]));
    }
  for (const dvec3& q : random_points(200, {2, 2, 0}, 3.0)) {
    double upper = kInf;
    for (const dvec3& p : cloud) upper = std::min(upper, glm::distance(p, q));
    const Nearest n = index.nearest(q, true);
    EXPECT_LE(n.distance, upper);
    EXPECT_GE(n.distance, upper - spacing);
    EXPECT_GE(n.edge, 0);
    EXPECT_EQ(n.face, 0);
    EXPECT_LE(index.nearest(q).distance, n.distance);
  }
}

TEST(PointIndex, TrianglesAreTheirOwnTruth) {
  std::vector<dvec3> vertices = random_points(60, {0, 0, 0}, 2.0);
  std::vector<nurbs::Triangle> triangles;
  for (int i = 0; i < 20; ++i) triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  const std::vector<std::int32_t> one(triangles.size(), 0);
  NurbsStore store;
  store.mesh_vertices = vertices, store.mesh_triangles = triangles;
  nurbs::Face face;
  face.surface = 0, face.prototype = 0, face.triangles = {0, 20}, face.uv_box = {{0, 0}, {1, 1}};
  store.surfaces.emplace_back().kind = nurbs::SurfaceKind::kMesh;
  store.faces.push_back(face);
  nurbs::Prototype& p = store.prototypes.emplace_back();
  p.faces = {0, 1}, p.bounds = {{-2, -2, -2}, {2, 2, 2}};
  store.instances.emplace_back().prototype = 0;
  const PointIndex index(shared(store));
  for (const dvec3& q : random_points(300, {0, 0, 0}, 4.0, 2)) {
    double least = kInf;
    for (const nurbs::Triangle& t : triangles)
      for (int i = 0; i <= 60; ++i)
        for (int j = 0; i + j <= 60; ++j)
          least =
              std::min(least, glm::distance(q, vertices[t[0]] + i / 60.0 * (vertices[t[1]] - vertices[t[0]]) +
                                                   j / 60.0 * (vertices[t[2]] - vertices[t[0]])));
    const Nearest n = index.nearest(q);
    EXPECT_LE(n.distance, least + 1e-13);
    EXPECT_GE(n.distance, least - 0.12);
    EXPECT_NEAR(glm::distance(n.point, q), n.distance, 1e-13);
    EXPECT_GE(n.uv_face.x, 0.0);
    EXPECT_LE(n.uv_face.x + n.uv_face.y, 1.0 + 1e-12);
  }
}

dmat3 turn(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return dmat3(dvec3(c, s, 0), dvec3(-s, c, 0), dvec3(0, 0, 1)) *
         dmat3(dvec3(1, 0, 0), dvec3(0, c, s), dvec3(0, -s, c));
}

TEST(PointIndex, InstancesTurnedMirroredScaled) {
  const nurbs::Frame3 frame{{0.5, 0, 0}};
  const nurbs::FaceSpec face = nurbs::full_torus(frame, 2.0, 0.5);
  NurbsStore store = nurbs::make_store(std::span(&face, 1));
  store.instances.clear();
  const dmat3 mirror(dvec3(-1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1));
  const Transform placements[] = {
      {turn(0.7), {10, 0, 0}}, {turn(1.9) * mirror, {0, 12, 0}}, {2.5 * turn(0.2), {0, 0, 20}}};
  for (const Transform& t : placements) {
    store.instances.emplace_back().prototype = 0;
    store.instances.back().placement = t;
  }
  const auto kept = shared(store);
  const PointIndex index(kept);
  const nurbs::TrimIndex trims(*kept);
  for (const dvec3& q : random_points(400, {3, 4, 6}, 20.0)) {
    double least = kInf;
    int which = -1;
    for (int i = 0; i < 3; ++i) {
      const dvec3 p = glm::inverse(placements[i].linear) * (q - placements[i].translation) - frame.location;
      const double scale = i == 2 ? 2.5 : 1.0;
      const double d = scale * std::abs(std::hypot(std::hypot(p.x, p.y) - 2.0, p.z) - 0.5);
      if (d < least) least = d, which = i;
    }
    const Nearest n = index.nearest(q);
    EXPECT_NEAR(n.distance, least, 1e-12 * index.diagonal());
    EXPECT_EQ(n.instance, which);
    expect_sound(*kept, trims, q, n, index.diagonal());
  }
}

// A sphere under a placement that is no similarity: an ellipsoid.
TEST(PointIndex, StretchedInstancesAreExactToo) {
  const nurbs::FaceSpec face = nurbs::full_sphere({}, 1.0);
  NurbsStore store = nurbs::make_store(std::span(&face, 1));
  const dvec3 axes(3.0, 2.0, 1.0);
  store.instances[0].placement = {dmat3(dvec3(3, 0, 0), dvec3(0, 2, 0), dvec3(0, 0, 1)), {1, 1, 1}};
  const PointIndex index(shared(store));
  for (const dvec3& q : random_points(200, {1, 1, 1}, 4.0)) {
    // The foot point is q_i a_i^2 / (a_i^2 + t) with the largest root t of sum (a_i q_i / (a_i^2 + t))^2 = 1.
    const dvec3 p = q - dvec3(1.0), aa = axes * axes;
    double low = -1.0, high = 100.0;
    for (int k = 0; k < 200; ++k) {
      const double t = 0.5 * (low + high);
      const dvec3 x = axes * p / (aa + t);
      (glm::dot(x, x) > 1.0 ? low : high) = t;
    }
    const dvec3 foot = p * aa / (aa + 0.5 * (low + high));
    const Nearest n = index.nearest(q);
    EXPECT_NEAR(n.distance, glm::distance(p, foot), 1e-11);
  }
}

TEST(PointIndex, SameBitsForAnyNumberOfThreads) {
  const auto store = shared(nurbs::trimmed_face(wavy(6, false, true), {square(0.25, 3.75)}));
  const PointIndex index(store, 3);
  const std::vector<dvec3> queries = random_points(500, {2, 2, 0}, 3.0);
  std::vector<Nearest> one(queries.size()), four(queries.size());
  index.nearest(queries, one, 1);
  index.nearest(queries, four, 4);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    EXPECT_EQ(one[i].distance, four[i].distance);
    EXPECT_EQ(one[i].point, four[i].point);
    EXPECT_EQ(one[i].uv_face, four[i].uv_face);
    EXPECT_EQ(one[i].edge, four[i].edge);
    const Nearest alone = index.nearest(queries[i]);
    EXPECT_EQ(alone.distance, one[i].distance);
    EXPECT_EQ(alone.point, one[i].point);
  }
}

TEST(PointIndex, NothingIsInfinitelyFar) {
  const PointIndex empty(shared(NurbsStore{}));
  EXPECT_EQ(empty.nearest({1, 2, 3}).distance, kInf);
  EXPECT_EQ(empty.nearest({1, 2, 3}).face, kNoFace);
  const PointIndex sphere(shared([] {
    const nurbs::FaceSpec face = nurbs::full_sphere({}, 1.0);
    return nurbs::make_store(std::span(&face, 1));
  }()));
  EXPECT_EQ(sphere.nearest({kNaN, 0, 0}).distance, kInf);
  EXPECT_EQ(sphere.nearest({kInf, 0, 0}).face, kNoFace);
  EXPECT_NEAR(sphere.nearest({1e9, 0, 0}).distance, 1e9 - 1.0, 1e-6);
}

// Numbers that are no numbers, or absurd, anywhere: no crash, no hang, and what is sound is still found.
TEST(PointIndex, DamagedStoresAreSearchedAllTheSame) {
  const nurbs::FaceSpec good = nurbs::tube({{20, 0, 0}}, 1.0, -1.0, 1.0);
  const nurbs::FaceSpec faces[] = {
      {wavy(1, true, false), {{0, 0}, {4, 4}}}, nurbs::full_torus({}, 3.0, 1.0), good};
  const NurbsStore sound = nurbs::make_store(faces);
  const double poison[] = {kNaN, kInf, -1e300, 1e300, 0.0, 1e-300};
  std::mt19937_64 random(9);
  const std::vector<dvec3> queries = random_points(6, {2, 2, 0}, 4.0);
  int found = 0;
  for (int round = 0; round < 240; ++round) {
    NurbsStore store = sound;
    const double x = poison[round % 6];
    // The third face stays as it is.
    const std::size_t k = random();
    const auto hit = [&](auto& array, std::size_t limit) -> auto& {
      return array[k % std::max<std::size_t>(1, limit)];
    };
    switch (round / 6 % 8) {
      case 0:
        hit(store.ctrl_h, store.surfaces[2].ctrl.begin)[k % 4] = x;
        break;
      case 1:
        hit(store.edge_ctrl_h, 8)[k % 4] = x;
        break;
      case 2:
        store.surfaces[1].r1 = x;
        break;
      case 3:
        store.surfaces[1].location = dvec3(x);
        break;
      case 4:
        store.surfaces[k % 2].kind = nurbs::SurfaceKind::kOffset, store.surfaces[k % 2].offset = x;
        break;
      case 5:
        store.faces[k % 2].uv_box.upper = dvec2(x);
        break;
      case 6:
        hit(store.trim_ctrl_h, 8)[k % 3] = x;
        break;
      default:
        store.vertices[0].point = dvec3(x);
        break;
    }
    const PointIndex index(shared(std::move(store)), 1);
    for (const dvec3& q : queries) (void)index.nearest(q);
    // Of one damaged surface or p-curve the other faces know nothing. (An absurd path moves the middle that
    // all paths are relative to; an absurd offset makes most boxes absurd.)
    const int damage = round / 6 % 8;
    if (damage == 1 || damage == 4 || damage == 7) continue;
    EXPECT_NEAR(index.nearest({20, 0, 5}).distance, std::hypot(1.0, 4.0), 1e-6) << "round " << round;
    ++found;
  }
  EXPECT_EQ(found, 150);
}

TEST(PointIndex, FacesWithoutSizeArePoints) {
  nurbs::FaceSpec face{nurbs::make_bezier(1, 1, std::vector<dvec4>(4, dvec4(1, 2, 3, 1))), {{0, 0}, {1, 1}}};
  const PointIndex index(shared(nurbs::make_store(std::span(&face, 1))));
  EXPECT_NEAR(index.nearest({1, 2, 5}).distance, 2.0, 1e-12);
}

}  // namespace
}  // namespace trimray::distance
