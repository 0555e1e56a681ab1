#include "core/nurbs/build_store.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/tolerance.h"
#include "core/brep/bintools.h"
#include "core/nurbs/build_face.h"
#include "core/nurbs/build_mesh_face.h"
#include "core/nurbs/face_guards.h"
#include "core/nurbs/link_edges.h"
#include "core/nurbs/mesh_store.h"

namespace trimray::nurbs {
namespace {

constexpr double kBandSafety = 1.5;  // samples may miss the worst place
constexpr double kRounding = 1e-14;  // of the coordinates: a few tens of ulps
constexpr std::size_t kGrain = 16;

void check(const brep::Model& model, const BuildInput& input) {
  const auto fail = [](const char* what) { throw ArgumentError(std::string("build_store: ") + what); };
  const auto shape_exists = [&](std::int32_t s) {
    return s >= 1 && static_cast<std::size_t>(s) <= model.shapes.size();
  };
  const std::size_t prototypes = input.prototype_shapes.size(), instances = input.instance_prototypes.size();
  if (input.prototype_colors.size() != 4 * prototypes)
    fail("prototype_colors must hold 4 values a prototype");
  if (input.face_colors.size() != 4 * input.face_color_shapes.size())
    fail("face_colors must hold 4 values a face");
  if (input.instance_placements.size() != 12 * instances)
    fail("instance_placements must hold 12 values an instance");
  if (input.instance_colors.size() != 4 * instances) fail("instance_colors must hold 4 values an instance");
  for (const std::int32_t s : input.prototype_shapes)
    if (!shape_exists(s)) fail("prototype_shapes names a shape that the stream does not have");
  for (const std::int32_t s : input.face_color_shapes)
    if (!shape_exists(s)) fail("face_color_shapes names a shape that the stream does not have");
  for (const std::int32_t p : input.instance_prototypes)
    if (p < 0 || static_cast<std::size_t>(p) >= prototypes)
      fail("instance_prototypes names a prototype that is not there");
  for (const double x : input.instance_placements)
    if (!std::isfinite(x)) fail("instance_placements is not finite");
}

// An item of a prototype, for loops that run over all prototypes at once.
struct Item {
  std::int32_t prototype, index;
};

template <typename Count>
std::vector<Item> items(std::size_t prototypes, const Count& count) {
  std::vector<Item> all;
  for (std::size_t p = 0; p < prototypes; ++p)
    for (std::size_t i = 0; i < count(p); ++i)
      all.push_back({static_cast<std::int32_t>(p), static_cast<std::int32_t>(i)});
  return all;
}

template <typename Body>
void for_each(const std::vector<Item>& all, const Body& body) {
  parallel_ranges(all.size(), kGrain, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(all[i]);
  });
}

// Paths of edges that have none, from the first face that uses them.
void find_paths(PrototypeWork& proto) {
  for (const FaceWork& face : proto.faces)
    for (const LoopWork& loop : face.loops.loops)
      for (const CoEdgeWork& c : loop.coedges) {
        if (c.edge < 0 || proto.edges[c.edge].degenerate || !proto.edges[c.edge].path.empty()) continue;
        EdgeWork& e = proto.edges[c.edge];
        e.path = path_from_face(face, c, 1e-9 * std::max(1.0, face.bounds.diagonal()));
        if (!pieces_sound(e.path)) e.path = {};
        if (e.path.empty()) e.degenerate = true;
      }
}

double diagonal(const PrototypeWork& proto) {
  Box3 box;
  for (const FaceWork& f : proto.faces) box.add(f.bounds);
  return box.diagonal();
}

// Puts finished prototypes behind each other into a store.
class Assembler {
 public:
  NurbsStore store;

