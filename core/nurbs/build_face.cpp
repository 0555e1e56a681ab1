#include "core/nurbs/build_face.h"

#include <cmath>
#include <numbers>

#include "core/nurbs/bounds.h"
#include "core/nurbs/build_mesh_face.h"
#include "core/nurbs/project_curve.h"
#include "core/nurbs/surface_over.h"

namespace trimray::nurbs {
namespace {

constexpr double kFar = 1e4;  // mm, half length of an unbounded surface when nothing tells how much is needed
constexpr double kTinyEdge = 1e-10;  // mm, below which a path is one point
constexpr double kReach = 1.0;       // mm, how far an edge may lie off a surface that it is projected on

bool is_plane(const SurfaceSource& s) {
  return s.basis_kind == SurfaceKind::kPlane && s.form.surface.offset == 0.0;
}

// The plane's frame in the prototype's coordinates, unit axes or not.
Surface placed_plane(const SurfaceSource& s) {
  Surface f = s.form.surface;
  if (s.transformed) {
    f.location = s.placement.point(f.location);
    f.x_axis = s.placement.vector(f.x_axis), f.y_axis = s.placement.vector(f.y_axis);
  }
  return f;
}

double difference(const Transform& a, const Transform& b) {
  double worst = 0.0;
  for (int i = 0; i < 3; ++i) worst = std::max(worst, glm::distance(a.linear[i], b.linear[i]));
  return worst + glm::distance(a.translation, b.translation) / (1.0 + glm::length(b.translation));
}

// Everything about one face while it is built.
class FaceBuilder {
 public:
  FaceBuilder(const brep::Model& model, const PrototypeWork& prototype, const WalkFace& face)
      : model_(model), proto_(prototype), face_(face), data_(model.faces[model.shapes[face.shape].data]) {
    placement_ = prototype.walk.transforms[face.transform];
    if (data_.location >= 0) placement_ = placement_ * model.locations[data_.location];
  }

  FaceWork run() {
    out_.reversed = face_.reversed;
    source_ = read_surface(model_, data_.surface, placement_);
    out_.status = source_.status;
    if (out_.status == FaceStatus::kOk) trim();
    if (out_.status == FaceStatus::kOk && !loops_sound()) out_.status = FaceStatus::kBadTrim;
    if (out_.status != FaceStatus::kOk) {
      out_.form = {};
      out_.loops = {};
    }
    return std::move(out_);
  }

 private:
  void trim() {
    std::vector<std::vector<WireUse>> wires;
    for (const auto& wire : face_.wires) {
      std::vector<WireUse> uses;
      for (const EdgeUse& use : wire) stored_pcurve(use, uses);
      wires.push_back(std::move(uses));
    }
    for (auto& wire : wires)
      for (WireUse& use : wire) {
        hull_.add(use.coedge.pieces.empty() ? Box2{} : pieces_box(use.coedge.pieces));
      }
    for (auto& wire : wires) complete(wire);
    if (out_.status != FaceStatus::kOk) return;
    std::erase_if(wires, [&](const auto& wire) { return only_points(wire); });

    if (wires.empty()) {
      natural();
    } else {
      const Surface& f = source_.form.surface;
      Box2 natural = source_.natural;
      if (source_.basis_kind == SurfaceKind::kCone && std::sin(f.semi_angle) != 0.0) {
        const double apex = -f.r1 / std::sin(f.semi_angle);
        (hull_.center().y > apex ? natural.lower : natural.upper).y = apex;
      }
      const SurfaceAt at = [this](dvec2 uv) { return surface_at(uv); };
      out_.loops = close_loops(std::move(wires), at, natural, {f.period_u, f.period_v});
      out_.status = out_.loops.status;
    }
    if (out_.status != FaceStatus::kOk) return;
    const Box2& box = out_.loops.uv_box;
    const bool finite = std::abs(box.lower.x) < kMaxCoordinate && std::abs(box.lower.y) < kMaxCoordinate &&
                        std::abs(box.upper.x) < kMaxCoordinate && std::abs(box.upper.y) < kMaxCoordinate;
    if (!finite || !(box.upper.x > box.lower.x) || !(box.upper.y > box.lower.y)) {
      out_.status = FaceStatus::kBadTrim;
      return;
    }
    if (!surface_over(model_, source_, box, out_.form)) {
      out_.status = no_form_status();
      return;
    }
    out_.bounds = hull_bounds(view(out_.form), box);
  }

