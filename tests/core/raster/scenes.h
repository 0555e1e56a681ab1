// Stores, views of them, and the slow answer to what a pixel sees.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/nurbs/make_store.h"
#include "core/tess/mesh_levels.h"
#include "raster/rasterizer.h"
#include "tests/core/nurbs/meshes.h"

namespace trimray::raster::testing {

using nurbs::NurbsStore;
using view::Camera;

inline std::shared_ptr<NurbsStore> placed(NurbsStore store, const std::vector<Transform>& placements) {
  store.instances.clear();
  for (const Transform& t : placements) {
    store.instances.emplace_back().prototype = 0;
    store.instances.back().placement = t;
  }
  return std::make_shared<NurbsStore>(std::move(store));
}

inline Transform at(const dvec3& place, const dvec3& scale = dvec3(1.0)) {
  dmat3 linear(0.0);
  for (int k = 0; k < 3; ++k) linear[k][k] = scale[k];
  return {linear, place};
}

// Turned about an axis that is no coordinate axis.
inline Transform turned(const dvec3& place, double angle, double scale = 1.0) {
  const dvec3 a = glm::normalize(dvec3(1, 2, 3));
  const double c = std::cos(angle), s = std::sin(angle);
  dmat3 m;
  for (int k = 0; k < 3; ++k) {
    dvec3 e(0.0);
    e[k] = 1.0;
    m[k] = scale * (c * e + s * glm::cross(a, e) + (1.0 - c) * glm::dot(a, e) * a);
  }
  return {m, place};
}

// A ring and a ball: two faces, two shells.
inline NurbsStore ring_and_ball() {
  const nurbs::FaceSpec faces[] = {nurbs::full_torus({}, 2.0, 0.7),
                                   nurbs::full_sphere({.location = {0, 0, 0.4}}, 0.9)};
  return nurbs::make_store(faces);
}

// Looks at the origin from (1, -2, 1) or so.
inline Camera camera(int width, int height, double pixel, bool perspective = false) {
  Camera c = view::look(25.0, 20.0, view::UpAxis::kZ);
  c.width_px = width, c.height_px = height, c.pixel = pixel, c.perspective = perspective;
  c.eye = -12.0 * c.forward;
  return c;
}

struct Seen {
  std::int32_t instance = -1, face = -1;  // -1: nothing
  std::size_t entry = 0, triangle = 0;    // of the view, of its mesh
  double z = kInf;                        // along the view
  dvec2 fraction{0.0};                    // uv as fraction of the face's uv_box
  double slack = 0.0;                     // what a hundredth of a pixel changes in it
  bool operator==(const Seen& o) const { return instance == o.instance && face == o.face; }
};

// Every triangle against a ray, in double precision.
class SlowRaster {
 public:
  SlowRaster(const tess::ViewMeshes& meshes, const NurbsStore& store, const Camera& camera)
      : meshes_(meshes), store_(store), camera_(camera) {
    for (const tess::InstanceMesh& i : meshes.instances) {
      std::vector<dvec3> world;
      for (const dvec3& v : i.mesh->mesh.vertices)
        world.push_back(store.instances[i.instance].placement.point(v));
      vertices_.push_back(std::move(world));
    }
  }

