// Faces of triangles in a store: made, checked, saved, bounded, merged.
#include "core/nurbs/mesh_store.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "core/base/error.h"
#include "core/nurbs/bounds.h"
#include "core/nurbs/make_store.h"
#include "core/nurbs/merge_stores.h"
#include "core/nurbs/store_file.h"
#include "tests/core/nurbs/meshes.h"

using namespace trimray;
using namespace trimray::nurbs;
using namespace trimray::testing;

TEST(MeshStore, holdsOneFaceAGroup) {
  const TestMesh mesh = tetrahedron();
  MeshGroup groups[] = {{1}, {4}};
  groups[1].color[0] = 0.25f;
  const NurbsStore store = mesh_store(mesh.vertices, mesh.triangles, groups, "{\"name\": \"stand\"}");
  validate(store);
  ASSERT_EQ(store.faces.size(), 2u);
  EXPECT_EQ(store.faces[1].triangles.begin, 1);
  EXPECT_EQ(store.faces[1].triangles.end, 4);
  EXPECT_FALSE(store.faces[0].has_color());
  EXPECT_EQ(store.faces[1].color[0], 0.25f);
  EXPECT_STREQ(kind_name(store.surfaces[store.faces[0].surface].kind), "mesh");
  EXPECT_EQ(store.meta, "{\"name\": \"stand\"}");
  ASSERT_EQ(store.shells.size(), 1u);
  EXPECT_TRUE(store.shells[0].closed);
  ASSERT_EQ(store.instances.size(), 1u);
  EXPECT_EQ(store.prototypes[0].bounds.lower, dvec3(0.0));
  EXPECT_EQ(store.prototypes[0].bounds.upper, dvec3(1.0));
}

TEST(MeshStore, nothingIsAModelWithoutFaces) {
  const NurbsStore store = mesh_store({}, {}, {}, "{}");
  validate(store);
  EXPECT_TRUE(store.faces.empty());
}

TEST(MeshStore, refusesWhatDoesNotFit) {
  const TestMesh good = tetrahedron();
  const auto make = [&](const std::function<void(TestMesh&)>& damage, std::vector<MeshGroup> groups) {
    TestMesh mesh = good;
    damage(mesh);
    return mesh_store(mesh.vertices, mesh.triangles, groups, "{}");
  };
  const auto none = [](TestMesh&) {};
  EXPECT_NO_THROW(make(none, {{4}}));
  for (const double x : {kNaN, kInf, -kInf, 1e13})
    EXPECT_THROW(make([&](TestMesh& m) { m.vertices[2].y = x; }, {{4}}), ArgumentError) << x;
  for (const std::int32_t v : {-1, 4, std::numeric_limits<std::int32_t>::max()})
    EXPECT_THROW(make([&](TestMesh& m) { m.triangles[3][1] = v; }, {{4}}), ArgumentError) << v;
  for (const std::vector<MeshGroup>& groups :
       {std::vector<MeshGroup>{}, {{3}}, {{5}}, {{0}, {4}}, {{2}, {2}, {4}}, {{3}, {2}, {4}}, {{-1}, {4}}})
    EXPECT_THROW(make(none, groups), ArgumentError) << groups.size();
}

TEST(MeshStore, knowsWhatClosesUp) {
  for (const TestMesh& mesh : {tetrahedron(), ball_mesh({}, 2.0, 3), box_mesh({0, 0, 0}, {1, 2, 3}, 4),
                               box_mesh({0, 0, 0}, {1, 2, 3}, 4, false)}) {
    EXPECT_TRUE(closes_up(mesh.vertices, mesh.triangles));
    TestMesh open = mesh;
    open.triangles.pop_back();
    EXPECT_FALSE(closes_up(open.vertices, open.triangles));
    TestMesh twice = mesh;
    twice.triangles.push_back(twice.triangles[0]);
    EXPECT_FALSE(closes_up(twice.vertices, twice.triangles));
    TestMesh turned = mesh;
    std::swap(turned.triangles[1][0], turned.triangles[1][1]);
    EXPECT_FALSE(closes_up(turned.vertices, turned.triangles));
    TestMesh flat = mesh;  // a triangle that is a line changes nothing
    flat.triangles.push_back({flat.triangles[0][0], flat.triangles[0][1], flat.triangles[0][0]});
    EXPECT_TRUE(closes_up(flat.vertices, flat.triangles));
  }
  EXPECT_FALSE(closes_up({}, {}));
}

