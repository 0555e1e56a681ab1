#include "tests/bench/embree_mesh.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/box.h"
#include "core/nurbs/surface.h"

namespace bench {

using namespace trimray;

namespace {

struct Corners {
  dvec2 uv[3];
  glm::vec3 normal[3];  // world, outward
};

struct Part {
  std::int32_t instance;
  std::shared_ptr<const tess::Tessellation> mesh;
  std::vector<Corners> corners;  // by triangle
};

// Outward, in the prototype; flat: of the triangle, where the surface has none.
dvec3 normal_at(const nurbs::NurbsStore& store, const nurbs::Face& face, dvec2 uv, const dvec3& flat) {
  if (face.surface < 0) return flat;
  const nurbs::SurfacePoint p = nurbs::evaluate(store, store.surfaces[face.surface], uv);
  const dvec3 n = glm::cross(p.du, p.dv);
  const double length = glm::length(n);
  if (!(length > 1e-12 * glm::length(p.du) * glm::length(p.dv))) return flat;
  return face.reversed ? -n / length : n / length;
}

}  // namespace

struct EmbreeMesh::Impl {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  Box3 bounds;
  std::vector<Part> parts;  // by geometry

  ~Impl() { rtcReleaseScene(scene), rtcReleaseDevice(device); }

  void add(const tess::InstanceMesh& source, const nurbs::NurbsStore& store) {
    const tess::TriMesh& mesh = source.mesh->mesh;
    const Transform& placement = store.instances[source.instance].placement;
    const dmat3 normal_matrix = glm::transpose(glm::inverse(placement.linear));
    Part part{source.instance, source.mesh, {}};
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* place = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                              RTC_FORMAT_FLOAT3, 12, mesh.vertices.size()));
    auto* index = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const dvec3 p = placement.point(mesh.vertices[v]) - bounds.center();
      for (int c = 0; c < 3; ++c) place[3 * v + c] = static_cast<float>(p[c]);
    }
    part.corners.resize(mesh.triangles.size());
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
      const auto& t = mesh.triangles[k];
      const dvec3 across =
          glm::cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]);
      const dvec3 flat = across / std::max(glm::length(across), 1e-300);
      for (int c = 0; c < 3; ++c) {
        index[3 * k + c] = static_cast<unsigned>(t[c]);
        part.corners[k].uv[c] = mesh.corner_uv[k][c];
        part.corners[k].normal[c] = glm::vec3(glm::normalize(
            normal_matrix * normal_at(store, store.faces[mesh.face[k]], mesh.corner_uv[k][c], flat)));
      }
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    parts.push_back(std::move(part));
  }
};

EmbreeMesh::EmbreeMesh(const tess::ViewMeshes& meshes, const nurbs::NurbsStore& store)
    : impl_(std::make_unique<Impl>()) {
  for (const tess::InstanceMesh& i : meshes.instances)
    for (const dvec3& v : i.mesh->mesh.vertices)
      impl_->bounds.add(store.instances[i.instance].placement.point(v));
  for (const tess::InstanceMesh& i : meshes.instances) impl_->add(i, store);
  rtcSetSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_HIGH);
  rtcCommitScene(impl_->scene);
}

EmbreeMesh::~EmbreeMesh() = default;

void EmbreeMesh::trace(const view::Camera& camera, int y0, int y1, std::span<trace::Hit> hits) const {
  // Rays start close before the model, where floats are fine.
  const Box3& b = impl_->bounds;
  double near = kInf;
  for (int k = 0; k < 8; ++k)
    near = std::min(near, glm::dot(dvec3((k & 1 ? b.lower : b.upper).x, (k & 2 ? b.lower : b.upper).y,
                                         (k & 4 ? b.lower : b.upper).z) -
                                       camera.eye,
                                   camera.forward));
  const double start = std::max(0.0, near - 1e-3 * b.diagonal());
  const dvec3 origin = camera.eye - b.center();
  const dvec3 right = camera.pixel * camera.right, down = -camera.pixel * camera.up;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRayHit16 r;
  double length[16];
  for (int y = y0; y < y1; y += 4)
    for (int x = 0; x < camera.width_px; x += 4) {
      alignas(64) int valid[16];
      for (int k = 0; k < 16; ++k) {
        const int px = x + k % 4, py = y + k / 4;
        valid[k] = px < camera.width_px && py < y1 ? -1 : 0;
        const dvec3 aside =
            (px + 0.5 - 0.5 * camera.width_px) * right + (py + 0.5 - 0.5 * camera.height_px) * down;
        const dvec3 dir = camera.perspective ? camera.forward + aside : camera.forward;
        const dvec3 org = origin + start * dir + (camera.perspective ? dvec3(0.0) : aside);
        length[k] = camera.perspective ? glm::length(dir) : 1.0;
        r.ray.org_x[k] = static_cast<float>(org.x), r.ray.org_y[k] = static_cast<float>(org.y),
        r.ray.org_z[k] = static_cast<float>(org.z);
        r.ray.dir_x[k] = static_cast<float>(dir.x), r.ray.dir_y[k] = static_cast<float>(dir.y),
        r.ray.dir_z[k] = static_cast<float>(dir.z);
        r.ray.tnear[k] = 0.0f, r.ray.tfar[k] = std::numeric_limits<float>::infinity(), r.ray.time[k] = 0.0f;
        r.ray.mask[k] = ~0u, r.ray.id[k] = 0, r.ray.flags[k] = 0;
        r.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
      }
      rtcIntersect16(valid, impl_->scene, &context, &r);
      for (int k = 0; k < 16; ++k) {
        if (!valid[k]) continue;
        trace::Hit& hit = hits[static_cast<std::size_t>(y + k / 4) * camera.width_px + x + k % 4];
        if (r.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) {
          hit.face = kNoFace;
          continue;
        }
        const Part& part = impl_->parts[r.hit.geomID[k]];
        const unsigned triangle = r.hit.primID[k];
        const Corners& c = part.corners[triangle];
        const float u = r.hit.u[k], v = r.hit.v[k], w = 1.0f - u - v;
        const glm::vec3 n = w * c.normal[0] + u * c.normal[1] + v * c.normal[2];
        hit.t = (start + r.ray.tfar[k]) * length[k];
        hit.face = part.mesh->mesh.face[triangle], hit.instance = part.instance;
        hit.uv_face = static_cast<double>(w) * c.uv[0] + static_cast<double>(u) * c.uv[1] +
                      static_cast<double>(v) * c.uv[2];
        hit.normal = dvec3(n / std::sqrt(glm::dot(n, n)));
      }
    }
}

}  // namespace bench