  Seen at(double x_px, double y_px) const {
    const view::CameraRay ray = camera_.ray(x_px, y_px);
    Seen best;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const tess::TriMesh& mesh = meshes_.instances[i].mesh->mesh;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [ia, ib, ic] = mesh.triangles[t];
        const dvec3 a = vertices_[i][ia], ab = vertices_[i][ib] - a, ac = vertices_[i][ic] - a;
        const dvec3 p = glm::cross(ray.dir, ac);
        const double det = glm::dot(ab, p);
        const dvec3 s = ray.org - a, q = glm::cross(s, ab);
        const double u = glm::dot(s, p) / det, v = glm::dot(ray.dir, q) / det, z = glm::dot(ac, q) / det;
        if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && z > 0.0 && z < best.z)) continue;
        best.instance = meshes_.instances[i].instance, best.face = mesh.face[t];
        best.entry = i, best.triangle = t, best.z = z;
        best.fraction = fraction(mesh, t, u, v);
      }
    }
    return best;
  }

  // None where a hundredth of a pixel decides which surface it is, which triangle, or which side of a seam.
  std::optional<Seen> clear(int x, int y, SeedProcess process) const {
    Seen middle = at(x + 0.5, y + 0.5);
    for (const dvec2& d : {dvec2(-1, -1), dvec2(1, -1), dvec2(-1, 1), dvec2(1, 1)}) {
      const Seen beside = at(x + 0.5 + 0.01 * d.x, y + 0.5 + 0.01 * d.y);
      if (!(beside == middle)) return std::nullopt;
      if (process == SeedProcess::kId && beside.triangle != middle.triangle) return std::nullopt;
      for (int k = 0; k < 2; ++k)
        middle.slack = std::max(middle.slack, std::abs(beside.fraction[k] - middle.fraction[k]));
    }
    if (process == SeedProcess::kUv && middle.slack > 0.1) return std::nullopt;
    return middle;
  }

  dvec2 fraction(const tess::TriMesh& mesh, std::size_t t, double u, double v) const {
    const auto& c = mesh.corner_uv[t];
    const Box2& box = store_.faces[mesh.face[t]].uv_box;
    return ((1.0 - u - v) * c[0] + u * c[1] + v * c[2] - box.lower) / box.extent();
  }

 private:
  const tess::ViewMeshes& meshes_;
  const NurbsStore& store_;
  const Camera& camera_;
  std::vector<std::vector<dvec3>> vertices_;  // of the world
};

struct Difference {
  int compared = 0, covered = 0, unclear = 0, wrong = 0;
  double uv = 0.0;  // the largest, beyond what a hundredth of a pixel changes
};

// `samples` pixels of the buffers against the slow answer. kId: the target's uv against the triangle's mean,
// where it is the triangle that was hit.
inline Difference compare(const SeedBuffers& b, const SlowRaster& slow, const tess::ViewMeshes& meshes,
                          int samples, unsigned seed = 1) {
  Difference d;
  std::mt19937 random(seed);
  for (int k = 0; k < samples; ++k) {
    const int x = static_cast<int>(random() % static_cast<unsigned>(b.width_px));
    const int y = static_cast<int>(random() % static_cast<unsigned>(b.height_px));
    const std::optional<Seen> seen = slow.clear(x, y, b.process);
    if (!seen) {
      ++d.unclear;
      continue;
    }
    ++d.compared, d.covered += seen->instance >= 0;
    const std::size_t pixel = static_cast<std::size_t>(y) * b.width_px + x;
    if (b.id[pixel] == 0) {
      d.wrong += seen->instance >= 0;
      continue;
    }
    if (b.id[pixel] > b.targets.size()) {
      ++d.wrong;
      continue;
    }
    const SeedTarget& target = b.targets[b.id[pixel] - 1];
    if (target.instance != seen->instance || target.face != seen->face) {
      ++d.wrong;
      continue;
    }
    dvec2 got(target.u, target.v), expected = seen->fraction;
    if (b.process == SeedProcess::kUv) {
      got = {b.uv[2 * pixel], b.uv[2 * pixel + 1]};
    } else {
      expected = slow.fraction(meshes.instances[seen->entry].mesh->mesh, seen->triangle, 1.0 / 3, 1.0 / 3);
    }
    const double slack = b.process == SeedProcess::kUv ? seen->slack : 0.0;
    d.uv = std::max({d.uv, std::abs(got.x - expected.x) - slack, std::abs(got.y - expected.y) - slack});
  }
  return d;
}

// Tests that run on every backend of this machine.
class EachBackend : public ::testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    std::string why_not;
    if (!available(GetParam(), &why_not)) GTEST_SKIP() << backend_name(GetParam()) << ": " << why_not;
    rasterizer = make_rasterizer(GetParam());
  }
  std::unique_ptr<Rasterizer> rasterizer;
};

inline std::string backend_test_name(const ::testing::TestParamInfo<Backend>& info) {
  return backend_name(info.param);
}

}  // namespace trimray::raster::testing
