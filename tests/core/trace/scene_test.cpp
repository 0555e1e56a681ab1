// What a Scene promises beyond the right place of a hit: parity on closed solids, the same bytes in any order
// and with any number of threads, instances, ties.
#include "core/trace/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "core/base/error.h"
#include "core/brep/bintools.h"
#include "core/nurbs/build_store.h"
#include "core/nurbs/make_store.h"
#include "core/nurbs/surface.h"

namespace trimray::trace {
namespace {

using nurbs::NurbsStore;

std::vector<std::byte> stream(const char* name) {
  const auto path = std::filesystem::path(__FILE__).parent_path().parent_path() / "brep/data" / name;
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file.good()) << path;
  std::vector<char> chars((std::istreambuf_iterator<char>(file)), {});
  std::vector<std::byte> bytes(chars.size());
  std::memcpy(bytes.data(), chars.data(), chars.size());
  return bytes;
}

// The one solid of a stream as a prototype, placed once at the origin.
std::shared_ptr<NurbsStore> solid(const char* name) {
  const std::vector<std::byte> bytes = stream(name);
  const brep::Model model = brep::parse_bintools(bytes);
  nurbs::BuildInput input;
  for (std::size_t i = 0; i < model.shapes.size(); ++i)
    if (model.shapes[i].kind == brep::ShapeKind::kSolid)
      input.prototype_shapes = {static_cast<std::int32_t>(i + 1)};
  EXPECT_EQ(input.prototype_shapes.size(), 1u) << name;
  input.prototype_colors.assign(4, -1.0f);
  input.instance_prototypes = {0};
  input.instance_placements = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  input.instance_colors.assign(4, -1.0f);
  return std::make_shared<NurbsStore>(build_store(bytes, input));
}

dvec3 random_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(dvec3(normal(random), normal(random), normal(random)));
}

// A point on the path of an edge, at its own parameter.
dvec3 edge_point(const NurbsStore& store, const nurbs::Edge& edge, double s) {
  if (edge.pieces.size() == 0) return store.vertices[edge.vertex[0]].point;
  const int piece = std::min(static_cast<int>(s * edge.pieces.size()), edge.pieces.size() - 1);
  const nurbs::Range& r = store.edge_pieces[edge.pieces.begin + piece].ctrl;
  std::vector<dvec4> c(store.edge_ctrl_h.begin() + r.begin, store.edge_ctrl_h.begin() + r.end);
  const double x = s * edge.pieces.size() - piece;
  for (std::size_t n = c.size(); n > 1; --n)
    for (std::size_t i = 0; i + 1 < n; ++i) c[i] = (1.0 - x) * c[i] + x * c[i + 1];
  return dvec3(c[0]) / c[0].w;
}

class SolidTest : public testing::TestWithParam<const char*> {};

TEST_P(SolidTest, EveryRayCrossesTheClosedSolidAnEvenNumberOfTimes) {
  const auto store = solid(GetParam());
  const Scene scene(store, 2);
  ASSERT_FALSE(store->shells.empty());
  EXPECT_TRUE(store->shells[0].closed);
  const double diagonal = store->prototypes[0].bounds.diagonal();
  const dvec3 center = store->prototypes[0].bounds.center();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Ray> rays;
  const auto aim = [&](dvec3 target) {
    const dvec3 dir = random_direction(random);
    rays.push_back({target - 3.0 * diagonal * dir, dir, 0.0, kInf});
  };
  for (int k = 0; k < 600; ++k)
    aim(center + diagonal * 0.5 * (dvec3(unit(random), unit(random), unit(random)) - 0.5));
  for (const nurbs::Edge& edge : store->edges)
    for (int k = 0; k < 60; ++k) {
      const double offset = k % 4 == 0 ? 0.0 : diagonal * std::pow(10.0, -3.0 - 7.0 * unit(random));
      aim(edge_point(*store, edge, unit(random)) + offset * random_direction(random));
    }
  for (const nurbs::Vertex& vertex : store->vertices)
    for (int k = 0; k < 60; ++k) {
      const double offset = k % 4 == 0 ? 0.0 : diagonal * std::pow(10.0, -3.0 - 7.0 * unit(random));
      aim(vertex.point + offset * random_direction(random));
    }
  // Along the axes through everything.
  for (int k = 0; k < 300; ++k) {
    dvec3 dir(0.0);
    dir[k % 3] = 1.0;
    dvec3 target = k < 150 ? store->vertices[k % store->vertices.size()].point
                           : edge_point(*store, store->edges[k % store->edges.size()], unit(random));
    rays.push_back({target - 3.0 * diagonal * dir, dir, 0.0, kInf});
  }
  std::vector<std::int32_t> counts(rays.size());
  scene.count_hits(rays, counts, 2);
  int odd = 0, hit = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    hit += counts[i] > 0;
    if (counts[i] % 2 == 0) continue;
    if (++odd > 5) continue;
    std::vector<Hit> all;
    scene.cast_all(rays[i], all);
    std::ostringstream text;
    for (const Hit& h : all) text << ' ' << h.t << '/' << h.face;
    ADD_FAILURE() << GetParam() << " ray " << i << " has " << counts[i] << " hits:" << text.str();
  }
  EXPECT_EQ(odd, 0) << GetParam() << " of " << rays.size();
  EXPECT_GT(hit, static_cast<int>(rays.size()) / 3);
}

