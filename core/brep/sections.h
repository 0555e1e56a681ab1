// The sections of the stream, one function each, in the order in which they stand in it. Curves, surfaces,
// locations, triangulations and shapes go into a Model; polygons are passed over.
#pragma once

#include <cstdint>
#include <vector>

#include "core/brep/byte_reader.h"
#include "core/brep/topology.h"

namespace trimray::brep {

// The stream numbers top-level entries only, while a Model also holds the basis curves and surfaces
// nested in them: entry k of the stream is element table[k] of the Model.
struct StreamTables {
  int version = 4;
  std::vector<std::int32_t> curves2, curves3, surfaces;
  std::size_t locations = 0, polygons3 = 0, polygons_on_mesh = 0, meshes = 0;
};

// Each reads one section, header line included. They throw FormatError.
void read_locations(ByteReader& in, Model& model, StreamTables& tables);
void read_curves2(ByteReader& in, Model& model, StreamTables& tables);
void read_curves3(ByteReader& in, Model& model, StreamTables& tables);
void skip_polygons3(ByteReader& in, StreamTables& tables);
void skip_polygons_on_mesh(ByteReader& in, StreamTables& tables);
void read_surfaces(ByteReader& in, Model& model, StreamTables& tables);
void read_meshes(ByteReader& in, Model& model, StreamTables& tables);
// The last one: nothing may follow it.
void read_shapes(ByteReader& in, Model& model, const StreamTables& tables);

// One curve with its basis curves; returns its index in model.curves3. Also used inside surfaces.
std::int32_t read_curve3(ByteReader& in, Model& model);

// Distinct knots with multiplicities, and the checks that tie them to degree and number of poles.
void read_knots(ByteReader& in, std::int32_t knot_count, std::int32_t pole_count, int degree, bool periodic,
                std::vector<double>& knots, std::vector<std::int32_t>& multiplicities);

// A degree in [1, kMaxDegree].
int read_degree(ByteReader& in);

}  // namespace trimray::brep
