// The whole store as read-only NumPy arrays that share its memory.
//
// Arrays of numbers are plain: knots (n,), ctrl_h (n, 4), trim_ctrl_h (n, 3), edge_ctrl_h (n, 4),
// edge_coedges (n,), mesh_vertices (n, 3), mesh_triangles (n, 3). Records are structured arrays (n,) whose
// fields have the names and meanings of core/nurbs/store.h: a Range is (2,) int32, an enum uint8, a flag
// bool, a vector (3,), a box (2, 2) or (2, 3), a placement its four columns (4, 3), all float64, a colour
// (4,) float32.
#include <memory>
#include <string>
#include <vector>

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "core/bind/bind.h"
#include "core/nurbs/store.h"

namespace trimray::bind {

namespace {

using nurbs::NurbsStore;

// Where a field lies in a record, as numpy.dtype wants it.
struct Field {
  const char* name;
  const char* format;
  std::size_t offset;
};

nb::object dtype(const std::vector<Field>& fields, std::size_t size) {
  nb::list names, formats, offsets;
  for (const Field& f : fields) names.append(f.name), formats.append(f.format), offsets.append(f.offset);
  nb::dict description;
  description["names"] = names, description["formats"] = formats, description["offsets"] = offsets;
  description["itemsize"] = size;
  return nb::module_::import_("numpy").attr("dtype")(description);
}

class Arrays {
 public:
  Arrays(const NurbsStore& store, nb::handle owner) : store_(store), owner_(owner) {}

  nb::dict all() {
    surfaces();
    numbers<double>("knots", store_.knots, 1);
    numbers<double>("ctrl_h", store_.ctrl_h, 4);
    topology();
    numbers<double>("trim_ctrl_h", store_.trim_ctrl_h, 3);
    numbers<std::int32_t>("edge_coedges", store_.edge_coedges, 1);
    numbers<double>("edge_ctrl_h", store_.edge_ctrl_h, 4);
    numbers<double>("mesh_vertices", store_.mesh_vertices, 3);
    numbers<std::int32_t>("mesh_triangles", store_.mesh_triangles, 3);
    placement();
    return std::move(result_);
  }

 private:
  template <typename T, typename V>
  void numbers(const char* name, const std::vector<V>& values, std::size_t columns) {
    static_assert(sizeof(V) % sizeof(T) == 0);
    using Array = nb::ndarray<nb::numpy, const T>;
    const T* data = reinterpret_cast<const T*>(values.data());
    result_[name] = columns == 1 ? nb::cast(Array(data, {values.size()}, owner_))
                                 : nb::cast(Array(data, {values.size(), columns}, owner_));
  }

  template <typename V>
  void records(const char* name, const std::vector<V>& values, const std::vector<Field>& fields) {
    using Bytes = nb::ndarray<nb::numpy, const std::uint8_t>;
    const auto* data = reinterpret_cast<const std::uint8_t*>(values.data());
    nb::object bytes = nb::cast(Bytes(data, {values.size() * sizeof(V)}, owner_));
    result_[name] = bytes.attr("view")(dtype(fields, sizeof(V)));
  }

  void surfaces() {
    using S = nurbs::Surface;
    records("surfaces", store_.surfaces,
            {{"kind", "u1", offsetof(S, kind)},
             {"basis", "u1", offsetof(S, basis)},
             {"conic", "i4", offsetof(S, conic)},
             {"rational", "?", offsetof(S, rational)},
             {"periodic_u", "?", offsetof(S, periodic_u)},
             {"periodic_v", "?", offsetof(S, periodic_v)},
             {"map_u", "u1", offsetof(S, map_u)},
             {"map_v", "u1", offsetof(S, map_v)},
             {"degree_u", "i4", offsetof(S, degree_u)},
             {"degree_v", "i4", offsetof(S, degree_v)},
             {"count_u", "i4", offsetof(S, count_u)},
             {"count_v", "i4", offsetof(S, count_v)},
             {"knots_u", "(2,)i4", offsetof(S, knots_u)},
             {"knots_v", "(2,)i4", offsetof(S, knots_v)},
             {"ctrl", "(2,)i4", offsetof(S, ctrl)},
             {"period_u", "f8", offsetof(S, period_u)},
             {"period_v", "f8", offsetof(S, period_v)},
             {"offset", "f8", offsetof(S, offset)},
             {"domain", "(2,2)f8", offsetof(S, domain)},
             {"location", "(3,)f8", offsetof(S, location)},
             {"x_axis", "(3,)f8", offsetof(S, x_axis)},
             {"y_axis", "(3,)f8", offsetof(S, y_axis)},
             {"z_axis", "(3,)f8", offsetof(S, z_axis)},
             {"r1", "f8", offsetof(S, r1)},
             {"r2", "f8", offsetof(S, r2)},
             {"semi_angle", "f8", offsetof(S, semi_angle)}});
    using C = nurbs::Conic;
    records("conics", store_.conics,
            {{"kind", "u1", offsetof(C, kind)},
             {"location", "(3,)f8", offsetof(C, location)},
             {"x_axis", "(3,)f8", offsetof(C, x_axis)},
             {"y_axis", "(3,)f8", offsetof(C, y_axis)},
             {"r1", "f8", offsetof(C, r1)},
             {"r2", "f8", offsetof(C, r2)}});
  }