TEST_P(SolidTest, NearestIsTheFirstOfAll) {
  const auto store = solid(GetParam());
  const Scene scene(store, 2);
  const double diagonal = store->prototypes[0].bounds.diagonal();
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  std::vector<Ray> rays;
  for (int k = 0; k < 3000; ++k) {
    const dvec3 dir = random_direction(random);
    const dvec3 target = store->prototypes[0].bounds.center() +
                         diagonal * 0.6 * dvec3(unit(random), unit(random), unit(random));
    rays.push_back({target - 2.0 * diagonal * dir, dir, 0.0, kInf});
  }
  std::vector<Hit> hits(rays.size()), all;
  TraceStats stats;
  scene.cast(rays, hits, 2, &stats);
  EXPECT_EQ(stats.rays, rays.size());
  int met = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    scene.cast_all(rays[i], all);
    ASSERT_EQ(all.empty(), hits[i].face == kNoFace) << i;
    if (all.empty()) continue;
    ++met;
    EXPECT_EQ(all[0].face, hits[i].face);
    EXPECT_LE(std::abs(all[0].t - hits[i].t), 1e-12 * diagonal);
    EXPECT_LE(glm::length(all[0].normal - hits[i].normal), 1e-9);
    // The normal points out of the solid: the ray enters first, then sides alternate.
    for (std::size_t k = 0; k < all.size(); ++k)
      EXPECT_EQ(glm::dot(all[k].normal, rays[i].dir) > 0.0, k % 2 == 1) << "ray " << i << " hit " << k;
    const nurbs::SurfacePoint at =
        evaluate(*store, store->surfaces[store->faces[hits[i].face].surface], hits[i].uv_face);
    EXPECT_LE(glm::length(at.p - (rays[i].org + hits[i].t * rays[i].dir)), 1e-11 * diagonal);
  }
  EXPECT_GT(met, 300);
}

INSTANTIATE_TEST_SUITE_P(Streams, SolidTest,
                         testing::Values("box.bin", "rounded_box.bin", "cylinder.bin", "cone.bin",
                                         "sphere.bin", "torus.bin"));

// A sphere, a torus and a tube as NURBS and a native cone, in one prototype.
NurbsStore mixed_store() {
  const nurbs::Frame3 a{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}, b{{1, 2, 0.5}, {0, 1, 0}, {1, 1, 1}};
  std::vector<nurbs::FaceSpec> faces{nurbs::full_sphere(a, 1.5), nurbs::full_torus(b, 2, 0.5),
                                     nurbs::tube(b, 0.7, -3, 3)};
  for (nurbs::FaceSpec& f : faces) f.surface = nurbs::as_nurbs(f.surface);
  faces.push_back({nurbs::make_cone(a, 2.0, 0.3), Box2{{0, -2}, {2 * std::numbers::pi, 2}}, true, false});
  return nurbs::make_store(faces);
}

std::vector<Ray> grid_rays(dvec3 center, double size, dvec3 dir, int n) {
  std::vector<Ray> rays;
  dir = glm::normalize(dir);
  const dvec3 right = glm::normalize(glm::cross(dir, dvec3(0.1, 0.2, 0.97))), up = glm::cross(right, dir);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      rays.push_back({center + size * ((x + 0.5) / n - 0.5) * right + size * ((y + 0.5) / n - 0.5) * up -
                          2.0 * size * dir,
                      dir, 0.0, kInf});
  return rays;
}

TEST(SceneTest, AnswersDoNotDependOnThreadsOrderOrGrouping) {
  const Scene scene(std::make_shared<NurbsStore>(mixed_store()), 2);
  const std::vector<Ray> rays = grid_rays(dvec3(0.5, 1, 0), 9.0, dvec3(1, -2, -1), 61);
  std::vector<Hit> one(rays.size()), four(rays.size());
  scene.cast(rays, one, 1);
  scene.cast(rays, four, 4);
  ASSERT_EQ(std::memcmp(one.data(), four.data(), one.size() * sizeof(Hit)), 0);
  std::vector<std::size_t> order(rays.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::mt19937_64 random(3);
  std::shuffle(order.begin(), order.end(), random);
  std::vector<Ray> shuffled;
  for (const std::size_t i : order) shuffled.push_back(rays[i]);
  std::vector<Hit> other(rays.size());
  scene.cast(shuffled, other, 2);
  int met = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    met += one[order[k]].face != kNoFace;
    ASSERT_EQ(std::memcmp(&other[k], &one[order[k]], sizeof(Hit)), 0) << "ray " << order[k];
  }
  for (std::size_t i = 0; i < rays.size(); i += 37) {
    Hit alone;
    scene.cast({&rays[i], 1}, {&alone, 1}, 1);
    ASSERT_EQ(std::memcmp(&alone, &one[i], sizeof(Hit)), 0) << "ray " << i;
  }
  EXPECT_GT(met, 1000);
}

