// One damaged face costs itself only: it is refused with a reason, its neighbours are drawn.
#include "core/nurbs/face_guards.h"

#include <array>

#include <gtest/gtest.h>

#include "core/nurbs/build_store.h"

using namespace trimray;
using namespace trimray::nurbs;

namespace {

// Separate four-sided faces of one prototype, with straight edges and straight p-curves.
class Faces {
 public:
  // corners: in space; uv: of the p-curves' corners on the surface. Both run to the left around the face.
  void add(const brep::Surface& surface, const std::array<dvec3, 4>& corners,
           const std::array<dvec2, 4>& uv) {
    model_.surfaces.push_back(surface);
    brep::Shape wire{brep::ShapeKind::kWire, -1, true, {}};
    std::array<std::int32_t, 4> vertices{};
    for (int i = 0; i < 4; ++i) {
      model_.vertices.push_back({corners[i], 1e-7});
      vertices[i] = push({brep::ShapeKind::kVertex, last(model_.vertices), false, {}});
    }
    for (int i = 0; i < 4; ++i) {
      const int j = (i + 1) % 4;
      const double length = glm::distance(corners[i], corners[j]);
      brep::Curve3 c;
      c.kind = brep::CurveKind::kLine, c.location = corners[i], c.x_axis = (corners[j] - corners[i]) / length;
      model_.curves3.push_back(c);
      brep::Curve2 p;
      p.kind = brep::CurveKind::kLine, p.location = uv[i], p.x_axis = (uv[j] - uv[i]) / length;
      model_.curves2.push_back(p);
      brep::EdgeData e;
      e.tolerance = 1e-7, e.curve3 = last(model_.curves3), e.first = 0.0, e.last = length;
      e.pcurves.push_back({last(model_.curves2), -1, last(model_.surfaces), -1, 0.0, length});
      model_.edges.push_back(e);
      brep::Shape s{brep::ShapeKind::kEdge, last(model_.edges), false, {}};
      s.children.push_back({vertices[i], brep::Orientation::kForward, -1});
      s.children.push_back({vertices[j], brep::Orientation::kReversed, -1});
      wire.children.push_back({push(s), brep::Orientation::kForward, -1});
    }
    model_.faces.push_back({last(model_.surfaces), -1, 1e-7, false, false});
    brep::Shape f{brep::ShapeKind::kFace, last(model_.faces), false, {}};
    f.children.push_back({push(wire), brep::Orientation::kForward, -1});
    faces_.push_back(push(f));
  }

  NurbsStore build() {
    brep::Shape all{brep::ShapeKind::kCompound, -1, false, {}};
    for (const std::int32_t f : faces_) all.children.push_back({f, brep::Orientation::kForward, -1});
    BuildInput in;
    in.prototype_shapes = {push(all) + 1};
    in.prototype_colors = {-1, 0, 0, 1};
    NurbsStore store = build_store(model_, in);
    validate(store);
    return store;
  }

 private:
  template <typename T>
  static std::int32_t last(const std::vector<T>& array) {
    return static_cast<std::int32_t>(array.size()) - 1;
  }
  std::int32_t push(const brep::Shape& s) {
    model_.shapes.push_back(s);
    return last(model_.shapes);
  }

  brep::Model model_;
  std::vector<std::int32_t> faces_;
};

brep::Surface plane() {
  brep::Surface s;
  s.kind = brep::SurfaceKind::kPlane;
  s.x_axis = {1, 0, 0}, s.y_axis = {0, 1, 0}, s.z_axis = {0, 0, 1};
  return s;
}

// z = height(x) over [0, 10]^2, one Bezier patch of that degree in u with control points over equidistant x.
brep::Surface sheet(const std::vector<double>& heights) {
  brep::Surface s;
  s.kind = brep::SurfaceKind::kBezier;
  s.count_u = static_cast<std::int32_t>(heights.size()), s.count_v = 2;
  for (std::size_t i = 0; i < heights.size(); ++i)
    for (const double y : {0.0, 10.0})
      s.poles.emplace_back(10.0 * double(i) / double(heights.size() - 1), y, heights[i]);
  return s;
}

std::array<dvec3, 4> square(double size) {
  return {{{0, 0, 0}, {size, 0, 0}, {size, size, 0}, {0, size, 0}}};
}
constexpr std::array<dvec2, 4> kUnit = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
constexpr std::array<dvec2, 4> kTen = {{{0, 0}, {10, 0}, {10, 10}, {0, 10}}};

}  // namespace