  void topology() {
    using F = nurbs::Face;
    records("faces", store_.faces,
            {{"surface", "i4", offsetof(F, surface)},
             {"prototype", "i4", offsetof(F, prototype)},
             {"shell", "i4", offsetof(F, shell)},
             {"shape", "i4", offsetof(F, shape)},
             {"loops", "(2,)i4", offsetof(F, loops)},
             {"triangles", "(2,)i4", offsetof(F, triangles)},
             {"status", "u1", offsetof(F, status)},
             {"reversed", "?", offsetof(F, reversed)},
             {"iso_rectangle", "?", offsetof(F, iso_rectangle)},
             {"uv_box", "(2,2)f8", offsetof(F, uv_box)},
             {"color", "(4,)f4", offsetof(F, color)}});
    using L = nurbs::Loop;
    records("loops", store_.loops,
            {{"face", "i4", offsetof(L, face)}, {"coedges", "(2,)i4", offsetof(L, coedges)}});
    using C = nurbs::CoEdge;
    records("coedges", store_.coedges,
            {{"edge", "i4", offsetof(C, edge)},
             {"loop", "i4", offsetof(C, loop)},
             {"face", "i4", offsetof(C, face)},
             {"reversed", "?", offsetof(C, reversed)},
             {"seam", "?", offsetof(C, seam)},
             {"pieces", "(2,)i4", offsetof(C, pieces)},
             {"conic", "i4", offsetof(C, conic)}});
    using P = nurbs::CurvePiece;
    const std::vector<Field> piece = {
        {"ctrl", "(2,)i4", offsetof(P, ctrl)}, {"t0", "f8", offsetof(P, t0)}, {"t1", "f8", offsetof(P, t1)}};
    records("trim_pieces", store_.trim_pieces, piece);
    records("edge_pieces", store_.edge_pieces, piece);
    using E = nurbs::Edge;
    records("edges", store_.edges,
            {{"pieces", "(2,)i4", offsetof(E, pieces)},
             {"vertex", "(2,)i4", offsetof(E, vertex)},
             {"coedges", "(2,)i4", offsetof(E, coedges)},
             {"conic", "i4", offsetof(E, conic)},
             {"tolerance", "f8", offsetof(E, tolerance)},
             {"band", "f8", offsetof(E, band)},
             {"degenerate", "?", offsetof(E, degenerate)},
             {"smooth", "?", offsetof(E, smooth)}});
    using V = nurbs::Vertex;
    records("vertices", store_.vertices,
            {{"point", "(3,)f8", offsetof(V, point)}, {"tolerance", "f8", offsetof(V, tolerance)}});
    using S = nurbs::Shell;
    records("shells", store_.shells,
            {{"prototype", "i4", offsetof(S, prototype)},
             {"faces", "(2,)i4", offsetof(S, faces)},
             {"closed", "?", offsetof(S, closed)},
             {"lone", "?", offsetof(S, lone)},
             {"solid", "i4", offsetof(S, solid)}});
  }

  void placement() {
    using P = nurbs::Prototype;
    records("prototypes", store_.prototypes,
            {{"faces", "(2,)i4", offsetof(P, faces)},
             {"edges", "(2,)i4", offsetof(P, edges)},
             {"vertices", "(2,)i4", offsetof(P, vertices)},
             {"shells", "(2,)i4", offsetof(P, shells)},
             {"bounds", "(2,3)f8", offsetof(P, bounds)},
             {"color", "(4,)f4", offsetof(P, color)}});
    using I = nurbs::Instance;
    records("instances", store_.instances,
            {{"prototype", "i4", offsetof(I, prototype)},
             {"placement", "(4,3)f8", offsetof(I, placement)},
             {"color", "(4,)f4", offsetof(I, color)}});
  }

  const NurbsStore& store_;
  nb::handle owner_;
  nb::dict result_;
};

static_assert(sizeof(Transform) == 12 * sizeof(double) && sizeof(Box3) == 6 * sizeof(double));

}  // namespace

nb::dict store_arrays(nb::handle store) { return Arrays(nb::cast<const NurbsStore&>(store), store).all(); }

}  // namespace trimray::bind