TEST(SceneTest, InstancesGiveThePrototypesHitsInTheirPlace) {
  const NurbsStore base = mixed_store();
  const Scene original(std::make_shared<NurbsStore>(base), 2);
  const dvec3 axis = glm::normalize(dvec3(1, 2, -1));
  const double angle = 0.7;
  dmat3 turn;
  for (int k = 0; k < 3; ++k) {
    dvec3 e(0.0);
    e[k] = 1.0;
    turn[k] = std::cos(angle) * e + std::sin(angle) * glm::cross(axis, e) +
              (1 - std::cos(angle)) * glm::dot(axis, e) * axis;
  }
  dmat3 mirror(1.0), stretch(1.0);
  mirror[0][0] = -1.0;
  stretch[1][1] = 2.5;
  const Transform placements[] = {{turn, {100, -20, 7}},
                                  {turn * mirror, {3, 4, 5}},
                                  {3.0 * turn, {0, 0, 50}},
                                  {turn * stretch, {0, 9, 0}}};
  for (const Transform& placement : placements) {
    auto store = std::make_shared<NurbsStore>(base);
    store->instances[0].placement = placement;
    const Scene placed(store, 2);
    const std::vector<Ray> rays = grid_rays(dvec3(0.5, 1, 0), 9.0, dvec3(1, -2, -1), 40);
    std::vector<Ray> moved;
    for (const Ray& r : rays) {
      const dvec3 dir = placement.vector(r.dir);
      moved.push_back({placement.point(r.org), glm::normalize(dir), 0.0, kInf});
    }
    std::vector<Hit> expected(rays.size()), got(rays.size());
    original.cast(rays, expected, 2);
    placed.cast(moved, got, 2);
    const dmat3 normals = glm::transpose(glm::inverse(placement.linear));
    int met = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(got[i].face, expected[i].face) << i;
      if (got[i].face == kNoFace) continue;
      ++met;
      const double stretched = glm::length(placement.vector(rays[i].dir));
      EXPECT_NEAR(got[i].t, expected[i].t * stretched, 1e-11 * (1.0 + got[i].t));
      EXPECT_NEAR(glm::dot(got[i].normal, glm::normalize(normals * expected[i].normal)), 1.0, 1e-9);
    }
    EXPECT_GT(met, 300);
  }
}

TEST(SceneTest, OfTwoCoincidentSolidsTheFirstInstanceWins) {
  auto store = std::make_shared<NurbsStore>(mixed_store());
  store->instances.push_back(store->instances[0]);
  store->instances.push_back(store->instances[0]);
  const Scene scene(store, 2);
  const std::vector<Ray> rays = grid_rays(dvec3(0.5, 1, 0), 9.0, dvec3(-1, 2, -1), 40);
  std::vector<Hit> hits(rays.size()), all;
  scene.cast(rays, hits, 2);
  int met = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].face == kNoFace) continue;
    ++met;
    EXPECT_EQ(hits[i].instance, 0);
    scene.cast_all(rays[i], all);
    EXPECT_EQ(all.size() % 3, 0u);
  }
  EXPECT_GT(met, 300);
}

TEST(SceneTest, LimitsOfTAreClosedAndKept) {
  const nurbs::Frame3 frame;
  const std::vector<nurbs::FaceSpec> faces{nurbs::full_sphere(frame, 2.0)};
  const Scene scene(std::make_shared<NurbsStore>(nurbs::make_store(faces)), 1);
  const dvec3 org(0.3, 0.2, 10.0), dir(0, 0, -1);
  const double half = std::sqrt(4.0 - 0.13);
  const auto first = [&](double tmin, double tmax) {
    const Ray ray{org, dir, tmin, tmax};
    Hit hit;
    scene.cast({&ray, 1}, {&hit, 1}, 1);
    return hit;
  };
  EXPECT_NEAR(first(0.0, kInf).t, 10.0 - half, 1e-14);
  EXPECT_NEAR(first(10.0, kInf).t, 10.0 + half, 1e-14);
  EXPECT_EQ(first(10.0, 10.5).face, kNoFace);
  EXPECT_EQ(first(10.0, 10.5).t, kInf);
  EXPECT_EQ(first(13.0, kInf).face, kNoFace);
  EXPECT_NEAR(first(-kInf, kInf).t, 10.0 - half, 1e-14);
}

