// Whole stores with hand-made trim loops: edges with curves in space, vertices, shells. What trim_stores.h is
// for the inside test, this is for meshes.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/tolerance.h"
#include "core/nurbs/bounds.h"
#include "core/nurbs/link_edges.h"
#include "core/nurbs/make_store.h"
#include "core/nurbs/surface.h"
#include "tests/core/nurbs/trim_stores.h"

namespace trimray::nurbs {

inline dvec2 piece_uv(const TrimPiece& piece, double t) {
  return project(bezier_point(piece.data(), static_cast<int>(piece.size()) - 1, t));
}

// Signed area that a closed loop of pieces encloses, by Simpson's rule.
inline double loop_area(const TrimLoop& loop) {
  double area = 0.0;
  constexpr int kSteps = 2000;
  for (const TrimPiece& piece : loop) {
    for (int i = 0; i < kSteps; ++i) {
      const dvec2 a = piece_uv(piece, double(i) / kSteps), b = piece_uv(piece, double(i + 1) / kSteps);
      area += 0.5 * (a.x * b.y - a.y * b.x);
    }
  }
  return area;
}

// Bezier control points of degree n through n + 1 values at i / n, each coordinate by itself.
inline std::vector<dvec4> fit_bezier(const std::vector<dvec4>& values) {
  const int n = static_cast<int>(values.size()) - 1;
  // Rows: Bernstein values at Chebyshev points; Gauss with pivots.
  std::vector<std::vector<double>> m(n + 1, std::vector<double>(n + 1));
  std::vector<dvec4> b = values;
  for (int r = 0; r <= n; ++r) {
    const double t = 0.5 - 0.5 * std::cos(std::numbers::pi * r / n);
    for (int k = 0; k <= n; ++k) {
      double c = 1.0;
      for (int i = 0; i < k; ++i) c = c * (n - i) / (i + 1);
      m[r][k] = c * std::pow(t, k) * std::pow(1.0 - t, n - k);
    }
  }
  for (int c = 0; c <= n; ++c) {
    int p = c;
    for (int r = c + 1; r <= n; ++r)
      if (std::abs(m[r][c]) > std::abs(m[p][c])) p = r;
    std::swap(m[p], m[c]), std::swap(b[p], b[c]);
    for (int r = c + 1; r <= n; ++r) {
      const double f = m[r][c] / m[c][c];
      for (int k = c; k <= n; ++k) m[r][k] -= f * m[c][k];
      b[r] -= f * b[c];
    }
  }
  for (int c = n; c >= 0; --c) {
    for (int k = c + 1; k <= n; ++k) b[c] -= m[c][k] * b[k];
    b[c] /= m[c][c];
  }
  return b;
}

// Builds faces over shared edges.
class TrimmedMaker {
 public:
  NurbsStore store;

  std::int32_t vertex(dvec3 p) {
    for (std::size_t i = 0; i < store.vertices.size(); ++i)
      if (store.vertices[i].point == p) return static_cast<std::int32_t>(i);
    store.vertices.push_back({p, 1e-7});
    bounds_.add(p);
    return static_cast<std::int32_t>(store.vertices.size()) - 1;
  }

  // One Bezier piece over [0, 1].
  std::int32_t edge(const std::vector<dvec4>& ctrl_h, double band = 0.0) {
    Edge e;
    e.tolerance = 1e-7, e.band = band;
    e.vertex[0] = vertex(project(ctrl_h.front())), e.vertex[1] = vertex(project(ctrl_h.back()));
    const auto begin = static_cast<std::int32_t>(store.edge_ctrl_h.size());
    store.edge_ctrl_h.insert(store.edge_ctrl_h.end(), ctrl_h.begin(), ctrl_h.end());
    e.pieces.begin = static_cast<std::int32_t>(store.edge_pieces.size());
    e.pieces.end = e.pieces.begin + 1;
    store.edge_pieces.push_back({{begin, begin + static_cast<std::int32_t>(ctrl_h.size())}, 0.0, 1.0});
    for (const dvec4& c : ctrl_h) bounds_.add(project(c));
    store.edges.push_back(e);
    return static_cast<std::int32_t>(store.edges.size()) - 1;
  }

  // The image of a trim piece on a surface: a polynomial through points at Chebyshev places; the band says
  // how near it comes.
  std::int32_t edge_on(const SurfaceForm& form, const TrimPiece& piece) {
    constexpr int kDegree = 14;
    const SurfaceView s = view(form);
    std::vector<dvec4> values;
    for (int i = 0; i <= kDegree; ++i) {
      const double t = 0.5 - 0.5 * std::cos(std::numbers::pi * i / kDegree);
      values.emplace_back(evaluate_point(s, piece_uv(piece, t)), 1.0);
    }
    std::vector<dvec4> ctrl = fit_bezier(values);
    ctrl.front() = values.front(), ctrl.back() = values.back();
    for (dvec4& c : ctrl) c.w = 1.0;
    double off = 0.0;
    for (int i = 0; i <= 200; ++i) {
      const double t = i / 200.0;
      off = std::max(off, glm::distance(project(bezier_point(ctrl.data(), kDegree, t)),
                                        evaluate_point(s, piece_uv(piece, t))));
    }
    return edge(ctrl, 2.0 * off);
  }

  struct Use {
    std::int32_t edge = -1;
    bool reversed = false;
    TrimPiece piece;  // in the loop's direction
    bool seam = false;
  };

