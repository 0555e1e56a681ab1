// Scenes, cameras and random numbers for the tests of the hybrid tracer.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/nurbs/make_store.h"
#include "core/nurbs/merge_stores.h"
#include "core/trace/scene.h"
#include "core/view/camera.h"
#include "tests/core/nurbs/meshes.h"
#include "tests/core/trace/edge_rule_stores.h"

namespace trimray::testing {

struct Random {
  std::mt19937_64 engine;
  explicit Random(std::uint64_t seed) : engine(seed) {}
  double unit() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine); }
  double between(double a, double b) { return a + (b - a) * unit(); }
  // Every order of size is as likely; a and b positive.
  double log_between(double a, double b) { return a * std::pow(b / a, unit()); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine() % n); }
  bool chance(double p) { return unit() < p; }
  dvec3 direction() {
    std::normal_distribution<double> normal;
    return glm::normalize(dvec3(normal(engine), normal(engine), normal(engine)));
  }
  dmat3 rotation() {
    const dvec3 x = direction(), y = glm::normalize(glm::cross(x, direction()));
    return dmat3(x, y, glm::cross(x, y));
  }
};

inline nurbs::FaceSpec sheet(dvec3 at, double size, Random& random) {
  std::vector<dvec4> net;
  for (int i = 0; i <= 3; ++i)
    for (int j = 0; j <= 3; ++j) {
      const double w = random.between(0.6, 1.8);
      net.emplace_back((at + size * dvec3(i / 3.0, j / 3.0, 0.5 * random.between(-1, 1))) * w, w);
    }
  return {nurbs::make_bezier(3, 3, net), Box2{{0, 0}, {1, 1}}, false, false};
}

// A sphere, a torus, a tube, a cone and a square; as closed forms or as NURBS.
inline nurbs::NurbsStore bodies(bool closed_forms, dvec3 at = dvec3(0.0)) {
  const nurbs::Frame3 a{at, {1, 0, 0}, {0, 0, 1}}, b{at + dvec3(1, 2, 0.5), {0, 1, 0}, {1, 1, 1}};
  std::vector<nurbs::FaceSpec> faces{nurbs::full_sphere(a, 1.5), nurbs::full_torus(b, 2, 0.5),
                                     nurbs::tube(b, 0.7, -3, 3)};
  faces.push_back({nurbs::make_cone(a, 2.0, 0.3), Box2{{0, -2}, {2 * std::numbers::pi, 2}}, true, false});
  faces.push_back({nurbs::make_plane(b), Box2{{-3, -2}, {3, 2}}, false, false});
  if (!closed_forms)
    for (nurbs::FaceSpec& f : faces) f.surface = nurbs::as_nurbs(f.surface);
  return nurbs::make_store(faces);
}

// Squares with a round hole each, one behind the other, of planes as NURBS and
// as closed forms; every other one is met from behind.
inline nurbs::NurbsStore plates_with_holes() {
  trace::SolidMaker maker;
  for (int i = 0; i < 4; ++i) {
    const double z = 1.0 * i, radius = 0.5 + 0.3 * i;
    const dvec2 corners[4] = {{-3, -2}, {3, -2}, {3, 2}, {-3, 2}};
    std::vector<trace::SolidMaker::Use> outer;
    std::int32_t v[4];
    for (int c = 0; c < 4; ++c) v[c] = maker.vertex(dvec3(corners[c], z));
    for (int c = 0; c < 4; ++c)
      outer.push_back({maker.edge(v[c], v[(c + 1) % 4]),
                       false,
                       {{dvec3(corners[c], 1), dvec3(corners[(c + 1) % 4], 1)}}});
    const std::int32_t w = maker.vertex({radius, 0, z});
    const auto circle = trace::circle_pieces(radius, z);
    std::vector<std::vector<dvec3>> turned;
    for (const auto& piece : circle) {
      std::vector<dvec3> p;
      for (auto h = piece.rbegin(); h != piece.rend(); ++h) p.emplace_back(h->x, h->y, h->w);
      turned.insert(turned.begin(), p);
    }
    const std::int32_t edge = maker.edge(w, w, circle, 2.0 * std::numbers::pi);
    nurbs::SurfaceForm plane = nurbs::make_plane({{0, 0, z}});
    if (i < 2) plane = nurbs::as_nurbs(plane);
    maker.face(plane, i % 2 == 1, {outer, {{edge, true, turned}}});
  }
  return maker.finish();
}

// Placements of all kinds of one prototype; the first two, and the last two,
// lie on each other.
inline void place_many(nurbs::NurbsStore& store) {
  Random random(7);
  const dmat3 turn = random.rotation();
  const dmat3 mirror(dvec3(-1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1));
  const dmat3 stretch(dvec3(1, 0, 0), dvec3(0, 2.5, 0), dvec3(0, 0, 0.4));
  const Transform placements[] = {{dmat3(1.0), {0, 0, 0}},      {turn, {7, -2, 1}},
                                  {turn * mirror, {-6, 4, 2}},  {3.0 * turn, {0, 9, 5}},
                                  {turn * stretch, {2, -9, 0}}, {turn * stretch, {2, -9, 0}}};
  const nurbs::Instance first = store.instances[0];
  for (const Transform& placement : placements) {
    store.instances.push_back(first);
    store.instances.back().placement = placement;
  }
}

struct NamedScene {
  std::string name;
  trace::Scene scene;
  Box3 bounds;  // world
};