TEST(MeshStore, validateRefusesHostileMeshes) {
  const NurbsStore good = store_in_groups(ball_mesh({}, 1.0, 1), 5);
  validate(good);
  const std::vector<std::function<void(NurbsStore&)>> damages = {
      [](NurbsStore& s) { s.mesh_triangles[7][2] = static_cast<std::int32_t>(s.mesh_vertices.size()); },
      [](NurbsStore& s) { s.mesh_triangles[7][2] = -1; },
      [](NurbsStore& s) { s.mesh_vertices[3].z = kNaN; },
      [](NurbsStore& s) { s.mesh_vertices[3].z = 1e300; },
      [](NurbsStore& s) { s.faces[2].triangles.end += 1; },  // one triangle of the next face
      [](NurbsStore& s) { s.faces[2].triangles = s.faces[0].triangles; },
      [](NurbsStore& s) {
        s.faces[2].triangles = {0, 1 << 30};
      },
      [](NurbsStore& s) {
        s.faces[2].triangles = {-5, 0};
      },
      [](NurbsStore& s) {
        s.faces[2].triangles = {5, 5};
      },  // kind mesh without triangles
      [](NurbsStore& s) { s.faces[2].reversed = true; },
      [](NurbsStore& s) { s.faces[2].status = FaceStatus::kBadTrim; },
      [](NurbsStore& s) { s.surfaces[0].kind = SurfaceKind::kNone; },
      [](NurbsStore& s) { s.faces[2].uv_box = {}; }};
  for (std::size_t i = 0; i < damages.size(); ++i) {
    NurbsStore bad = good;
    damages[i](bad);
    EXPECT_THROW(validate(bad), FormatError) << "damage " << i;
    EXPECT_THROW(load_store(save_store(bad)), FormatError) << "damage " << i;
  }
}

TEST(MeshStore, fileKeepsEverything) {
  const NurbsStore store = store_in_groups(ball_mesh({1, 2, 3}, 2.0, 2), 17);
  const std::vector<std::byte> bytes = save_store(store);
  const NurbsStore again = load_store(bytes);
  EXPECT_EQ(save_store(again), bytes);
  EXPECT_EQ(again.mesh_vertices, store.mesh_vertices);
  EXPECT_EQ(again.mesh_triangles, store.mesh_triangles);
  EXPECT_EQ(again.faces[3].triangles.begin, 51);
  EXPECT_EQ(again.surfaces[0].kind, SurfaceKind::kMesh);
}

TEST(MeshStore, filesOfTheVersionBeforeAreRefused) {
  std::vector<std::byte> bytes = save_store(store_of(tetrahedron()));
  const std::uint32_t before = 1;
  std::memcpy(bytes.data() + 12, &before, sizeof before);
  reseal_store(bytes);
  EXPECT_THROW(load_store(bytes), FormatError);
}

TEST(MeshStore, boundsAreThoseOfTheCorners) {
  NurbsStore store = store_of(tetrahedron());
  store.instances.push_back(store.instances[0]);
  store.instances[1].placement.linear[0][0] = -3.0;  // mirrored and stretched
  store.instances[1].placement.translation = {0, 5, 0};
  const TrimIndex trims(store);
  const Box3 face = face_bounds(store, trims, 0);
  EXPECT_EQ(face.lower, dvec3(0.0));
  EXPECT_EQ(face.upper, dvec3(1.0));
  const Box3 model = model_bounds(store, trims);
  EXPECT_EQ(model.lower, dvec3(-3, 0, 0));
  EXPECT_EQ(model.upper, dvec3(1, 6, 1));
}

