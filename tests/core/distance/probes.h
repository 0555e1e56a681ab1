// Random points, brute-force distances, and what every answer must keep to.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "core/distance/point_index.h"
#include "core/nurbs/make_store.h"
#include "core/nurbs/spline.h"
#include "core/nurbs/surface.h"
#include "core/nurbs/trim.h"

namespace trimray::distance {

inline std::shared_ptr<const nurbs::NurbsStore> shared(nurbs::NurbsStore store) {
  return std::make_shared<const nurbs::NurbsStore>(std::move(store));
}

inline std::vector<dvec3> random_points(std::size_t count, const dvec3& middle, double half,
                                        unsigned seed = 1) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-half, half);
  std::vector<dvec3> points(count);
  for (dvec3& p : points) {
    p.x = middle.x + unit(random);
    p.y = middle.y + unit(random);
    p.z = middle.z + unit(random);
  }
  return points;
}

// Points of the model on a grid of each face and on its edges, and how far the next grid point is: the least
// distance among them is an upper bound, and less the spacing a lower one.
struct Cloud {
  std::vector<dvec3> points;
  double spacing = 0.0;
  double distance(const dvec3& p) const {
    double least = kInf;
    for (const dvec3& q : points) least = std::min(least, glm::distance(p, q));
    return least;
  }
};

inline dvec3 path_point(const nurbs::NurbsStore& store, std::int32_t piece, double t) {
  const nurbs::Range& r = store.edge_pieces[piece].ctrl;
  return nurbs::project(nurbs::bezier_point(store.edge_ctrl_h.data() + r.begin, r.size() - 1, t));
}

// Of one-instance models without placement.
inline Cloud make_cloud(const nurbs::NurbsStore& store, int steps) {
  Cloud cloud;
  const nurbs::TrimIndex trims(store);
  for (std::size_t f = 0; f < store.faces.size(); ++f) {
    const nurbs::Face& face = store.faces[f];
    if (face.status != nurbs::FaceStatus::kOk || face.is_mesh()) continue;
    const dvec2 step = face.uv_box.extent() / double(steps);
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; j <= steps; ++j) {
        const dvec2 uv = face.uv_box.lower + dvec2(i, j) * step;
        const nurbs::SurfacePoint s = nurbs::evaluate(store, store.surfaces[face.surface], uv);
        cloud.spacing = std::max(cloud.spacing, glm::length(s.du) * step.x + glm::length(s.dv) * step.y);
        if (face.iso_rectangle || trims.inside(static_cast<std::int32_t>(f), uv)) cloud.points.push_back(s.p);
      }
  }
  for (std::size_t piece = 0; piece < store.edge_pieces.size(); ++piece)
    for (int i = 0; i <= 4 * steps; ++i)
      cloud.points.push_back(path_point(store, static_cast<std::int32_t>(piece), i / (4.0 * steps)));
  return cloud;
}

// What an answer claims of itself: its point is as far as it says, lies on its face at its uv, inside of the
// loops or on the edge it names.
inline void expect_sound(const nurbs::NurbsStore& store, const nurbs::TrimIndex& trims, const dvec3& query,
                         const Nearest& n, double diagonal, double band = 1e-6) {
  ASSERT_GE(n.face, 0);
  ASSERT_GE(n.instance, 0);
  EXPECT_NEAR(glm::distance(query, n.point), n.distance, 1e-12 * (diagonal + n.distance));
  EXPECT_EQ(n.gap, 0.0);
  const nurbs::Face& face = store.faces[n.face];
  if (face.is_mesh()) return;
  const dvec3 on_surface = store.instances[n.instance].placement.point(
      nurbs::evaluate(store, store.surfaces[face.surface], n.uv_face).p);
  if (n.edge < 0) {
    EXPECT_LE(glm::distance(on_surface, n.point), 1e-11 * diagonal);
    EXPECT_TRUE(face.iso_rectangle ? face.uv_box.contains(n.uv_face) : trims.inside(n.face, n.uv_face));
  } else {
    EXPECT_LE(glm::distance(on_surface, n.point), band);
  }
}

// All of that, and between the bounds that a dense cloud of the model's points gives.
inline void expect_between_bounds(const nurbs::NurbsStore& store, const std::vector<dvec3>& queries,
                                  int steps) {
  const auto kept = shared(store);
  const PointIndex index(kept);
  EXPECT_TRUE(index.left_out().empty());
  const nurbs::TrimIndex trims(*kept);
  const Cloud cloud = make_cloud(*kept, steps);
  double band = 0.0;
  for (const nurbs::Edge& e : kept->edges) band = std::max(band, e.band);
  std::vector<Nearest> found(queries.size());
  index.nearest(queries, found, 2);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    SCOPED_TRACE(i);
    const double upper = cloud.distance(queries[i]);
    // A face ends at its edges' paths, the cloud at its p-curves: they are within the band.
    EXPECT_LE(found[i].distance, upper + band + 1e-12 * index.diagonal());
    EXPECT_GE(found[i].distance, upper - cloud.spacing - band);
    expect_sound(*kept, trims, queries[i], found[i], index.diagonal(), band + 1e-12 * index.diagonal());
    if (testing::Test::HasFatalFailure()) return;
  }
}

}  // namespace trimray::distance
