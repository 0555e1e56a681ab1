// The section "Surfaces".
#include "core/brep/sections.h"

namespace trimray::brep {
namespace {

void read_frame(ByteReader& in, Surface& surface) {
  surface.location = in.vec3();
  surface.z_axis = in.vec3();
  surface.x_axis = in.vec3();
  surface.y_axis = in.vec3();
}

void read_poles(ByteReader& in, Surface& surface) {
  const bool rational = surface.rational_u || surface.rational_v;
  const std::int64_t total = std::int64_t{surface.count_u} * surface.count_v;
  const std::int32_t count = in.checked_count(total, rational ? 32 : 24);
  surface.poles.reserve(count);
  if (rational) surface.weights.reserve(count);
  for (std::int32_t i = 0; i < count; ++i) {
    surface.poles.push_back(in.vec3());
    if (rational) surface.weights.push_back(in.real());
  }
}

void read_bezier(ByteReader& in, Surface& surface) {
  surface.rational_u = in.flag();
  surface.rational_v = in.flag();
  surface.degree_u = read_degree(in);
  surface.degree_v = read_degree(in);
  surface.count_u = surface.degree_u + 1;
  surface.count_v = surface.degree_v + 1;
  read_poles(in, surface);
  surface.knots_u = surface.knots_v = {0.0, 1.0};
  surface.multiplicities_u = {surface.count_u, surface.count_u};
  surface.multiplicities_v = {surface.count_v, surface.count_v};
}

void read_bspline(ByteReader& in, Surface& surface) {
  surface.rational_u = in.flag();
  surface.rational_v = in.flag();
  surface.periodic_u = in.flag();
  surface.periodic_v = in.flag();
  surface.degree_u = read_degree(in);
  surface.degree_v = read_degree(in);
  surface.count_u = in.count(24);
  surface.count_v = in.count(24);
  const std::int32_t knots_u = in.count(12);
  const std::int32_t knots_v = in.count(12);
  if (surface.count_u < 2 || surface.count_v < 2) in.fail("fewer than two poles");
  read_poles(in, surface);
  read_knots(in, knots_u, surface.count_u, surface.degree_u, surface.periodic_u, surface.knots_u,
             surface.multiplicities_u);
  read_knots(in, knots_v, surface.count_v, surface.degree_v, surface.periodic_v, surface.knots_v,
             surface.multiplicities_v);
}

std::int32_t read_surface(ByteReader& in, Model& model, int depth);

// Fills a surface that is made from another surface or a curve.
void read_derived(ByteReader& in, Model& model, int depth, Surface& surface) {
  switch (surface.kind) {
    case SurfaceKind::kExtrusion:
      surface.z_axis = in.vec3();
      surface.basis_curve = read_curve3(in, model);
      break;
    case SurfaceKind::kRevolution:
      surface.location = in.vec3();
      surface.z_axis = in.vec3();
      surface.basis_curve = read_curve3(in, model);
      break;
    case SurfaceKind::kTrimmed:
      surface.u0 = in.real();
      surface.u1 = in.real();
      surface.v0 = in.real();
      surface.v1 = in.real();
      surface.basis = read_surface(in, model, depth + 1);
      break;
    default:
      surface.offset = in.real();
      surface.basis = read_surface(in, model, depth + 1);
      break;
  }
}

// Appends a surface behind its basis; returns its index.
std::int32_t read_surface(ByteReader& in, Model& model, int depth) {
  if (depth > kMaxBasisDepth) in.fail("basis surfaces nested too deeply");
  const std::uint8_t code = in.byte();
  if (code < 1 || code > 11) in.fail("unknown kind of surface");
  Surface surface;
  surface.kind = static_cast<SurfaceKind>(code - 1);
  switch (surface.kind) {
    case SurfaceKind::kPlane:
      read_frame(in, surface);
      break;
    case SurfaceKind::kCylinder:
    case SurfaceKind::kSphere:
      read_frame(in, surface);
      surface.r1 = in.real();
      break;
    case SurfaceKind::kCone:
      read_frame(in, surface);
      surface.r1 = in.real();
      surface.semi_angle = in.real();
      break;
    case SurfaceKind::kTorus:
      read_frame(in, surface);
      surface.r1 = in.real();
      surface.r2 = in.real();
      break;
    case SurfaceKind::kBezier:
      read_bezier(in, surface);
      break;
    case SurfaceKind::kBspline:
      read_bspline(in, surface);
      break;
    default:
      read_derived(in, model, depth, surface);
      break;
  }
  model.surfaces.push_back(std::move(surface));
  return static_cast<std::int32_t>(model.surfaces.size()) - 1;
}

}  // namespace

void read_surfaces(ByteReader& in, Model& model, StreamTables& tables) {
  const std::int32_t count = in.section("Surfaces", 74);
  tables.surfaces.reserve(count);
  model.surfaces.reserve(count);
  for (std::int32_t i = 0; i < count; ++i) tables.surfaces.push_back(read_surface(in, model, 0));
}

}  // namespace trimray::brep