  // Damaged ranges and poles may have passed as numbers until here.
  bool loops_sound() const {
    for (const LoopWork& loop : out_.loops.loops)
      for (const CoEdgeWork& c : loop.coedges)
        if (!pieces_sound(c.pieces)) return false;
    for (const SyntheticEdge& e : out_.loops.synthetic)
      if (!pieces_sound(e.path)) return false;
    return true;
  }

  // A wire whose edges are all poles bounds nothing: the vertex loop of a full sphere or cone.
  bool only_points(const std::vector<WireUse>& wire) const {
    for (const WireUse& use : wire)
      if (!proto_.edges[use.coedge.edge].degenerate) return false;
    return true;
  }

  FaceStatus no_form_status() const {
    if (source_.basis_kind != SurfaceKind::kExtrusion && source_.basis_kind != SurfaceKind::kRevolution)
      return FaceStatus::kBadTrim;
    std::int32_t c = source_.definition->basis_curve;
    while (model_.curves3[c].kind == brep::CurveKind::kTrimmed) c = model_.curves3[c].basis;
    return model_.curves3[c].kind == brep::CurveKind::kOffset ? FaceStatus::kUnsupported
                                                              : FaceStatus::kBadTrim;
  }

  void natural() {
    const Box2& box = source_.natural;
    out_.loops.uv_box = box;
    out_.loops.iso_rectangle = true;
    const Surface& f = source_.form.surface;
    out_.closed_alone = (f.periodic_u && f.periodic_v) || source_.basis_kind == SurfaceKind::kSphere;
  }

  // The p-curve that the stream gives for a use, in loop direction; no pieces when there is none.
  void stored_pcurve(const EdgeUse& use, std::vector<WireUse>& uses) const {
    const WalkEdge& edge = proto_.walk.edges[use.edge];
    const EdgeWork& work = proto_.edges[use.edge];
    const brep::EdgeData& data = model_.edges[model_.shapes[edge.shape].data];
    WireUse r;
    r.coedge.edge = use.edge, r.coedge.reversed = use.reversed;
    r.start_vertex = edge.vertex[use.reversed], r.end_vertex = edge.vertex[!use.reversed];
    r.tolerance = work.tolerance;
    for (const auto& other : face_.wires)
      for (const EdgeUse& o : other) r.coedge.seam = r.coedge.seam || (o.edge == use.edge && &o != &use);

    // Several p-curves may name the surface, in different places: the one whose place is the face's.
    const brep::PCurve* best = nullptr;
    double best_difference = kInf;
    for (const brep::PCurve& p : data.pcurves) {
      if (p.surface != data_.surface || p.curve < 0) continue;
      const Transform& at = proto_.walk.transforms[edge.transform];
      const double d = difference(p.location >= 0 ? at * model_.locations[p.location] : at, placement_);
      if (d < best_difference) best = &p, best_difference = d;
    }
    if (best != nullptr) {
      const std::int32_t curve = use.reversed && best->curve2 >= 0 ? best->curve2 : best->curve;
      auto pieces = curve_pieces<2>(model_.curves2, curve, best->first, best->last, 1e-9);
      if (pieces) {
        const double stretch = (work.last - work.first) / (best->last - best->first);
        if (best->first != work.first || best->last != work.last)
          for (CurvePiece& p : pieces->list)
            p.t0 = work.first + (p.t0 - best->first) * stretch,
            p.t1 = work.first + (p.t1 - best->first) * stretch;
        if (best->first == work.first && best->last == work.last)
          r.coedge.conic = conic_of<2>(model_.curves2, curve);
        if (use.reversed) reverse_pieces(*pieces);
        r.coedge.pieces = std::move(*pieces);
      }
    }
    uses.push_back(std::move(r));
  }

