// Samples lie on the model, inside of the trims, evenly, and are the same for the same seed.
#include "core/distance/sample.h"

#include "tests/core/distance/probes.h"
#include "tests/core/tess/trimmed_stores.h"

namespace trimray::distance {
namespace {

using nurbs::NurbsStore;

TEST(Samples, SphereIsCoveredEvenly) {
  const nurbs::FaceSpec face = nurbs::full_sphere({{1, 2, 3}}, 2.0);
  const NurbsStore store = nurbs::make_store(std::span(&face, 1));
  const FaceSamples s = sample_faces(store, {20000, 7, 2});
  ASSERT_EQ(s.point.size(), 20000u);
  // By Archimedes, the height of a point of a sphere is distributed evenly.
  int slices[10] = {}, sectors[8] = {};
  for (std::size_t i = 0; i < s.point.size(); ++i) {
    const dvec3 d = s.point[i] - dvec3(1, 2, 3);
    EXPECT_NEAR(glm::length(d), 2.0, 1e-13);
    EXPECT_NEAR(glm::dot(s.normal[i], d), 2.0, 1e-12);
    ++slices[std::min(9, static_cast<int>((d.z + 2.0) / 0.4))];
    ++sectors[std::min(7, static_cast<int>((std::atan2(d.y, d.x) + 3.14159265358979) / 0.785398163397448))];
  }
  for (const int n : slices) EXPECT_NEAR(n, 2000, 200);  // over four standard deviations
  for (const int n : sectors) EXPECT_NEAR(n, 2500, 220);
}

TEST(Samples, ThinTrimsGetTheirPointsToo) {
  // A ring of 1e-3 of the square's area.
  const auto store = shared(nurbs::trimmed_face(
      nurbs::make_plane({}),
      {nurbs::ellipse({5, 5}, 4.0, 4.0), nurbs::turned(nurbs::ellipse({5, 5}, 3.998, 3.998))}));
  const FaceSamples s = sample_faces(*store, {300, 1, 1});
  EXPECT_EQ(s.point.size(), 300u);
  for (const dvec3& p : s.point) {
    const double r = std::hypot(p.x - 5.0, p.y - 5.0);
    EXPECT_GE(r, 3.998);
    EXPECT_LE(r, 4.0);
  }
}

TEST(Samples, DependOnTheSeedAlone) {
  const nurbs::FaceSpec faces[] = {nurbs::full_torus({}, 3.0, 1.0), nurbs::tube({{9, 0, 0}}, 1.0, 0.0, 2.0)};
  NurbsStore store = nurbs::make_store(faces);
  store.instances.push_back(store.instances[0]);
  store.instances[1].placement.translation = {0, 30, 0};
  const FaceSamples a = sample_faces(store, {50, 3, 1}), b = sample_faces(store, {50, 3, 4}),
                    c = sample_faces(store, {50, 4, 1});
  EXPECT_EQ(a.point, b.point);
  EXPECT_EQ(a.uv_face, b.uv_face);
  EXPECT_NE(a.point, c.point);
  ASSERT_EQ(a.point.size(), 200u);
  EXPECT_EQ(a.instance.front(), 0);
  EXPECT_EQ(a.instance.back(), 1);
  // Instances have points of their own.
  EXPECT_NE(a.uv_face[0], a.uv_face[100]);
  const PointIndex index(shared(store));
  for (std::size_t i = 0; i < a.point.size(); ++i) {
    const Nearest n = index.nearest(a.point[i]);
    EXPECT_LE(n.distance, 1e-12 * index.diagonal());
    EXPECT_EQ(n.face, a.face[i]);
    EXPECT_EQ(n.instance, a.instance[i]);
  }
}

TEST(Samples, EdgesHaveOnePointInEachStretch) {
  const nurbs::FaceSpec face = nurbs::tube({}, 1.0, 0.0, 2.0);
  const NurbsStore store = nurbs::make_store(std::span(&face, 1));
  const EdgeSamples s = sample_edges(store, {40, 5, 1});
  ASSERT_EQ(s.point.size(), 120u);  // two rims and the seam
  const PointIndex index(shared(store));
  std::vector<int> sectors(40, 0);
  for (std::size_t i = 0; i < s.point.size(); ++i) {
    EXPECT_LE(index.nearest(s.point[i], true).distance, 1e-12);
    const dvec3& p = s.point[i];
    EXPECT_NEAR(std::hypot(p.x, p.y), 1.0, 1e-12);
  }
}

TEST(Samples, HostileFacesHaveNone) {
  nurbs::FaceSpec faces[] = {nurbs::full_torus({}, 3.0, 1.0), nurbs::full_sphere({}, 1.0)};
  NurbsStore store = nurbs::make_store(faces);
  store.surfaces[0].r1 = kNaN;
  store.faces[1].status = nurbs::FaceStatus::kBadTrim;
  EXPECT_TRUE(sample_faces(store, {10, 0, 1}).point.empty());
  store.faces[1].status = nurbs::FaceStatus::kOk;
  store.surfaces[1].r1 = 0.0;
  EXPECT_TRUE(sample_faces(store, {10, 0, 1}).point.empty());
  EXPECT_TRUE(sample_faces(NurbsStore{}, {10, 0, 1}).point.empty());
}

}  // namespace
}  // namespace trimray::distance
