// build_store over streams written by OpenCascade and over models made by hand.
#include "core/nurbs/build_store.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/brep/bintools.h"
#include "tests/core/nurbs/store_invariants.h"

using namespace trimray;
using namespace trimray::nurbs;

namespace {

std::vector<std::byte> stream(const std::string& name) {
  const auto path = std::filesystem::path(__FILE__).parent_path().parent_path() / "brep" / "data" / name;
  std::ifstream file(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::vector<std::byte> out(bytes.size());
  std::transform(bytes.begin(), bytes.end(), out.begin(), [](char c) { return static_cast<std::byte>(c); });
  return out;
}

BuildInput input_for(std::int32_t root) {
  BuildInput in;
  in.prototype_shapes = {root};
  in.prototype_colors = {-1, 0, 0, 1};
  in.instance_prototypes = {0};
  in.instance_placements = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  in.instance_colors = {-1, 0, 0, 1};
  return in;
}

NurbsStore build_last(const std::string& name) {
  const brep::Model model = brep::parse_bintools(stream(name));
  return build_store(model, input_for(static_cast<std::int32_t>(model.shapes.size())));
}

void expect_sound(const NurbsStore& store) {
  validate(store);
  const invariants::Findings f = invariants::check(store, 20, 7);
  EXPECT_EQ(f.loops_open, 0);
  EXPECT_EQ(f.points_outside, 0);
  EXPECT_EQ(f.negative_areas, 0);
}

}  // namespace

TEST(BuildStore, solidsOfTheStreamsAreClosed) {
  const std::vector<std::pair<const char*, std::size_t>> solids = {{"box.bin", 6},   {"cylinder.bin", 3},
                                                                   {"cone.bin", 2},  {"sphere.bin", 1},
                                                                   {"torus.bin", 1}, {"rounded_box.bin", 7}};
  for (const auto& [name, faces] : solids) {
    const NurbsStore store = build_last(name);
    ASSERT_EQ(store.faces.size(), faces) << name;
    for (const Face& f : store.faces) EXPECT_EQ(f.status, FaceStatus::kOk) << name;
    ASSERT_EQ(store.shells.size(), 1u) << name;
    EXPECT_TRUE(store.shells[0].closed) << name;
    expect_sound(store);
  }
}

TEST(BuildStore, inputThatDoesNotFitIsAnArgumentError) {
  const brep::Model model = brep::parse_bintools(stream("box.bin"));
  BuildInput in = input_for(static_cast<std::int32_t>(model.shapes.size()) + 1);
  EXPECT_THROW(build_store(model, in), ArgumentError);
  in = input_for(1);
  in.instance_placements.pop_back();
  EXPECT_THROW(build_store(model, in), ArgumentError);
  in = input_for(1);
  in.instance_prototypes[0] = 1;
  EXPECT_THROW(build_store(model, in), ArgumentError);
}