  // Finds the p-curves that the stream does not give.
  void complete(std::vector<WireUse>& wire) {
    std::vector<WireUse> kept;
    for (WireUse& use : wire) {
      if (use.coedge.pieces.empty()) {
        const EdgeWork& edge = proto_.edges[use.coedge.edge];
        if (edge.degenerate) continue;  // the loop closer puts poles in
        Pieces2 pieces;
        if (is_plane(source_) && !edge.path.empty()) {
          pieces = project_on_plane(edge.path, placed_plane(source_));
        } else if (ensure_wide()) {
          auto found = project_on_surface(edge.path, view(wide_), std::max(kReach, 10.0 * edge.tolerance));
          if (found) pieces = std::move(*found);
        }
        if (pieces.empty()) {
          out_.status = FaceStatus::kBadTrim;
          return;
        }
        if (use.coedge.reversed) reverse_pieces(pieces);
        use.coedge.pieces = std::move(pieces);
        hull_.add(pieces_box(use.coedge.pieces));
      }
      kept.push_back(std::move(use));
    }
    wire = std::move(kept);
  }

  // The surface over all that the loops may touch, before their box is known.
  bool ensure_wide() {
    if (wide_state_ != 0) return wide_state_ > 0;
    Box2 box = source_.natural;
    for (int d = 0; d < 2; ++d) {
      if (!std::isfinite(box.lower[d])) box.lower[d] = hull_.empty() ? -kFar : hull_.lower[d] - 1.0;
      if (!std::isfinite(box.upper[d])) box.upper[d] = hull_.empty() ? kFar : hull_.upper[d] + 1.0;
    }
    wide_state_ = surface_over(model_, source_, box, wide_) ? 1 : -1;
    return wide_state_ > 0;
  }

  dvec3 surface_at(dvec2 uv) {
    if (!source_.transformed && has_closed_form(source_.form.surface.kind)) {
      wide_.surface = source_.form.surface;
      return evaluate_point(view(wide_), uv);
    }
    return ensure_wide() ? evaluate_point(view(wide_), uv) : dvec3(kNaN);
  }

