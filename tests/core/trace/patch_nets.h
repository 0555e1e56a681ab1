// Random patches, and their evaluation by de Casteljau, which shares nothing with the kernel's.
#pragma once

#include "tests/core/trace/patch_rays.h"

namespace trimray::trace {

struct Net {
  int du = 3, dv = 3;
  std::vector<dvec4> h;
};

// A bumpy sheet over the unit square.
inline Net random_net(std::mt19937& rng, int du, int dv, double bump, bool rational) {
  std::uniform_real_distribution<double> noise(-1.0, 1.0), weight(0.4, 2.5);
  Net net{du, dv, {}};
  for (int i = 0; i <= du; ++i)
    for (int j = 0; j <= dv; ++j) {
      const dvec3 p(double(i) / du + 0.3 * noise(rng) / du, double(j) / dv + 0.3 * noise(rng) / dv,
                    bump * noise(rng));
      const double w = rational ? weight(rng) : 1.0;
      net.h.push_back(dvec4(p * w, w));
    }
  return net;
}

inline dvec4 casteljau(std::vector<dvec4> c, double t) {
  for (std::size_t n = c.size(); n > 1; --n)
    for (std::size_t i = 0; i + 1 < n; ++i) c[i] = (1.0 - t) * c[i] + t * c[i + 1];
  return c[0];
}

inline dvec3 point(const Net& net, double u, double v) {
  std::vector<dvec4> rows;
  for (int i = 0; i <= net.du; ++i)
    rows.push_back(casteljau({net.h.begin() + i * (net.dv + 1), net.h.begin() + (i + 1) * (net.dv + 1)}, v));
  const dvec4 h = casteljau(rows, u);
  return dvec3(h.x, h.y, h.z) / h.w;
}

inline nurbs::FaceSpec as_face(const Net& net) {
  nurbs::FaceSpec face;
  face.surface = nurbs::make_bezier(net.du, net.dv, net.h);
  face.uv_box.add(dvec2(0.0)), face.uv_box.add(dvec2(1.0));
  return face;
}

inline Ray lane(const RayLanes& r, int k) {
  return {{r.org_x[k], r.org_y[k], r.org_z[k]}, {r.dir_x[k], r.dir_y[k], r.dir_z[k]}};
}

}  // namespace trimray::trace
