// What the backends draw, against every triangle tried in double precision.
#include "core/base/error.h"
#include "tests/core/raster/scenes.h"

namespace trimray::raster::testing {
namespace {

using Draw = EachBackend;
INSTANTIATE_TEST_SUITE_P(Backends, Draw, ::testing::ValuesIn(kBackends), backend_test_name);

void expect_drawn(Rasterizer& rasterizer, const tess::ViewMeshes& meshes, const NurbsStore& store,
                  const Camera& camera, int least_covered, int samples = 1500) {
  const SlowRaster slow(meshes, store, camera);
  for (const SeedProcess process : {SeedProcess::kUv, SeedProcess::kId}) {
    const SeedBuffers b = rasterizer.draw(meshes, store, camera, process);
    ASSERT_EQ(b.width_px, camera.width_px);
    ASSERT_EQ(b.height_px, camera.height_px);
    ASSERT_EQ(b.process, process);
    const std::size_t pixels = static_cast<std::size_t>(camera.width_px) * camera.height_px;
    ASSERT_EQ(b.id.size(), pixels);
    ASSERT_EQ(b.uv.size(), process == SeedProcess::kUv ? 2 * pixels : 0);
    const Difference d = compare(b, slow, meshes, samples);
    EXPECT_EQ(d.wrong, 0) << "of " << d.compared;
    EXPECT_GE(d.covered, least_covered);
    EXPECT_LE(d.unclear, samples / 5);
    EXPECT_LE(d.uv, 1e-5);
  }
}

TEST_P(Draw, FindsTheFirstTriangle) {
  const auto store = placed(ring_and_ball(), {at(dvec3(0.0))});
  tess::MeshLevels levels(store);
  for (const bool perspective : {false, true}) {
    const Camera c = camera(240, 180, perspective ? 0.0025 : 0.03, perspective);
    const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
    ASSERT_GT(meshes.triangles, 500u);
    expect_drawn(*rasterizer, meshes, *store, c, 400);
  }
}

TEST_P(Draw, PlacesInstances) {
  const auto store =
      placed(ring_and_ball(), {at({-2, 1, 0}, {1, 1, -1}), turned({2, 0, 1}, 1.0, 0.5),
                               turned({0, -2, -1}, 2.0, 0.8), at({1, 3, 1}, {-0.7, 0.3, 1.1})});
  tess::MeshLevels levels(store);
  for (const bool perspective : {false, true}) {
    const Camera c = camera(200, 200, perspective ? 0.0035 : 0.04, perspective);
    const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
    ASSERT_EQ(meshes.instances.size(), 4u);
    expect_drawn(*rasterizer, meshes, *store, c, 150, 700);
  }
}

TEST_P(Draw, FacesOfTrianglesAreDrawnToo) {
  using trimray::testing::box_mesh;
  const auto store = placed(trimray::testing::store_in_groups(box_mesh({-1, -1, -1}, {1, 1, 1}, 3), 10),
                            {turned(dvec3(0.0), 0.3), at({2, 0, 0})});
  tess::MeshLevels levels(store);
  const Camera c = camera(150, 150, 0.03);
  const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
  expect_drawn(*rasterizer, meshes, *store, c, 300);
}

// The eye stands in the ball: triangles cross the near plane, and the shell is seen from inside.
TEST_P(Draw, TheEyeMayStandInTheModel) {
  const auto store = placed(ring_and_ball(), {at(dvec3(0.0)), at({0.3, 0, 0}, dvec3(0.2))});
  tess::MeshLevels levels(store, {.angle = 0.3});
  Camera c = camera(160, 120, 0.012, true);
  c.eye = {0.1, 0.05, 0.3};
  const tess::ViewMeshes meshes = levels.meshes(c, 1.0);
  expect_drawn(*rasterizer, meshes, *store, c, 1300);
}

// What stands behind the image plane of an orthographic camera is not seen.
TEST_P(Draw, TheImagePlaneMayCutTheModel) {
  const auto store = placed(ring_and_ball(), {at(dvec3(0.0))});
  tess::MeshLevels levels(store);
  Camera c = camera(200, 150, 0.03);
  c.eye = dvec3(0.0);
  const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
  expect_drawn(*rasterizer, meshes, *store, c, 300);
}

TEST_P(Draw, AShellTurnedInsideOutIsSeen) {
  auto box = trimray::testing::box_mesh({-1, -1, -1}, {1, 1, 1}, 2);
  for (auto& [a, b, c] : box.triangles) std::swap(b, c);
  const auto store = placed(trimray::testing::store_of(box), {at(dvec3(0.0))});
  ASSERT_TRUE(store->shells[0].closed);
  tess::MeshLevels levels(store);
  const Camera c = camera(100, 100, 0.04);
  const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
  expect_drawn(*rasterizer, meshes, *store, c, 500);
}

TEST_P(Draw, AnOpenShellIsSeenFromBothSides) {
  const auto store =
      placed(nurbs::make_store(std::vector{nurbs::tube({}, 1.0, -1.0, 1.0)}), {at(dvec3(0.0))});
  tess::MeshLevels levels(store);
  Camera c = camera(150, 150, 0.02);
  for (const double elevation : {50.0, -50.0}) {
    const Camera turn = view::look(30.0, elevation, view::UpAxis::kZ);
    c.right = turn.right, c.up = turn.up, c.forward = turn.forward, c.eye = -8.0 * turn.forward;
    const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
    expect_drawn(*rasterizer, meshes, *store, c, 400, 800);
  }
}

TEST_P(Draw, FarAwayIsAsSharpAsNear) {
  const dvec3 place(3e6, -2e6, 1e6);
  const auto store = placed(ring_and_ball(), {at(place)});
  tess::MeshLevels levels(store);
  for (const bool perspective : {false, true}) {
    Camera c = camera(120, 120, perspective ? 0.005 : 0.05, perspective);
    c.eye += place;
    const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
    expect_drawn(*rasterizer, meshes, *store, c, 150, 800);
  }
}

TEST_P(Draw, ZoomedIntoAPart) {
  const auto store = placed(ring_and_ball(), {at(dvec3(0.0))});
  tess::MeshLevels levels(store);
  Camera c = camera(150, 100, 2e-4);
  c.eye += 1.5 * c.right;
  const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
  expect_drawn(*rasterizer, meshes, *store, c, 300, 500);
}

TEST_P(Draw, PicturesOfAnySize) {
  const auto store = placed(ring_and_ball(), {at(dvec3(0.0))});
  tess::MeshLevels levels(store);
  for (const auto& [w, h] : {std::pair{1, 1}, {7, 1}, {1, 9}, {37, 21}, {66, 130}, {2048, 2048}, {5, 3}}) {
    const Camera c = camera(w, h, 6.0 / std::max(w, h));
    const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
    const SlowRaster slow(meshes, *store, c);
    const SeedBuffers b = rasterizer->draw(meshes, *store, c, SeedProcess::kUv);
    const Difference d = compare(b, slow, meshes, 60);
    EXPECT_EQ(d.wrong, 0) << w << " x " << h;
    EXPECT_GE(d.compared, 30);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(b.id.data()) % 64, 0u);
  }
}

TEST_P(Draw, NothingToSee) {
  const auto store = placed(ring_and_ball(), {at(dvec3(0.0))});
  tess::MeshLevels levels(store);
  Camera c = camera(64, 48, 0.1);
  const tess::ViewMeshes meshes = levels.meshes(c, 0.5);
  const auto covered = [&](const tess::ViewMeshes& m, const Camera& of) {
    std::size_t count = 0;
    for (const SeedProcess process : {SeedProcess::kUv, SeedProcess::kId})
      for (const std::uint32_t id : rasterizer->draw(m, *store, of, process).id) count += id != 0;
    return count;
  };
  EXPECT_GT(covered(meshes, c), 0u);
  EXPECT_EQ(covered({}, c), 0u) << "no instance";
  Camera behind = c;
  behind.eye = 20.0 * c.forward;
  EXPECT_EQ(covered(meshes, behind), 0u) << "all of it behind the eye";
  Camera aside = c;
  aside.eye += 100.0 * c.right;
  EXPECT_EQ(covered(meshes, aside), 0u) << "all of it beside the picture";
  tess::ViewMeshes empty = meshes;
  empty.instances[0].mesh = std::make_shared<tess::Tessellation>();
  EXPECT_EQ(covered(empty, c), 0u) << "a mesh without triangles";
  EXPECT_GT(covered(meshes, c), 0u);
}

TEST_P(Draw, RefusesWhatCannotBeDrawn) {
  const auto store = placed(ring_and_ball(), {at(dvec3(0.0))});
  tess::MeshLevels levels(store);
  const Camera good = camera(32, 32, 0.2);
  const tess::ViewMeshes meshes = levels.meshes(good, 0.5);
  const auto draw = [&](const tess::ViewMeshes& m, const Camera& c) {
    return rasterizer->draw(m, *store, c, SeedProcess::kUv);
  };
  for (const auto& [w, h] : {std::pair{0, 32}, {32, 0}, {-1, 32}, {kMaxPicturePx + 1, 1}, {1, 1 << 30}}) {
    Camera c = good;
    c.width_px = w, c.height_px = h;
    EXPECT_THROW(draw(meshes, c), ArgumentError) << w << " x " << h;
  }
  for (const double pixel : {0.0, -1.0, kNaN, kInf}) {
    Camera c = good;
    c.pixel = pixel;
    EXPECT_THROW(draw(meshes, c), ArgumentError) << pixel;
  }
  const auto broken = [&](auto&& change) {
    auto mesh = std::make_shared<tess::Tessellation>(*meshes.instances[0].mesh);
    change(mesh->mesh);
    tess::ViewMeshes m = meshes;
    m.instances[0].mesh = mesh;
    EXPECT_THROW(draw(m, good), ArgumentError);
  };
  broken([](tess::TriMesh& m) { m.triangles[3][1] = static_cast<std::int32_t>(m.vertices.size()); });
  broken([](tess::TriMesh& m) { m.triangles[3][1] = -1; });
  broken([](tess::TriMesh& m) { m.face[5] = 2; });
  broken([](tess::TriMesh& m) { m.face[5] = -1; });
  broken([](tess::TriMesh& m) { m.face.pop_back(); });
  broken([](tess::TriMesh& m) { m.corner_uv.pop_back(); });
  tess::ViewMeshes m = meshes;
  m.instances[0].instance = 1;
  EXPECT_THROW(draw(m, good), ArgumentError);
  m.instances[0] = {.instance = 0, .mesh = nullptr};
  EXPECT_THROW(draw(m, good), ArgumentError);
  EXPECT_NO_THROW(draw(meshes, good));
}

// Corners that are no numbers, or too far for floats: nothing breaks, and the rest is drawn.
TEST_P(Draw, CornersThatAreNoNumbers) {
  const auto store = placed(ring_and_ball(), {at(dvec3(0.0))});
  tess::MeshLevels levels(store);
  for (const bool perspective : {false, true}) {
    const Camera c = camera(64, 64, perspective ? 0.01 : 0.12, perspective);
    tess::ViewMeshes meshes = levels.meshes(c, 0.5);
    auto mesh = std::make_shared<tess::Tessellation>(*meshes.instances[0].mesh);
    mesh->mesh.vertices[3] = dvec3(kNaN), mesh->mesh.vertices[4].y = 1e300, mesh->mesh.vertices[5].x = -kInf;
    meshes.instances[0].mesh = mesh;
    const SeedBuffers b = rasterizer->draw(meshes, *store, c, SeedProcess::kUv);
    for (const std::uint32_t id : b.id) ASSERT_LE(id, b.targets.size());
  }
}

}  // namespace
}  // namespace trimray::raster::testing
