// Faces that the B-rep gives as triangles, on their way into the store.
#include "core/nurbs/build_mesh_face.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/brep/bintools.h"
#include "core/nurbs/build_store.h"
#include "tests/core/brep/streams.h"
#include "tests/core/nurbs/meshes.h"

using namespace trimray;
using namespace trimray::nurbs;
using brep::Orientation;

namespace {

BuildInput input_for(const brep::Model& model) {
  BuildInput in;
  in.prototype_shapes = {static_cast<std::int32_t>(model.shapes.size())};
  in.prototype_colors = {-1, 0, 0, 1};
  in.instance_prototypes = {0};
  in.instance_placements = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  in.instance_colors = {-1, 0, 0, 1};
  return in;
}

// A tetrahedron as a solid: each face has one triangle and nodes of its own.
brep::Model solid() {
  brep::Model model;
  const trimray::testing::TestMesh mesh = trimray::testing::tetrahedron();
  brep::Shape shell{brep::ShapeKind::kShell, -1, true, {}};
  for (std::int32_t i = 0; i < 4; ++i) {
    brep::Mesh& face = model.meshes.emplace_back();
    for (const std::int32_t v : mesh.triangles[i]) face.nodes.push_back(mesh.vertices[v]);
    face.triangles = {{0, 1, 2}};
    model.faces.emplace_back().mesh = i;
    model.shapes.push_back({brep::ShapeKind::kFace, i, false, {}});
    shell.children.push_back({i, Orientation::kForward, -1});
  }
  model.shapes.push_back(shell);
  model.shapes.push_back({brep::ShapeKind::kSolid, -1, false, {{4, Orientation::kForward, -1}}});
  return model;
}

double volume(const NurbsStore& store) {
  double six = 0.0;
  for (const Triangle& t : store.mesh_triangles)
    six +=
        glm::dot(store.mesh_vertices[t[0]], glm::cross(store.mesh_vertices[t[1]], store.mesh_vertices[t[2]]));
  return six / 6.0;
}

}  // namespace

TEST(BuildMeshFace, facesOfAStreamAreDrawnAndColoured) {
  const brep::Model model = brep::parse_bintools(trimray::testing::read_stream("mesh_face"));
  BuildInput in = input_for(model);
  in.face_color_shapes = {static_cast<std::int32_t>(model.shapes.size())};
  in.face_colors = {0.25f, 0.5f, 0.75f, 1.0f};
  const NurbsStore store = build_store(model, in);
  validate(store);
  ASSERT_EQ(store.faces.size(), 1u);
  EXPECT_EQ(store.faces[0].status, FaceStatus::kOk);
  EXPECT_STREQ(kind_name(store.surfaces[store.faces[0].surface].kind), "mesh");
  EXPECT_EQ(store.faces[0].color[1], 0.5f);
  EXPECT_EQ(store.mesh_vertices, (std::vector<dvec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(store.mesh_triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(store.prototypes[0].bounds.upper, dvec3(1, 1, 0));
}

TEST(BuildMeshFace, facesWithSurfaceStayExact) {
  const brep::Model model = brep::parse_bintools(trimray::testing::read_stream("meshes"));
  const NurbsStore store = build_store(model, input_for(model));
  validate(store);
  int exact = 0, mesh = 0;
  for (const Face& f : store.faces) (f.is_mesh() ? mesh : exact) += f.status == FaceStatus::kOk;
  EXPECT_EQ(exact, 3);
  EXPECT_EQ(mesh, 1);
}

TEST(BuildMeshFace, solidsAreClosed) {
  const NurbsStore store = build_store(solid(), input_for(solid()));
  validate(store);
  ASSERT_EQ(store.shells.size(), 1u);
  EXPECT_TRUE(store.shells[0].closed);
  EXPECT_DOUBLE_EQ(volume(store), 1.0 / 6.0);
  brep::Model open = solid();
  open.shapes[4].children.pop_back();
  EXPECT_FALSE(build_store(open, input_for(open)).shells[0].closed);
}

TEST(BuildMeshFace, orientationAndPlacesTurnTriangles) {
  brep::Model model = solid();  // reversed faces whose triangles run the other way
  for (std::size_t i = 0; i < 4; ++i) {
    model.shapes[4].children[i].orientation = Orientation::kReversed;
    std::swap(model.meshes[i].triangles[0][0], model.meshes[i].triangles[0][1]);
  }
  EXPECT_DOUBLE_EQ(volume(build_store(model, input_for(model))), 1.0 / 6.0);

  model = solid();  // a mirrored shell, moved and twice as large
  model.locations.push_back({dmat3(dvec3(-2, 0, 0), dvec3(0, 2, 0), dvec3(0, 0, 2)), {5, 6, 7}});
  model.shapes[5].children[0].location = 0;
  const NurbsStore store = build_store(model, input_for(model));
  EXPECT_DOUBLE_EQ(volume(store), 8.0 / 6.0);
  EXPECT_EQ(store.prototypes[0].bounds.lower, dvec3(3, 6, 7));
  EXPECT_EQ(store.prototypes[0].bounds.upper, dvec3(5, 8, 9));

  model = solid();  // a place that the face's own data gives
  model.locations.push_back({dmat3(1.0), {5, 6, 7}});
  for (brep::FaceData& face : model.faces) face.location = 0;
  EXPECT_EQ(build_store(model, input_for(model)).prototypes[0].bounds.lower, dvec3(5, 6, 7));
}

TEST(BuildMeshFace, normalsTellTheOutside) {
  brep::Model model = solid();
  for (brep::Mesh& mesh : model.meshes) {
    const dvec3 n = glm::cross(mesh.nodes[1] - mesh.nodes[0], mesh.nodes[2] - mesh.nodes[0]);
    mesh.normals.assign(3, glm::vec3(glm::normalize(n)));
  }
  EXPECT_DOUBLE_EQ(volume(build_store(model, input_for(model))), 1.0 / 6.0);
  for (brep::Mesh& mesh : model.meshes) std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  EXPECT_DOUBLE_EQ(volume(build_store(model, input_for(model))), 1.0 / 6.0);
  for (brep::Mesh& mesh : model.meshes) mesh.normals.assign(3, glm::vec3(std::nanf("")));
  EXPECT_DOUBLE_EQ(volume(build_store(model, input_for(model))), -1.0 / 6.0);
}

TEST(BuildMeshFace, badNodesRefuseTheFaceAlone) {
  for (const double x : {kNaN, kInf, 1e13}) {
    brep::Model model = solid();
    model.meshes[2].nodes[1].y = x;
    const NurbsStore store = build_store(model, input_for(model));
    validate(store);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_EQ(store.faces[i].status, i == 2 ? FaceStatus::kBadSurface : FaceStatus::kOk) << x;
    EXPECT_FALSE(store.shells[0].closed);
  }
  brep::Model empty = solid();
  empty.meshes[2].triangles.clear();
  EXPECT_EQ(build_store(empty, input_for(empty)).faces[2].status, FaceStatus::kNoSurface);
}

// One triangulation of a million triangles used a hundred and one times.
TEST(BuildMeshFace, tooManyTrianglesAreRefused) {
  brep::Model model = solid();
  model.meshes[0].triangles.assign(1'000'000, {0, 1, 2});
  brep::Shape compound{brep::ShapeKind::kCompound, -1, false, {}};
  compound.children.assign(101, {5, Orientation::kForward, -1});
  model.shapes.push_back(compound);
  EXPECT_THROW(build_store(model, input_for(model)), FormatError);
}