namespace {

// Every index that a merged store holds, less what stood before, is the one of the part.
void expect_part(const NurbsStore& merged, const NurbsStore& part, const NurbsStore& before) {
  const auto base = [](const auto& v) { return static_cast<std::int32_t>(v.size()); };
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    const Face &a = part.faces[f], &b = merged.faces[before.faces.size() + f];
    EXPECT_EQ(b.surface - base(before.surfaces), a.surface);
    EXPECT_EQ(b.prototype - base(before.prototypes), a.prototype);
    EXPECT_EQ(b.shell - base(before.shells), a.shell);
    EXPECT_EQ(b.loops.begin - base(before.loops), a.loops.begin);
    EXPECT_EQ(b.triangles.size(), a.triangles.size());
    EXPECT_EQ(b.shape, a.shape);
    EXPECT_EQ(std::memcmp(a.color, b.color, sizeof a.color), 0);
    for (std::int32_t t = 0; t < a.triangles.size(); ++t)
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(merged.mesh_vertices[merged.mesh_triangles[b.triangles.begin + t][c]],
                  part.mesh_vertices[part.mesh_triangles[a.triangles.begin + t][c]]);
  }
  for (std::size_t e = 0; e < part.edges.size(); ++e) {
    const Edge &a = part.edges[e], &b = merged.edges[before.edges.size() + e];
    EXPECT_EQ(merged.vertices[b.vertex[0]].point, part.vertices[a.vertex[0]].point);
    EXPECT_EQ(merged.edge_coedges[b.coedges.begin] - base(before.coedges),
              part.edge_coedges[a.coedges.begin]);
    for (std::int32_t p = 0; p < a.pieces.size(); ++p)
      EXPECT_EQ(merged.edge_ctrl_h[merged.edge_pieces[b.pieces.begin + p].ctrl.begin],
                part.edge_ctrl_h[part.edge_pieces[a.pieces.begin + p].ctrl.begin]);
  }
  for (std::size_t c = 0; c < part.coedges.size(); ++c)
    EXPECT_EQ(merged.trim_ctrl_h[merged.trim_pieces[merged.coedges[before.coedges.size() + c].pieces.begin]
                                     .ctrl.begin],
              part.trim_ctrl_h[part.trim_pieces[part.coedges[c].pieces.begin].ctrl.begin]);
  for (std::size_t s = 0; s < part.surfaces.size(); ++s) {
    const Surface &a = part.surfaces[s], &b = merged.surfaces[before.surfaces.size() + s];
    if (a.ctrl.size() > 0) {
      EXPECT_EQ(merged.ctrl_h[b.ctrl.begin], part.ctrl_h[a.ctrl.begin]);
    }
    if (a.knots_v.size() > 0) {
      EXPECT_EQ(merged.knots[b.knots_v.begin], part.knots[a.knots_v.begin]);
    }
  }
}

}  // namespace

TEST(MergeStores, keepsAllPartsInOrder) {
  const std::vector<FaceSpec> solids = {full_sphere({{1, 2, 3}}, 2.0), full_torus({}, 3.0, 1.0)};
  NurbsStore nurbs = make_store(solids);
  nurbs.instances.push_back(nurbs.instances[0]);
  nurbs.instances[1].placement.translation = {7, 8, 9};
  const NurbsStore mesh = store_in_groups(ball_mesh({}, 1.0, 2), 30);
  const NurbsStore* const parts[] = {&nurbs, &mesh, &nurbs};
  const NurbsStore merged = merge_stores(parts, "{\"models\": 3}");
  validate(merged);
  EXPECT_EQ(merged.meta, "{\"models\": 3}");
  EXPECT_EQ(merged.faces.size(), 2 * nurbs.faces.size() + mesh.faces.size());
  ASSERT_EQ(merged.instances.size(), 5u);
  EXPECT_EQ(merged.instances[2].prototype, 1);
  EXPECT_EQ(merged.instances[4].prototype, 2);
  EXPECT_EQ(merged.instances[4].placement.translation, dvec3(7, 8, 9));
  EXPECT_TRUE(merged.shells[static_cast<std::size_t>(merged.faces.back().shell)].closed);
  expect_part(merged, nurbs, NurbsStore{});
  expect_part(merged, mesh, nurbs);
  const NurbsStore* const first[] = {&nurbs, &mesh};
  expect_part(merged, nurbs, merge_stores(first, ""));
  EXPECT_EQ(save_store(load_store(save_store(merged))), save_store(merged));
}

TEST(MergeStores, ofOneIsThatOne) {
  const NurbsStore mesh = store_of(tetrahedron());
  const NurbsStore* const parts[] = {&mesh};
  EXPECT_EQ(save_store(merge_stores(parts, mesh.meta)), save_store(mesh));
  validate(merge_stores({}, ""));
}