  void face(const SurfaceForm& form, const std::vector<std::vector<Use>>& loops, bool reversed) {
    const auto index = static_cast<std::int32_t>(store.faces.size());
    Face f;
    f.surface = append_surface(store, form);
    f.prototype = 0, f.shell = 0, f.shape = index + 1, f.reversed = reversed;
    f.loops.begin = static_cast<std::int32_t>(store.loops.size());
    f.loops.end = f.loops.begin + static_cast<std::int32_t>(loops.size());
    for (const auto& loop : loops) {
      const auto loop_index = static_cast<std::int32_t>(store.loops.size());
      const auto first = static_cast<std::int32_t>(store.coedges.size());
      for (const Use& use : loop) {
        CoEdge c;
        c.edge = use.edge, c.loop = loop_index, c.face = index, c.reversed = use.reversed, c.seam = use.seam;
        c.pieces.begin = static_cast<std::int32_t>(store.trim_pieces.size());
        c.pieces.end = c.pieces.begin + 1;
        const auto begin = static_cast<std::int32_t>(store.trim_ctrl_h.size());
        for (const dvec3& h : use.piece) {
          store.trim_ctrl_h.push_back(h);
          f.uv_box.add(project(h));
        }
        store.trim_pieces.push_back({{begin, static_cast<std::int32_t>(store.trim_ctrl_h.size())},
                                     use.reversed ? 1.0 : 0.0,
                                     use.reversed ? 0.0 : 1.0});
        store.coedges.push_back(c);
      }
      store.loops.push_back({index, {first, static_cast<std::int32_t>(store.coedges.size())}});
    }
    bounds_.add(hull_bounds(view(form), f.uv_box));
    store.faces.push_back(f);
  }

  NurbsStore finish(bool closed) {
    const auto whole = [](const auto& array) { return Range{0, static_cast<std::int32_t>(array.size())}; };
    store.shells.push_back({0, whole(store.faces), closed});
    Prototype p;
    p.faces = whole(store.faces), p.edges = whole(store.edges);
    p.vertices = whole(store.vertices), p.shells = whole(store.shells);
    p.bounds = bounds_;
    for (Edge& e : store.edges) e.band = std::max(e.band, kMinBand * bounds_.diagonal());
    link_edges(store);
    store.prototypes.push_back(p);
    store.instances.emplace_back().prototype = 0;
    store.meta = "{}";
    return std::move(store);
  }

 private:
  Box3 bounds_;
};

inline TrimPiece turned(TrimPiece piece) {
  std::reverse(piece.begin(), piece.end());
  return piece;
}

inline TrimLoop turned(TrimLoop loop) {
  std::reverse(loop.begin(), loop.end());
  for (TrimPiece& piece : loop) piece = turned(std::move(piece));
  return loop;
}

// One face; loops run with the face on their left: the outer one counter-clockwise, holes clockwise.
inline NurbsStore trimmed_face(const SurfaceForm& form, const std::vector<TrimLoop>& loops,
                               bool reversed = false) {
  TrimmedMaker maker;
  std::vector<std::vector<TrimmedMaker::Use>> uses;
  for (const TrimLoop& loop : loops) {
    uses.emplace_back();
    for (const TrimPiece& piece : loop)
      uses.back().push_back({maker.edge_on(form, piece), false, piece, false});
  }
  maker.face(form, uses, reversed);
  return maker.finish(false);
}

// A straight solid over loops in the plane z = 0, `height` high: closed.
inline NurbsStore prism(const std::vector<TrimLoop>& loops, double height) {
  TrimmedMaker maker;
  const auto at = [](const dvec3& h, double z) { return dvec4(h.x, h.y, z * h.z, h.z); };
  const TrimPiece right{{1, 0, 1}, {1, 1, 1}}, low{{0, 0, 1}, {1, 0, 1}};
  std::vector<std::vector<TrimmedMaker::Use>> bottom, top;
  std::vector<std::pair<SurfaceForm, std::vector<TrimmedMaker::Use>>> sides;
  for (const TrimLoop& loop : loops) {
    bottom.emplace_back(), top.emplace_back();
    std::vector<std::int32_t> upright;
    for (const TrimPiece& piece : loop)
      upright.push_back(maker.edge({at(piece[0], 0.0), at(piece[0], height)}));
    for (std::size_t i = 0; i < loop.size(); ++i) {
      std::vector<dvec4> foot, head, both;
      for (const dvec3& h : loop[i]) {
        foot.push_back(at(h, 0.0)), head.push_back(at(h, height));
        both.insert(both.end(), {foot.back(), head.back()});
      }
      const std::int32_t f = maker.edge(foot), h = maker.edge(head);
      bottom.back().push_back({f, false, loop[i], false}), top.back().push_back({h, false, loop[i], false});
      const std::int32_t next = upright[(i + 1) % loop.size()];
      sides.push_back({make_bezier(static_cast<int>(loop[i].size()) - 1, 1, both),
                       {{f, false, low, false},
                        {next, false, right, false},
                        {h, true, {{1, 1, 1}, {0, 1, 1}}, false},
                        {upright[i], true, {{0, 1, 1}, {0, 0, 1}}, false}}});
    }
  }
  const auto plane = [&](double z) {
    SurfaceForm form = make_plane({{0, 0, z}});
    return form;
  };
  maker.face(plane(0.0), bottom, true);
  maker.face(plane(height), top, false);
  for (const auto& [form, uses] : sides) maker.face(form, {uses}, false);
  return maker.finish(true);
}

}  // namespace trimray::nurbs
