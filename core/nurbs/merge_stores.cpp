#include "core/nurbs/merge_stores.h"

#include <limits>

#include "core/base/error.h"

namespace trimray::nurbs {
namespace {

// How far the indices of the store to come are moved: the lengths of the arrays so far.
class Moved {
 public:
  explicit Moved(const NurbsStore& s)
      : surfaces_(length(s.surfaces)),
        knots_(length(s.knots)),
        ctrl_(length(s.ctrl_h)),
        conics_(length(s.conics)),
        faces_(length(s.faces)),
        loops_(length(s.loops)),
        coedges_(length(s.coedges)),
        trim_pieces_(length(s.trim_pieces)),
        trim_ctrl_(length(s.trim_ctrl_h)),
        edges_(length(s.edges)),
        edge_coedges_(length(s.edge_coedges)),
        edge_pieces_(length(s.edge_pieces)),
        edge_ctrl_(length(s.edge_ctrl_h)),
        vertices_(length(s.vertices)),
        mesh_vertices_(length(s.mesh_vertices)),
        mesh_triangles_(length(s.mesh_triangles)),
        shells_(length(s.shells)),
        prototypes_(length(s.prototypes)) {}

  Surface operator()(Surface f) const {
    move(f.knots_u, knots_), move(f.knots_v, knots_), move(f.ctrl, ctrl_), move(f.conic, conics_);
    return f;
  }
  Face operator()(Face f) const {
    move(f.surface, surfaces_), move(f.prototype, prototypes_), move(f.shell, shells_);
    move(f.loops, loops_), move(f.triangles, mesh_triangles_);
    return f;
  }
  Loop operator()(Loop loop) const {
    move(loop.face, faces_), move(loop.coedges, coedges_);
    return loop;
  }
  CoEdge operator()(CoEdge c) const {
    move(c.edge, edges_), move(c.loop, loops_), move(c.face, faces_), move(c.pieces, trim_pieces_);
    move(c.conic, conics_);
    return c;
  }
  Edge operator()(Edge e) const {
    move(e.pieces, edge_pieces_), move(e.coedges, edge_coedges_), move(e.conic, conics_);
    for (std::int32_t& v : e.vertex) move(v, vertices_);
    return e;
  }
  Triangle operator()(Triangle t) const {
    for (std::int32_t& v : t) move(v, mesh_vertices_);
    return t;
  }
  Shell operator()(Shell s) const {
    move(s.prototype, prototypes_), move(s.faces, faces_);
    return s;
  }
  Prototype operator()(Prototype p) const {
    move(p.faces, faces_), move(p.edges, edges_), move(p.vertices, vertices_), move(p.shells, shells_);
    return p;
  }
  Instance operator()(Instance n) const {
    move(n.prototype, prototypes_);
    return n;
  }
  CurvePiece trim_piece(CurvePiece p) const {
    move(p.ctrl, trim_ctrl_);
    return p;
  }
  CurvePiece edge_piece(CurvePiece p) const {
    move(p.ctrl, edge_ctrl_);
    return p;
  }
  std::int32_t edge_coedge(std::int32_t c) const {
    move(c, coedges_);
    return c;
  }

 private:
  template <typename T>
  static std::int32_t length(const std::vector<T>& array) {
    return static_cast<std::int32_t>(array.size());
  }
  static void move(Range& r, std::int32_t by) { r.begin += by, r.end += by; }
  static void move(std::int32_t& index, std::int32_t by) {
    if (index >= 0) index += by;  // negative: there is none
  }

  std::int32_t surfaces_, knots_, ctrl_, conics_, faces_, loops_, coedges_, trim_pieces_, trim_ctrl_, edges_,
      edge_coedges_, edge_pieces_, edge_ctrl_, vertices_, mesh_vertices_, mesh_triangles_, shells_,
      prototypes_;
};

template <typename T, typename Move>
void append(std::vector<T>& to, const std::vector<T>& from, const Move& moved) {
  if (from.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) - to.size())
    throw ArgumentError("merge: the models are too large together");
  to.reserve(to.size() + from.size());
  for (const T& item : from) to.push_back(moved(item));
}

void append(NurbsStore& to, const NurbsStore& from) {
  const Moved moved(to);
  const auto same = [](const auto& item) { return item; };
  append(to.surfaces, from.surfaces, moved);
  append(to.knots, from.knots, same);
  append(to.ctrl_h, from.ctrl_h, same);
  append(to.conics, from.conics, same);
  append(to.faces, from.faces, moved);
  append(to.loops, from.loops, moved);
  append(to.coedges, from.coedges, moved);
  append(to.trim_pieces, from.trim_pieces, [&](const CurvePiece& p) { return moved.trim_piece(p); });
  append(to.trim_ctrl_h, from.trim_ctrl_h, same);
  append(to.edges, from.edges, moved);
  append(to.edge_coedges, from.edge_coedges, [&](std::int32_t c) { return moved.edge_coedge(c); });
  append(to.edge_pieces, from.edge_pieces, [&](const CurvePiece& p) { return moved.edge_piece(p); });
  append(to.edge_ctrl_h, from.edge_ctrl_h, same);
  append(to.vertices, from.vertices, same);
  append(to.mesh_vertices, from.mesh_vertices, same);
  append(to.mesh_triangles, from.mesh_triangles, moved);
  append(to.shells, from.shells, moved);
  append(to.prototypes, from.prototypes, moved);
  append(to.instances, from.instances, moved);
}

}  // namespace

NurbsStore merge_stores(std::span<const NurbsStore* const> stores, std::string meta) {
  NurbsStore merged;
  for (const NurbsStore* store : stores) append(merged, *store);
  merged.meta = std::move(meta);
  return merged;
}

}  // namespace trimray::nurbs