  void add(const PrototypeWork& work, const BuildInput& input,
           const std::unordered_map<std::int32_t, std::size_t>& colors, std::size_t index) {
    proto_ = static_cast<std::int32_t>(store.prototypes.size());
    Prototype p;
    p.vertices.begin = count(store.vertices), p.edges.begin = count(store.edges);
    p.faces.begin = count(store.faces), p.shells.begin = count(store.shells);
    for (const WalkVertex& v : work.walk.vertices) {
      const bool sound = glm::length(v.point) < kMaxCoordinate;
      store.vertices.push_back(
          {sound ? v.point : dvec3(0.0), std::isfinite(v.tolerance) ? v.tolerance : 0.0});
    }
    first_edge_ = p.edges.begin, first_vertex_ = p.vertices.begin;
    for (std::size_t i = 0; i < work.edges.size(); ++i) add_edge(work.walk.edges[i], work.edges[i]);
    deviation_.assign(work.edges.size(), 0.0);
    for (const WalkShell& s : work.walk.shells)
      store.shells.push_back(
          {proto_, {p.faces.begin + s.faces.begin, p.faces.begin + s.faces.end}, false, s.lone, s.solid});
    for (std::size_t i = 0; i < work.faces.size(); ++i) {
      const WalkFace& walk = work.walk.faces[i];
      const auto color = colors.find(walk.shape + 1);
      add_face(walk, work.faces[i], p.shells.begin);
      if (color != colors.end())
        std::copy_n(&input.face_colors[4 * color->second], 4, store.faces.back().color);
      p.bounds.add(work.faces[i].bounds);
    }
    p.vertices.end = count(store.vertices), p.edges.end = count(store.edges);
    p.faces.end = count(store.faces), p.shells.end = count(store.shells);
    for (std::int32_t e = p.edges.begin; e < p.edges.end; ++e) finish_edge(e, p);
    std::copy_n(&input.prototype_colors[4 * index], 4, p.color);
    for (std::int32_t s = p.shells.begin; s < p.shells.end; ++s)
      close_shell(store.shells[s], work, p.faces.begin);
    store.prototypes.push_back(p);
  }

 private:
  template <typename T>
  static std::int32_t count(const std::vector<T>& array) {
    return static_cast<std::int32_t>(array.size());
  }

  template <typename H>
  static Range append(std::vector<CurvePiece>& pieces, std::vector<H>& ctrl, const Pieces<H>& from) {
    const Range r{count(pieces), count(pieces) + count(from.list)};
    const std::int32_t offset = count(ctrl);
    for (CurvePiece p : from.list) {
      p.ctrl.begin += offset, p.ctrl.end += offset;
      pieces.push_back(p);
    }
    ctrl.insert(ctrl.end(), from.ctrl.begin(), from.ctrl.end());
    return r;
  }

  std::int32_t vertex(dvec3 p) {
    store.vertices.push_back({p, 0.0});
    return count(store.vertices) - 1;
  }

  void add_edge(const WalkEdge& walk, const EdgeWork& work) {
    Edge e;
    e.tolerance = work.tolerance, e.smooth = work.smooth;
    e.degenerate = work.degenerate || work.path.empty();
    e.pieces = append(store.edge_pieces, store.edge_ctrl_h, work.path);
    if (e.degenerate) e.pieces.end = e.pieces.begin;
    if (!e.degenerate) e.conic = append_conic(store, work.conic);
    for (int k = 0; k < 2; ++k) e.vertex[k] = walk.vertex[k] >= 0 ? first_vertex_ + walk.vertex[k] : -1;
    if (e.degenerate) {
      for (int k = 0; k < 2; ++k)
        if (e.vertex[k] < 0) e.vertex[k] = e.vertex[1 - k];
      if (e.vertex[0] < 0) e.vertex[0] = e.vertex[1] = vertex(dvec3(0.0));
    } else {
      if (e.vertex[0] < 0) e.vertex[0] = vertex(project(work.path.first()));
      if (e.vertex[1] < 0) e.vertex[1] = vertex(project(work.path.last()));
    }
    store.edges.push_back(e);
  }

  std::int32_t add_synthetic(const SyntheticEdge& s) {
    Edge e;
    e.degenerate = s.degenerate;
    e.pieces = append(store.edge_pieces, store.edge_ctrl_h, s.path);
    e.vertex[0] = vertex(s.end[0]);
    e.vertex[1] = s.degenerate ? e.vertex[0] : vertex(s.end[1]);
    store.edges.push_back(e);
    deviation_.push_back(0.0);
    return count(store.edges) - 1;
  }

