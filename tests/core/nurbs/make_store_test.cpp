// The stores that programs make: sound, closed where they must be.
#include "core/nurbs/make_store.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"

using namespace trimray;
using namespace trimray::nurbs;

TEST(MakeStore, singleFacesAreValidAndClosedWhereTheyWrap) {
  const FaceSpec plane{make_plane({}), {{-1, -2}, {3, 4}}};
  const std::vector<std::pair<FaceSpec, bool>> cases = {{full_sphere({}, 2.0), true},
                                                        {full_torus({}, 3.0, 1.0), true},
                                                        {tube({}, 2.0, -1.0, 5.0), false},
                                                        {plane, false}};
  for (const auto& [spec, closed] : cases) {
    const NurbsStore store = make_store({&spec, 1});
    validate(store);
    ASSERT_EQ(store.shells.size(), 1u);
    EXPECT_EQ(store.shells[0].closed, closed);
    const Face& face = store.faces[0];
    ASSERT_EQ(face.loops.size(), 1);
    const Range c = store.loops[0].coedges;
    ASSERT_EQ(c.size(), 4);
    for (int i = 0; i < 4; ++i) {  // closed in uv
      const CurvePiece& here = store.trim_pieces[store.coedges[c.begin + i].pieces.begin];
      const CurvePiece& next = store.trim_pieces[store.coedges[c.begin + (i + 1) % 4].pieces.begin];
      EXPECT_EQ(store.trim_ctrl_h[here.ctrl.end - 1], store.trim_ctrl_h[next.ctrl.begin]);
    }
  }
}

TEST(MakeStore, sphereHasSeamAndTwoPoles) {
  const FaceSpec spec = full_sphere({{1, 2, 3}}, 2.0);
  const NurbsStore store = make_store({&spec, 1});
  int degenerate = 0, seam = 0;
  for (const Edge& e : store.edges) degenerate += e.degenerate;
  for (const CoEdge& c : store.coedges) seam += c.seam;
  EXPECT_EQ(degenerate, 2);
  EXPECT_EQ(seam, 2);
  EXPECT_EQ(store.vertices.size(), 2u);
  // The hull of a rational arc reaches beyond the sphere, but not by much more than its corner.
  EXPECT_LE(store.prototypes[0].bounds.upper.z, 3 + 2.0 * 1.6);
  EXPECT_GE(store.prototypes[0].bounds.upper.z, 3 + 2.0);
}

TEST(MakeStore, validateRefusesBrokenIndices) {
  const FaceSpec spec = full_sphere({}, 2.0);
  const NurbsStore good = make_store({&spec, 1});
  NurbsStore bad = good;
  bad.faces[0].surface = 7;
  EXPECT_THROW(validate(bad), FormatError);
  bad = good;
  bad.knots[3] = 99.0;
  EXPECT_THROW(validate(bad), FormatError);
  bad = good;
  bad.ctrl_h[0].w = 0.0;
  EXPECT_THROW(validate(bad), FormatError);
  bad = good;
  bad.coedges[0].pieces.end = 1000;
  EXPECT_THROW(validate(bad), FormatError);
}