inline NamedScene named(std::string name, nurbs::NurbsStore store) {
  Box3 bounds;
  for (const nurbs::Instance& i : store.instances) {
    const Box3& b = store.prototypes[i.prototype].bounds;
    if (b.empty()) continue;
    for (int c = 0; c < 8; ++c)
      bounds.add(i.placement.point(
          {c & 1 ? b.upper.x : b.lower.x, c & 2 ? b.upper.y : b.lower.y, c & 4 ? b.upper.z : b.lower.z}));
  }
  if (bounds.empty()) bounds.add(dvec3(-1.0)), bounds.add(dvec3(1.0));
  return {std::move(name), trace::Scene(std::make_shared<nurbs::NurbsStore>(std::move(store)), 2), bounds};
}

// Everything that makes the tracers take another way.
inline std::vector<NamedScene> all_scenes() {
  std::vector<NamedScene> scenes;
  std::mt19937_64 rng(3);
  Random random(4);
  scenes.push_back(named("closed forms", bodies(true)));
  scenes.push_back(named("NURBS", bodies(false)));
  scenes.push_back(named("plates with holes", plates_with_holes()));
  scenes.push_back(named("thin slab", trace::box_solid({-5, -4, 0}, {5, 4, 1e-5}, 0.0, rng)));
  scenes.push_back(named("box with bad p-curves", trace::box_solid({-2, -1, 0}, {2, 1, 3}, 2e-3, rng)));
  scenes.push_back(named("cylinder with gaps", trace::capped_cylinder(2.0, 3.0, 1e-3)));
  scenes.push_back(named("mesh", store_in_groups(ball_mesh({1, 2, 3}, 2.0, 3), 50)));
  const nurbs::Frame3 frame{{3, -2, 5}, {1, 2, 0.5}, {-0.3, 0.2, 1}};
  std::vector<nurbs::FaceSpec> offsets{nurbs::full_sphere(frame, 2.0), nurbs::full_torus(frame, 5, 2)};
  offsets[0].surface = nurbs::as_offset(nurbs::as_nurbs(offsets[0].surface), 0.4);
  offsets[1].surface = nurbs::as_offset(nurbs::as_nurbs(offsets[1].surface), -0.7);
  scenes.push_back(named("offset surfaces", nurbs::make_store(offsets)));
  std::vector<nurbs::FaceSpec> sheets;
  for (int i = 0; i < 6; ++i)
    sheets.push_back(
        sheet({random.between(-2, 2), random.between(-2, 2), random.between(-1, 1)}, 3.0, random));
  sheets.push_back(sheets[2]);  // two faces in one place
  scenes.push_back(named("sheets", nurbs::make_store(sheets)));
  nurbs::NurbsStore many = bodies(false);
  place_many(many);
  scenes.push_back(named("instances", std::move(many)));
  nurbs::NurbsStore boxes = trace::box_solid({-2, -1, 0}, {2, 1, 3}, 1e-4, rng);
  place_many(boxes);
  scenes.push_back(named("instances of boxes", std::move(boxes)));
  nurbs::NurbsStore mesh = store_in_groups(box_mesh({-1, -2, 0}, {1, 3, 0.5}, 4), 16);
  const nurbs::NurbsStore solids = bodies(true), plates = plates_with_holes();
  place_many(mesh);
  const nurbs::NurbsStore* const stores[] = {&mesh, &solids, &plates};
  scenes.push_back(named("mixed", nurbs::merge_stores(stores, "{}")));
  scenes.push_back(named("far from the origin", bodies(false, {3e5, -2e5, 1e5})));
  nurbs::NurbsStore placed = bodies(true);
  placed.instances[0].placement = {random.rotation(), {-4e5, 1e5, 7e4}};
  scenes.push_back(named("placed far from the origin", std::move(placed)));
  scenes.push_back(named("empty", nurbs::NurbsStore()));
  return scenes;
}

struct NamedCamera {
  std::string name;
  view::Camera camera;
};

// Of the whole, along an axis, 50 and 1000 times as near, and from within.
inline std::vector<NamedCamera> all_cameras(const Box3& bounds, int width, int height) {
  std::vector<NamedCamera> cameras;
  std::vector<dvec3> points;
  for (int c = 0; c < 8; ++c)
    points.emplace_back(c & 1 ? bounds.upper.x : bounds.lower.x, c & 2 ? bounds.upper.y : bounds.lower.y,
                        c & 4 ? bounds.upper.z : bounds.lower.z);
  Random random(11);
  for (const bool perspective : {false, true}) {
    const std::string kind = perspective ? "perspective " : "orthographic ";
    const auto fit = [&](double azimuth, double elevation) {
      return view::fit(view::look(azimuth, elevation, view::UpAxis::kZ), points,
                       {.width_px = width, .height_px = height, .perspective = perspective});
    };
    const view::Camera whole = fit(30, 20);
    cameras.push_back({kind + "whole", whole});
    cameras.push_back({kind + "front", fit(0, 0)});
    cameras.push_back({kind + "top", fit(0, 90)});
    for (const double zoom : {50.0, 1000.0}) {
      view::Camera near = whole;
      const dvec3 target = bounds.center() + 0.25 * bounds.diagonal() * random.direction();
      if (perspective) {
        const double depth = glm::dot(target - near.eye, near.forward);
        near.eye = target - depth / zoom * near.forward;
      } else {
        near.pixel /= zoom;
        near.eye = target - (0.75 * bounds.diagonal()) * near.forward;
      }
      cameras.push_back({kind + std::to_string(static_cast<int>(zoom)) + " times", near});
    }
    view::Camera within = fit(200, -35);
    within.eye = bounds.center() + 0.05 * bounds.diagonal() * random.direction();
    if (perspective) within.pixel *= 3.0;
    cameras.push_back({kind + "within", within});
  }
  return cameras;
}

}  // namespace trimray::testing