TEST(SceneTest, EmptyStoreAndBadRaysGiveMisses) {
  const Scene empty(std::make_shared<NurbsStore>(), 1);
  const Scene scene(std::make_shared<NurbsStore>(mixed_store()), 1);
  const std::vector<Ray> rays{{{0, 0, 9}, {0, 0, -1}, 0, kInf},
                              {{kNaN, 0, 9}, {0, 0, -1}, 0, kInf},
                              {{0, 0, 9}, {0, 0, 0}, 0, kInf},
                              {{0, 0, 9}, {kNaN, 0, -1}, 0, kInf},
                              {{0, 0, kInf}, {0, 0, -1}, 0, kInf}};
  std::vector<Hit> hits(rays.size());
  empty.cast(rays, hits, 1);
  for (const Hit& h : hits) EXPECT_EQ(h.face, kNoFace);
  scene.cast(rays, hits, 1);
  EXPECT_NE(hits[0].face, kNoFace);
  for (std::size_t i = 1; i < hits.size(); ++i) EXPECT_EQ(hits[i].face, kNoFace) << i;
}

// The baseline for measurements: many boxes, small packets.
TEST(SceneTest, BoxesAndPacketsDoNotChangeTheHits) {
  int met = 0;
  for (const auto& store : {std::make_shared<NurbsStore>(mixed_store()), solid("rounded_box.bin")}) {
    const Box3& bounds = store->prototypes[0].bounds;
    const std::vector<Ray> rays = grid_rays(bounds.center(), bounds.diagonal(), dvec3(1, -2, -1), 61);
    const Scene tuned(store, 2);
    std::vector<Hit> expected(rays.size()), got(rays.size());
    tuned.cast(rays, expected, 2);
    for (const Hit& h : expected) met += h.face != kNoFace;
    for (const LeafBoxes boxes : {LeafBoxes::kTuned, LeafBoxes::kPaper})
      for (const int packet : {1, 4, 7, 64}) {
        const Scene scene(store, 2, {boxes, packet});
        TraceStats stats;
        scene.cast(rays, got, 2, &stats);
        EXPECT_EQ(stats.rays, rays.size());
        ASSERT_EQ(std::memcmp(got.data(), expected.data(), got.size() * sizeof(Hit)), 0)
            << static_cast<int>(boxes) << " boxes, packets of " << packet;
        if (boxes == LeafBoxes::kPaper)
          EXPECT_GT(4 * scene.stats().leaf_boxes, 5 * tuned.stats().leaf_boxes);
        else
          EXPECT_EQ(scene.stats().leaf_boxes, tuned.stats().leaf_boxes);
      }
  }
  EXPECT_GT(met, 2000);
}

// The paper has about 400 boxes for one of its teapot's patches, and few for what is flat.
TEST(SceneTest, PaperBoxesFollowTheCurvature) {
  const nurbs::Frame3 frame;
  nurbs::FaceSpec flat{nurbs::make_plane(frame), Box2{{0, 0}, {3, 2}}, true, false};
  nurbs::FaceSpec flat_nurbs = flat;
  flat_nurbs.surface =
      nurbs::make_bezier(1, 1, std::vector<dvec4>{{0, 0, 0, 1}, {0, 2, 0, 1}, {3, 0, 0, 1}, {3, 2, 0, 1}});
  flat_nurbs.uv_box = Box2{{0, 0}, {1, 1}};
  nurbs::FaceSpec native = nurbs::full_torus(frame, 2, 0.5), spline = native;
  spline.surface = nurbs::as_nurbs(spline.surface);
  const auto count = [](const nurbs::FaceSpec& face) {
    const std::vector<nurbs::FaceSpec> faces{face};
    return Scene(std::make_shared<NurbsStore>(nurbs::make_store(faces)), 1, {LeafBoxes::kPaper, 4})
        .stats()
        .leaf_boxes;
  };
  EXPECT_EQ(count(flat), 16);
  EXPECT_EQ(count(flat_nurbs), 25);
  EXPECT_GT(count(native), 400);
  EXPECT_GT(count(spline), 400);
  EXPECT_LT(std::max(count(native), count(spline)), 3 * std::min(count(native), count(spline)));
}

TEST(SceneTest, PacketsHaveOneTo64Rays) {
  const auto store = std::make_shared<NurbsStore>(mixed_store());
  EXPECT_THROW(Scene(store, 1, {LeafBoxes::kTuned, 0}), ArgumentError);
  EXPECT_THROW(Scene(store, 1, {LeafBoxes::kTuned, 65}), ArgumentError);
}

}  // namespace
}  // namespace trimray::trace