  void add_face(const WalkFace& walk, const FaceWork& work, std::int32_t first_shell) {
    Face f;
    const std::int32_t face = count(store.faces);
    f.prototype = proto_, f.shell = first_shell + walk.shell, f.shape = walk.shape + 1;
    f.status = work.status, f.reversed = work.reversed;
    f.surface = append_surface(store, work.form);
    f.loops = {count(store.loops), count(store.loops)};
    if (!work.mesh_triangles.empty()) {
      add_mesh(work, f);
    } else if (work.status == FaceStatus::kOk) {
      f.uv_box = work.loops.uv_box, f.iso_rectangle = work.loops.iso_rectangle;
      std::vector<std::int32_t> synthetic;
      for (const SyntheticEdge& s : work.loops.synthetic) synthetic.push_back(add_synthetic(s));
      std::size_t k = 0;
      for (const LoopWork& l : work.loops.loops) {
        Loop loop{face, {count(store.coedges), count(store.coedges)}};
        for (const CoEdgeWork& c : l.coedges) {
          CoEdge out;
          out.edge = c.edge >= 0 ? first_edge_ + c.edge : synthetic[-1 - c.edge];
          out.loop = count(store.loops), out.face = face;
          out.reversed = c.reversed, out.seam = c.seam;
          out.conic = append_conic(store, c.conic);
          out.pieces = append(store.trim_pieces, store.trim_ctrl_h, c.pieces);
          double& worst = deviation_[out.edge - first_edge_];
          worst = std::max(worst, work.deviation[k++]);
          store.coedges.push_back(out);
        }
        loop.coedges.end = count(store.coedges);
        store.loops.push_back(loop);
      }
      f.loops.end = count(store.loops);
    }
    store.faces.push_back(f);
  }

  void add_mesh(const FaceWork& work, Face& face) {
    const std::int32_t first = count(store.mesh_vertices), begin = count(store.mesh_triangles);
    store.mesh_vertices.insert(store.mesh_vertices.end(), work.mesh_vertices.begin(),
                               work.mesh_vertices.end());
    for (const Triangle& t : work.mesh_triangles)
      store.mesh_triangles.push_back({first + t[0], first + t[1], first + t[2]});
    make_mesh_face(face, {begin, count(store.mesh_triangles)});
  }

  void finish_edge(std::int32_t index, const Prototype& p) {
    Edge& e = store.edges[index];
    double worst = deviation_.size() > static_cast<std::size_t>(index - p.edges.begin)
                       ? deviation_[index - p.edges.begin]
                       : 0.0;
    if (!e.degenerate) {
      const auto end = [&](std::int32_t ctrl) { return project(store.edge_ctrl_h[ctrl]); };
      worst = std::max(worst, glm::distance(store.vertices[e.vertex[0]].point,
                                            end(store.edge_pieces[e.pieces.begin].ctrl.begin)));
      worst = std::max(worst, glm::distance(store.vertices[e.vertex[1]].point,
                                            end(store.edge_pieces[e.pieces.end - 1].ctrl.end - 1)));
    }
    const double reach =
        p.bounds.empty() ? 0.0 : glm::length(glm::max(glm::abs(p.bounds.lower), glm::abs(p.bounds.upper)));
    const double least = std::max(kMinBand * p.bounds.diagonal(), kRounding * reach);
    e.band = std::max(kBandSafety * worst, least);
  }

