#include "core/reference/mesh.h"

#include <algorithm>

namespace trimray::reference {
namespace {

// Signed crossings of the segment with the half-line from the origin along +x; y >= 0 is above.
int half_line_crossing(const Vec3& a, const Vec3& b) {
  const bool above_a = a.y >= 0, above_b = b.y >= 0;
  if (above_a == above_b) return 0;
  const Vec3 &low = above_a ? b : a, &high = above_a ? a : b;  // the same for both triangles of a side
  if (!(low.x * high.y - low.y * high.x > 0)) return 0;
  return above_b ? 1 : -1;
}

Vec3 cross_of(const Vec3 p[3]) { return glm::cross(p[1] - p[0], p[2] - p[0]); }

}  // namespace

void mesh_roots(const nurbs::NurbsStore& store, std::int32_t face, const Line& line,
                std::vector<trace::Root>& out) {
  const nurbs::Range triangles = store.faces[face].triangles;
  for (std::int32_t t = triangles.begin; t < triangles.end; ++t) {
    Vec3 p[3];  // across, across, along the line
    for (int c = 0; c < 3; ++c) {
      const Vec3 q = Vec3(store.mesh_vertices[store.mesh_triangles[t][c]]) - line.org;
      p[c] = Vec3(glm::dot(line.n1, q), glm::dot(line.n2, q), glm::dot(line.dir, q));
    }
    int winding = 0;
    for (int c = 0; c < 3; ++c) winding += half_line_crossing(p[c], p[(c + 1) % 3]);
    if (winding == 0) continue;
    // Where the line lies in the triangle's plane, any point of it: the middle.
    Real weight[3], sum = 0;
    for (int c = 0; c < 3; ++c) {
      const Vec3 &a = p[(c + 1) % 3], &b = p[(c + 2) % 3];
      weight[c] = std::max(Real(0), winding * (a.x * b.y - a.y * b.x));
      sum += weight[c];
    }
    for (Real& w : weight) w = sum > 0 ? w / sum : Real(1) / 3;
    trace::Root root;
    root.t = double(weight[0] * p[0].z + weight[1] * p[1].z + weight[2] * p[2].z);
    root.uv_face = dvec2(double(weight[1]), double(weight[2]));
    const Vec3 n = cross_of(p);
    const Vec3 world = n.x * line.n1 + n.y * line.n2 + n.z * line.dir;
    root.normal = glm::length(n) > 0 ? dvec3(glm::normalize(world)) : dvec3(0.0, 0.0, 1.0);
    root.face = face, root.sign = static_cast<std::int8_t>(winding), root.inside = true;
    out.push_back(root);
  }
}

}  // namespace trimray::reference