TEST(FaceGuards, surfaceFarOffIsRefusedAndDoesNotGrowTheModel) {
  Faces f;
  f.add(plane(), square(10.0), kTen);
  f.add(sheet({0.0, 1e9, 0.0}), square(10.0), kUnit);  // its edges are where those of the first face are
  const NurbsStore store = f.build();
  EXPECT_EQ(store.faces[0].status, FaceStatus::kOk);
  EXPECT_EQ(store.faces[1].status, FaceStatus::kBadSurface);
  EXPECT_LT(store.prototypes[0].bounds.diagonal(), 20.0);
  for (const Edge& e : store.edges) EXPECT_LT(e.band, 1e-6);
}

TEST(FaceGuards, pCurvesOffTheirEdgesAreRefused) {
  const auto status = [](double shift) {
    Faces f;
    f.add(plane(), square(10.0), kTen);
    std::array<dvec2, 4> uv = kTen;
    for (dvec2& p : uv) p.x += shift;
    f.add(plane(), square(10.0), uv);
    const NurbsStore store = f.build();
    EXPECT_EQ(store.faces[0].status, FaceStatus::kOk);
    return store.faces[1].status;
  };
  // A tenth of the face's own diagonal of 14.14 is too much.
  EXPECT_EQ(status(0.1), FaceStatus::kOk);
  EXPECT_EQ(status(1.4), FaceStatus::kOk);
  EXPECT_EQ(status(1.45), FaceStatus::kBadTrim);
  EXPECT_EQ(status(7.0), FaceStatus::kBadTrim);
  EXPECT_EQ(status(1e8), FaceStatus::kBadSurface);  // the plane is cut from where nothing of the model is
}

TEST(FaceGuards, tinyFaceOfACoarseModelIsKept) {
  Faces f;
  f.add(plane(), square(100.0), {{{0, 0}, {100, 0}, {100, 100}, {0, 100}}});
  f.add(plane(), square(0.01), {{{0.005, 0}, {0.015, 0}, {0.015, 0.01}, {0.005, 0.01}}});
  const NurbsStore store = f.build();
  EXPECT_EQ(store.faces[1].status, FaceStatus::kOk);
}

TEST(FaceGuards, marginOfAHighDegreeStaysByTheSurface) {
  // Degree 24, control points zigzagging by a millimetre: continued by 5 % they would reach kilometres.
  std::vector<double> zigzag;
  for (int i = 0; i <= 24; ++i) zigzag.push_back(i == 0 || i == 24 ? 0.0 : i % 2 ? 1.0 : -1.0);
  Faces f;
  f.add(sheet(zigzag), square(10.0), kUnit);
  const NurbsStore store = f.build();
  ASSERT_EQ(store.faces[0].status, FaceStatus::kOk);
  const Surface& s = store.surfaces[store.faces[0].surface];
  EXPECT_LT(s.domain.lower.x, 0.0);  // there is a margin
  EXPECT_GT(s.domain.upper.x, 1.0);
  double highest = 0.0;
  for (std::int32_t i = s.ctrl.begin; i < s.ctrl.end; ++i)
    highest = std::max(highest, std::abs(store.ctrl_h[i].z / store.ctrl_h[i].w));
  EXPECT_LT(highest, 3.0);
}

TEST(FaceGuards, loopsThatLeaveAHighDegreeSurfaceAreBadTrim) {
  std::vector<double> zigzag;
  for (int i = 0; i <= 24; ++i) zigzag.push_back(i == 0 || i == 24 ? 0.0 : i % 2 ? 1.0 : -1.0);
  Faces f;
  f.add(sheet(zigzag), square(10.0), {{{0, 0}, {1.4, 0}, {1.4, 1}, {0, 1}}});
  EXPECT_EQ(f.build().faces[0].status, FaceStatus::kBadTrim);
  // A straight sheet goes on as far as its loops ask.
  Faces straight;
  straight.add(sheet({0.0, 0.0}), {{{0, 0, 0}, {14, 0, 0}, {14, 10, 0}, {0, 10, 0}}},
               {{{0, 0}, {1.4, 0}, {1.4, 1}, {0, 1}}});
  EXPECT_EQ(straight.build().faces[0].status, FaceStatus::kOk);
}