  void close_shell(Shell& shell, const PrototypeWork& work, std::int32_t first_face) const {
    std::unordered_map<std::int32_t, std::pair<int, int>> uses;  // along, against
    const auto mesh = [](const Face& f) { return f.is_mesh(); };
    const auto faces = std::span(store.faces).subspan(shell.faces.begin, shell.faces.size());
    if (!faces.empty() && std::all_of(faces.begin(), faces.end(), mesh)) {
      const Range all{faces.front().triangles.begin, faces.back().triangles.end};
      shell.closed =
          closes_up(store.mesh_vertices, std::span(store.mesh_triangles).subspan(all.begin, all.size()));
      return;
    }
    bool closed = shell.faces.size() > 0;
    for (std::int32_t f = shell.faces.begin; f < shell.faces.end; ++f) {
      const Face& face = store.faces[f];
      if (face.status != FaceStatus::kOk) closed = false;
      if (face.loops.size() == 0 && !work.faces[f - first_face].closed_alone) closed = false;
      for (std::int32_t l = face.loops.begin; l < face.loops.end; ++l)
        for (std::int32_t c = store.loops[l].coedges.begin; c < store.loops[l].coedges.end; ++c) {
          const CoEdge& coedge = store.coedges[c];
          if (store.edges[coedge.edge].degenerate) continue;
          auto& u = uses[coedge.edge];
          ++(coedge.reversed != face.reversed ? u.second : u.first);
        }
    }
    for (const auto& [edge, u] : uses) closed = closed && u.first == 1 && u.second == 1;
    shell.closed = closed;
  }

  std::int32_t proto_ = 0, first_edge_ = 0, first_vertex_ = 0;
  std::vector<double> deviation_;  // by edge of the current prototype
};

}  // namespace

NurbsStore build_store(const brep::Model& model, const BuildInput& input) {
  check(model, input);
  std::vector<PrototypeWork> work(input.prototype_shapes.size());
  for (std::size_t p = 0; p < work.size(); ++p) {
    work[p].walk = walk_shape(model, input.prototype_shapes[p] - 1);
    work[p].edges.resize(work[p].walk.edges.size());
    work[p].faces.resize(work[p].walk.faces.size());
  }
  check_mesh_size(model, work);
  const std::vector<Item> edges = items(work.size(), [&](std::size_t p) { return work[p].edges.size(); });
  const std::vector<Item> faces = items(work.size(), [&](std::size_t p) { return work[p].faces.size(); });
  for_each(edges, [&](Item i) {
    PrototypeWork& w = work[i.prototype];
    w.edges[i.index] = build_edge(model, w.walk, w.walk.edges[i.index]);
  });
  for_each(faces, [&](Item i) {
    PrototypeWork& w = work[i.prototype];
    w.faces[i.index] = build_face(model, w, w.walk.faces[i.index]);
  });
  std::vector<double> tiny(work.size());
  std::vector<Box3> extent(work.size());
  for (std::size_t p = 0; p < work.size(); ++p) {
    extent[p] = edge_extent(work[p]);
    for (FaceWork& f : work[p].faces) refuse_far(f, extent[p]);
    find_paths(work[p]);
    tiny[p] = kMinBand * diagonal(work[p]);
  }
  for_each(faces, [&](Item i) {
    PrototypeWork& w = work[i.prototype];
    measure_deviation(w, w.faces[i.index], tiny[i.prototype]);
    refuse_loose(w, w.faces[i.index], extent[i.prototype]);
  });

  std::unordered_map<std::int32_t, std::size_t> colors;
  for (std::size_t i = 0; i < input.face_color_shapes.size(); ++i) colors[input.face_color_shapes[i]] = i;
  Assembler assembler;
  for (std::size_t p = 0; p < work.size(); ++p) assembler.add(work[p], input, colors, p);
  NurbsStore store = std::move(assembler.store);
  link_edges(store);
  for (std::size_t i = 0; i < input.instance_prototypes.size(); ++i) {
    Instance n;
    n.prototype = input.instance_prototypes[i];
    const double* m = &input.instance_placements[12 * i];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) n.placement.linear[c][r] = m[4 * r + c];
      n.placement.translation[r] = m[4 * r + 3];
    }
    std::copy_n(&input.instance_colors[4 * i], 4, n.color);
    store.instances.push_back(n);
  }
  store.meta = input.meta;
  return store;
}

NurbsStore build_store(std::span<const std::byte> brep, const BuildInput& input) {
  return build_store(brep::parse_bintools(brep), input);
}

}  // namespace trimray::nurbs
