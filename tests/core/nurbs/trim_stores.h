// Small stores with one face and hand-made trim loops.
#pragma once

#include <cmath>
#include <vector>

#include "core/nurbs/store.h"

namespace trimray::nurbs {

using TrimPiece = std::vector<dvec3>;  // (w u, w v, w)
using TrimLoop = std::vector<TrimPiece>;

inline TrimLoop polygon(const std::vector<dvec2>& points) {
  TrimLoop loop;
  for (std::size_t i = 0; i < points.size(); ++i)
    loop.push_back({dvec3(points[i], 1.0), dvec3(points[(i + 1) % points.size()], 1.0)});
  return loop;
}

// Four rational quadratics, exact.
inline TrimLoop ellipse(dvec2 c, double ru, double rv) {
  const double h = std::sqrt(0.5);
  const dvec2 corner[9] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
  TrimLoop loop;
  for (int q = 0; q < 4; ++q) {
    TrimPiece piece;
    for (int i = 0; i < 3; ++i) {
      const double w = i == 1 ? h : 1.0;
      piece.push_back(w * dvec3(c.x + ru * corner[2 * q + i].x, c.y + rv * corner[2 * q + i].y, 1.0));
    }
    loop.push_back(piece);
  }
  return loop;
}

inline void add_face(NurbsStore& store, const std::vector<TrimLoop>& loops) {
  Face face;
  face.surface = static_cast<std::int32_t>(store.surfaces.size());
  store.surfaces.emplace_back().kind = SurfaceKind::kPlane;
  face.prototype = 0;
  face.loops.begin = static_cast<std::int32_t>(store.loops.size());
  const auto face_index = static_cast<std::int32_t>(store.faces.size());
  for (const TrimLoop& loop : loops) {
    const auto loop_index = static_cast<std::int32_t>(store.loops.size());
    Loop l;
    l.face = face_index;
    l.coedges.begin = static_cast<std::int32_t>(store.coedges.size());
    for (const TrimPiece& ctrl : loop) {
      CoEdge coedge;
      coedge.loop = loop_index, coedge.face = face_index;
      coedge.pieces.begin = static_cast<std::int32_t>(store.trim_pieces.size());
      CurvePiece piece;
      piece.t0 = 0.0, piece.t1 = 1.0;
      piece.ctrl.begin = static_cast<std::int32_t>(store.trim_ctrl_h.size());
      for (const dvec3& c : ctrl) {
        store.trim_ctrl_h.push_back(c);
        face.uv_box.add(dvec2(c.x / c.z, c.y / c.z));
      }
      piece.ctrl.end = static_cast<std::int32_t>(store.trim_ctrl_h.size());
      store.trim_pieces.push_back(piece);
      coedge.pieces.end = static_cast<std::int32_t>(store.trim_pieces.size());
      store.coedges.push_back(coedge);
    }
    l.coedges.end = static_cast<std::int32_t>(store.coedges.size());
    store.loops.push_back(l);
  }
  face.loops.end = static_cast<std::int32_t>(store.loops.size());
  store.faces.push_back(face);
}

inline NurbsStore one_face(const std::vector<TrimLoop>& loops) {
  NurbsStore store;
  add_face(store, loops);
  return store;
}

}  // namespace trimray::nurbs
