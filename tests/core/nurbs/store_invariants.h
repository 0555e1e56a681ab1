// What every store must satisfy, shared by the tests of build_store and by runs over real models.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "core/nurbs/curve_form.h"
#include "core/nurbs/project_curve.h"
#include "core/nurbs/surface_form.h"

namespace trimray::nurbs::invariants {

inline Pieces3 edge_path(const NurbsStore& store, const Edge& e) {
  Pieces3 r;
  for (std::int32_t k = e.pieces.begin; k < e.pieces.end; ++k) {
    CurvePiece p = store.edge_pieces[k];
    const std::int32_t offset = static_cast<std::int32_t>(r.ctrl.size());
    r.ctrl.insert(r.ctrl.end(), store.edge_ctrl_h.begin() + p.ctrl.begin,
                  store.edge_ctrl_h.begin() + p.ctrl.end);
    p.ctrl = {offset, offset + p.ctrl.size()};
    r.list.push_back(p);
  }
  return r;
}

struct Findings {
  double worst_gap = 0.0;              // between co-edges of a loop, as a fraction of the uv box
  double worst_excess = 0.0;           // of a p-curve point's distance to the edge, over the band
  int loops_open = 0;                  // gaps above 1e-3 of the uv box
  int points = 0, points_outside = 0;  // p-curve samples; those farther than the band
  int negative_areas = 0;              // faces whose loops run clockwise in sum
  double worst_band = 0.0;
};

inline dvec2 piece_uv(const NurbsStore& store, const CurvePiece& p, double x) {
  return project(bezier_point(&store.trim_ctrl_h[p.ctrl.begin], p.ctrl.size() - 1, x));
}

inline Findings check(const NurbsStore& store, int samples_per_piece, unsigned seed) {
  Findings r;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const Face& face : store.faces) {
    if (face.status != FaceStatus::kOk || face.is_mesh()) continue;
    const SurfaceView s = view(store, store.surfaces[face.surface]);
    const dvec2 size = face.uv_box.extent();
    double area = 0.0;
    for (std::int32_t l = face.loops.begin; l < face.loops.end; ++l) {
      const Range& ring = store.loops[l].coedges;
      dvec2 last = piece_uv(store, store.trim_pieces[store.coedges[ring.end - 1].pieces.end - 1], 1.0);
      bool open = false;
      for (std::int32_t c = ring.begin; c < ring.end; ++c) {
        const CoEdge& coedge = store.coedges[c];
        const Edge& edge = store.edges[coedge.edge];
        const Pieces3 path = edge_path(store, edge);
        for (std::int32_t k = coedge.pieces.begin; k < coedge.pieces.end; ++k) {
          const CurvePiece& p = store.trim_pieces[k];
          const dvec2 start = piece_uv(store, p, 0.0);
          const double gap = glm::length((start - last) / size);
          r.worst_gap = std::max(r.worst_gap, gap);
          open = open || gap > 1e-3;
          last = start;
          for (int i = 1; i <= 8; ++i) {
            const dvec2 here = piece_uv(store, p, i / 8.0);
            const dvec2 a = last - face.uv_box.lower, b = here - face.uv_box.lower;
            area += 0.5 * (a.x * b.y - a.y * b.x);
            last = here;
          }
          for (int i = 0; i < samples_per_piece && !path.empty(); ++i) {
            const double x = unit(random);
            const dvec3 on = evaluate(s, piece_uv(store, p, x)).p;
            const double d = path_distance(path, on, p.t0 + x * (p.t1 - p.t0), edge.band);
            ++r.points;
            if (d > edge.band) ++r.points_outside, r.worst_excess = std::max(r.worst_excess, d - edge.band);
          }
        }
      }
      r.loops_open += open;
    }
    if (area < 0.0) ++r.negative_areas;
  }
  for (const Edge& e : store.edges) r.worst_band = std::max(r.worst_band, e.band);
  return r;
}

}  // namespace trimray::nurbs::invariants