  const brep::Model& model_;
  const PrototypeWork& proto_;
  const WalkFace& face_;
  const brep::FaceData& data_;
  Transform placement_;
  SurfaceSource source_;
  Box2 hull_;  // of the p-curves as stored
  SurfaceForm wide_;
  int wide_state_ = 0;  // 0 not tried, 1 there, -1 impossible
  FaceWork out_;
};

// Largest distance from points on the surface over a straight way in uv to a path or a point.
double link_distance(const SurfaceView& s, dvec2 from, dvec2 to, dvec3 anchor) {
  if (from == to) return 0.0;
  double worst = 0.0;
  for (const double x : {0.5, 1.0})
    worst = std::max(worst, glm::distance(anchor, evaluate_point(s, from + x * (to - from))));
  return worst;
}

}  // namespace

Transform operator*(const Transform& a, const Transform& b) {
  return {a.linear * b.linear, a.linear * b.translation + a.translation};
}

EdgeWork build_edge(const brep::Model& model, const Walk& walk, const WalkEdge& edge) {
  const brep::EdgeData& data = model.edges[model.shapes[edge.shape].data];
  EdgeWork w;
  w.tolerance = std::isfinite(data.tolerance) ? data.tolerance : 0.0;
  w.smooth = data.smooth, w.degenerate = data.degenerated;
  w.first = data.first, w.last = data.last;
  if (w.degenerate || data.curve3 < 0) {
    if (data.curve3 < 0 && !data.pcurves.empty())
      w.first = data.pcurves[0].first, w.last = data.pcurves[0].last;
    return w;
  }
  Transform at = walk.transforms[edge.transform];
  if (data.location >= 0) at = at * model.locations[data.location];
  auto path = curve_pieces<3>(model.curves3, data.curve3, data.first, data.last, 1e-9);
  if (!path) return w;
  transform_ctrl(path->ctrl, at);
  Box3 hull;
  for (const dvec4& h : path->ctrl) hull.add(project(h));
  if (!(hull.diagonal() < kMaxCoordinate)) return w;
  if (hull.diagonal() <= kTinyEdge)
    w.degenerate = true;
  else
    w.path = std::move(*path), w.conic = placed(conic_of<3>(model.curves3, data.curve3), at);
  return w;
}

FaceWork build_face(const brep::Model& model, const PrototypeWork& prototype, const WalkFace& face) {
  if (is_mesh_face(model, face)) return build_mesh_face(model, prototype.walk, face);
  return FaceBuilder(model, prototype, face).run();
}

Pieces3 path_from_face(const FaceWork& face, const CoEdgeWork& coedge, double tolerance) {
  Pieces3 r;
  const SurfaceView s = view(face.form);
  for (const CurvePiece& p : coedge.pieces.list) {
    const dvec3* ctrl = &coedge.pieces.ctrl[p.ctrl.begin];
    const int degree = p.ctrl.size() - 1;
    const Pieces3 fit =
        fit_cubics<3>([&](double x) { return evaluate_point(s, project(bezier_point(ctrl, degree, x))); },
                      0.0, 1.0, tolerance);
    for (const CurvePiece& q : fit.list) {
      const std::int32_t offset = static_cast<std::int32_t>(r.ctrl.size());
      r.list.push_back(
          {{offset, offset + q.ctrl.size()}, p.t0 + q.t0 * (p.t1 - p.t0), p.t0 + q.t1 * (p.t1 - p.t0)});
      r.ctrl.insert(r.ctrl.end(), fit.ctrl.begin() + q.ctrl.begin, fit.ctrl.begin() + q.ctrl.end);
    }
  }
  if (coedge.reversed) reverse_pieces(r);
  return r;
}

void measure_deviation(const PrototypeWork& prototype, FaceWork& face, double tiny) {
  face.deviation.clear();
  if (face.status != FaceStatus::kOk || !face.mesh_triangles.empty()) return;
  const SurfaceView s = view(face.form);
  for (const LoopWork& loop : face.loops.loops) {
    for (std::size_t i = 0; i < loop.coedges.size(); ++i) {
      const CoEdgeWork& c = loop.coedges[i];
      const bool synthetic = c.edge < 0;
      const SyntheticEdge* own = synthetic ? &face.loops.synthetic[-1 - c.edge] : nullptr;
      const Pieces3& path = synthetic ? own->path : prototype.edges[c.edge].path;
      double worst = 0.0;
      if (path.empty()) {  // a pole: its path is one point
        if (!synthetic) {
          const std::int32_t v = prototype.walk.edges[c.edge].vertex[0];
          if (v >= 0)
            for (const CurvePiece& p : c.pieces.list)
              for (int k = 0; k <= 8; ++k)
                worst = std::max(
                    worst,
                    glm::distance(prototype.walk.vertices[v].point,
                                  evaluate_point(s, project(bezier_point(&c.pieces.ctrl[p.ctrl.begin],
                                                                         p.ctrl.size() - 1, k / 8.0)))));
        }
      } else {
        for (const CurvePiece& p : c.pieces.list) {
          const int degree = p.ctrl.size() - 1;
          // On a plane a straight piece against a straight path strays most at an end.
          const bool straight = face.form.surface.kind == SurfaceKind::kPlane && degree == 1 &&
                                path.list.size() == 1 && path.list[0].ctrl.size() == 2;
          // Every piece of the path gets its share: a straight p-curve may follow a path of many pieces.
          const int share = static_cast<int>(8 * path.list.size() / c.pieces.list.size());
          const int samples =
              straight ? 1 : std::min(std::max(16 + 4 * std::max(0, degree - 3), share), 1024);
          for (int k = 0; k <= samples; ++k) {
            const double x = double(k) / samples;
            const dvec3 on =
                evaluate_point(s, project(bezier_point(&c.pieces.ctrl[p.ctrl.begin], degree, x)));
            worst = std::max(worst, path_distance(path, on, p.t0 + x * (p.t1 - p.t0), std::max(worst, tiny)));
          }
        }
        const CoEdgeWork& next = loop.coedges[(i + 1) % loop.coedges.size()];
        const CoEdgeWork& previous = loop.coedges[(i + loop.coedges.size() - 1) % loop.coedges.size()];
        const dvec3 head = project(c.reversed ? path.first() : path.last()),
                    tail = project(c.reversed ? path.last() : path.first());
        worst = std::max(worst, link_distance(s, end_uv(c), start_uv(next), head));
        worst = std::max(worst, link_distance(s, start_uv(c), end_uv(previous), tail));
      }
      face.deviation.push_back(worst);
      if (!(worst < kMaxCoordinate)) face.status = FaceStatus::kBadTrim;
    }
  }
  if (face.status != FaceStatus::kOk) refuse(face, face.status);
}

void refuse(FaceWork& face, FaceStatus status) {
  face.status = status;
  face.form = {}, face.loops = {}, face.bounds = {}, face.deviation = {};
  face.mesh_vertices = {}, face.mesh_triangles = {};
}

}  // namespace trimray::nurbs
