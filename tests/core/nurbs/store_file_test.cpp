// The store's file: what is saved comes back, and no damage gets through.
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/nurbs/make_store.h"

using namespace trimray;
using namespace trimray::nurbs;

namespace {

NurbsStore sample() {
  const std::vector<FaceSpec> faces = {
      full_sphere({{1, 2, 3}}, 2.0),
      full_torus({}, 3.0, 1.0),
      {as_offset(as_nurbs(make_cylinder({}, 2.0)), 0.25), {{0.5, -1}, {1.5, 4}}, true}};
  NurbsStore store = make_store(faces);
  store.faces[1].color[0] = 0.25f;
  store.meta = "{\"name\": \"M2X10\xe6\x9d\xaf\"}";
  store.instances.push_back(store.instances[0]);
  store.instances[1].placement.translation = {7, 8, 9};
  return store;
}

}  // namespace

TEST(StoreFile, roundTripKeepsEverything) {
  const NurbsStore store = sample();
  const std::vector<std::byte> bytes = save_store(store);
  const NurbsStore again = load_store(bytes);
  EXPECT_EQ(save_store(again), bytes);
  EXPECT_EQ(again.ctrl_h, store.ctrl_h);
  EXPECT_EQ(again.knots, store.knots);
  EXPECT_EQ(again.trim_ctrl_h, store.trim_ctrl_h);
  EXPECT_EQ(again.edge_ctrl_h, store.edge_ctrl_h);
  EXPECT_EQ(again.edge_coedges, store.edge_coedges);
  EXPECT_EQ(again.meta, store.meta);
  ASSERT_EQ(again.faces.size(), store.faces.size());
  EXPECT_TRUE(again.faces[2].reversed);
  EXPECT_EQ(again.faces[1].color[0], 0.25f);
  EXPECT_EQ(again.surfaces[2].kind, SurfaceKind::kOffset);
  EXPECT_EQ(again.surfaces[2].offset, 0.25);
  EXPECT_EQ(again.instances[1].placement.translation, dvec3(7, 8, 9));
  EXPECT_EQ(again.edges[0].band, store.edges[0].band);
}

TEST(StoreFile, everyDamagedByteIsRefused) {
  const FaceSpec spec = full_sphere({}, 2.0);
  const std::vector<std::byte> good = save_store(make_store({&spec, 1}));
  for (std::size_t i = 0; i < good.size(); ++i)
    for (const std::byte flip : {std::byte{0x01}, std::byte{0x80}}) {
      std::vector<std::byte> bad = good;
      bad[i] ^= flip;
      EXPECT_THROW(load_store(bad), FormatError) << "byte " << i;
    }
}

TEST(StoreFile, everyTruncationIsRefused) {
  const FaceSpec spec = full_sphere({}, 2.0);
  const std::vector<std::byte> good = save_store(make_store({&spec, 1}));
  for (std::size_t n = 0; n < good.size(); ++n)
    EXPECT_THROW(load_store(std::span(good).first(n)), FormatError) << n << " bytes";
  std::vector<std::byte> longer = good;
  longer.push_back(std::byte{0});
  EXPECT_THROW(load_store(longer), FormatError);
}
