// The fast tracer and the reference say the same about solids that OpenCascade wrote.
#include <gtest/gtest.h>

#include <memory>

#include "core/brep/bintools.h"
#include "core/nurbs/build_store.h"
#include "core/nurbs/make_store.h"
#include "core/reference/reference.h"
#include "tests/core/brep/streams.h"
#include "tests/core/reference/agreement.h"

namespace trimray::reference_test {
namespace {

using trace::Hit;
using trace::Ray;

std::shared_ptr<const nurbs::NurbsStore> stream_store(const std::string& name) {
  const std::vector<std::byte> bytes = testing::read_stream(name);
  nurbs::BuildInput input;
  // Children stand first, so the root is the last shape.
  const brep::Model model = brep::parse_bintools(bytes);
  input.prototype_shapes = {static_cast<std::int32_t>(model.shapes.size())};
  input.prototype_colors = {-1, 0, 0, 1};
  input.instance_prototypes = {0};
  input.instance_placements = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  input.instance_colors = {-1, 0, 0, 1};
  input.meta = "{}";
  return std::make_shared<const nurbs::NurbsStore>(nurbs::build_store(bytes, input));
}

void expect_agreement(std::shared_ptr<const nurbs::NurbsStore> store, int rays_of_each) {
  const trace::Scene scene(store);
  const reference::Model model(*store, nullptr, 0);
  RayMaker maker(*store, 17);
  bool closed = true;
  for (const nurbs::Shell& shell : store->shells) closed = closed && shell.closed;
  int hits = 0;
  for (int k = 0; k < 3 * rays_of_each; ++k) {
    const Ray ray = k % 3 == 0 ? maker.random() : k % 3 == 1 ? maker.at_edge() : maker.at_silhouette();
    std::vector<Hit> fast;
    scene.cast_all(ray, fast);
    const std::vector<Hit> slow = model.hits(ray);
    const std::string text = difference(fast, slow, maker.diagonal);
    ASSERT_TRUE(text.empty()) << "ray " << k << "\n" << text;
    Hit first;
    scene.cast({&ray, 1}, {&first, 1});
    ASSERT_EQ(first.face == kNoFace, slow.empty()) << "ray " << k;
    if (!slow.empty()) {
      ASSERT_NEAR(first.t, slow.front().t, kHitTol * maker.diagonal) << "ray " << k;
    }
    if (closed) {
      ASSERT_EQ(slow.size() % 2, 0u) << "ray " << k;
    }
    hits += !slow.empty();
  }
  EXPECT_GT(hits, rays_of_each);
}

class AgreementOnStreams : public ::testing::TestWithParam<const char*> {};
TEST_P(AgreementOnStreams, holds) { expect_agreement(stream_store(GetParam()), 150); }
INSTANTIATE_TEST_SUITE_P(Streams, AgreementOnStreams,
                         ::testing::Values("box", "cylinder", "cone", "sphere", "torus", "rounded_box"));

// A leaf of a plain rectangle far from square: its corners were once given up.
TEST(Agreement, reachesTheCornersOfAnOffsetPlane) {
  const nurbs::FaceSpec spec{
      nurbs::as_offset(nurbs::make_bezier(1, 1, {{0, 0, 0, 1}, {0, 1, 0, 1}, {9, 0, 0, 1}, {9, 1, 0, 1}}),
                       2.0),
      {{0.0, 0.0}, {1.0, 1.0}}};
  const auto store = std::make_shared<const nurbs::NurbsStore>(
      nurbs::make_store(std::span<const nurbs::FaceSpec>(&spec, 1)));
  const trace::Scene scene(store);
  for (const dvec2 p :
       {dvec2(1e-5, 1e-5), dvec2(9 - 1e-5, 1e-5), dvec2(1e-5, 1 - 1e-5), dvec2(9 - 1e-5, 1 - 1e-5)}) {
    std::vector<Hit> fast, slow;
    const Ray ray{{p, 7.0}, {0, 0, -1}};
    scene.cast_all(ray, fast);
    reference::cast_all(*store, ray, slow);
    ASSERT_EQ(fast.size(), 1u);
    ASSERT_EQ(slow.size(), 1u);
    EXPECT_NEAR(fast[0].t, 5.0, 1e-12);
    EXPECT_NEAR(slow[0].t, 5.0, 1e-12);
  }
}

// A face whose box begins a few ulps before a knot: the sliver of a span between them is no place for roots.
TEST(Agreement, holdsWhereABoxBeginsARoundingBeforeAKnot) {
  nurbs::SurfaceForm form = nurbs::make_cylinder({}, 8.0);
  nurbs::set_closed_form_nurbs(form, {{-1.5, -10.0}, {1.5, 10.0}});
  form = nurbs::as_nurbs(form);
  ASSERT_EQ(form.knots_u[3], 0.0);
  const double lower = -3.6e-15;
  nurbs::respan_surface(form, {{lower, -10.0}, {1.5, 10.0}});
  EXPECT_GT(form.knots_u[3], 0.0);
  const nurbs::FaceSpec spec{form, {{lower, -5.0}, {1.4, 9.0}}};
  expect_agreement(std::make_shared<const nurbs::NurbsStore>(
                       nurbs::make_store(std::span<const nurbs::FaceSpec>(&spec, 1))),
                   100);
}

}  // namespace
}  // namespace trimray::reference_test
