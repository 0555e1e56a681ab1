// The edge rule on solids that OpenCascade wrote.
#include "core/brep/bintools.h"
#include "core/nurbs/build_store.h"
#include "tests/core/brep/streams.h"
#include "tests/core/trace/edge_rule_solid.h"

namespace trimray::trace {
namespace {

nurbs::NurbsStore store_of(const std::string& name) {
  const std::vector<std::byte> bytes = testing::read_stream(name);
  const brep::Model model = brep::parse_bintools(bytes);
  nurbs::BuildInput in;
  in.prototype_shapes = {static_cast<std::int32_t>(model.shapes.size())};
  in.prototype_colors = {-1, 0, 0, 1};
  in.instance_prototypes = {0};
  in.instance_placements = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  in.instance_colors = {-1, 0, 0, 1};
  return nurbs::build_store(model, in);
}

TEST(EdgeRuleStreams, SolidsAreEven) {
  for (const char* name : {"box", "cylinder", "cone", "sphere", "rounded_box"}) {
    SCOPED_TRACE(name);
    const Solid solid(store_of(name));
    expect_even(solid, 20000, 1, {0, 2});
  }
}

}  // namespace
}  // namespace trimray::trace
