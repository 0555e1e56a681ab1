// Scene: casting rays and rendering, with either tracer.
#include <cmath>
#include <memory>
#include <tuple>

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/bind/bind.h"
#include "core/bind/casters.h"
#include "core/bind/seeds.h"
#include "core/reference/reference.h"
#include "core/trace/render.h"
#include "core/trace/scene.h"

namespace trimray::bind {

namespace {

using trace::Hit;
using trace::Ray;

// Rays of unit length, and the lengths that their t is measured in.
struct Rays {
  std::vector<Ray> rays;
  std::vector<double> lengths;
};

Rays read_rays(const In2<double, 3>& org, const In2<double, 3>& dir, const In1<double>& tmin,
               const In1<double>& tmax) {
  const std::size_t n = org.shape(0);
  if (dir.shape(0) != n || tmin.shape(0) != n || tmax.shape(0) != n)
    throw ArgumentError("ray arrays differ in length");
  Rays r;
  r.rays.resize(n), r.lengths.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const dvec3 o(org(i, 0), org(i, 1), org(i, 2)), d(dir(i, 0), dir(i, 1), dir(i, 2));
    const double length = std::hypot(d.x, d.y, d.z);
    if (!std::isfinite(o.x + o.y + o.z) || !std::isfinite(length)) {
      throw ArgumentError("ray " + std::to_string(i) + " is not finite");
    }
    if (!(length > 0.0)) throw ArgumentError("ray " + std::to_string(i) + " has a direction of length 0");
    if (std::isnan(tmin(i)) || std::isnan(tmax(i)))
      throw ArgumentError("ray " + std::to_string(i) + ": tmin or tmax is not a number");
    r.lengths[i] = length;
    r.rays[i] = {o, d / length, tmin(i) * length, tmax(i) * length};
  }
  return r;
}

// t, face, instance, uv, normal.
using HitArrays = std::tuple<Out<double>, Out<std::int32_t>, Out<std::int32_t>, Out<double>, Out<double>>;
HitArrays hit_arrays(const std::vector<Hit>& hits, const std::vector<double>& lengths) {
  const std::size_t n = hits.size();
  std::vector<double> t(n, kInf), uv(2 * n, 0.0), normal(3 * n, 0.0);
  std::vector<std::int32_t> face(n, kNoFace), instance(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    if (hits[i].face == kNoFace) continue;
    t[i] = hits[i].t / lengths[i];
    face[i] = hits[i].face, instance[i] = hits[i].instance;
    uv[2 * i] = hits[i].uv_face.x, uv[2 * i + 1] = hits[i].uv_face.y;
    for (int c = 0; c < 3; ++c) normal[3 * i + c] = hits[i].normal[c];
  }
  return {array(std::move(t), {n}), array(std::move(face), {n}), array(std::move(instance), {n}),
          array(std::move(uv), {n, 2}), array(std::move(normal), {n, 3})};
}

HitArrays cast(const trace::Scene& scene, const In2<double, 3>& org, const In2<double, 3>& dir,
               const In1<double>& tmin, const In1<double>& tmax, bool reference, int threads) {
  const Rays r = read_rays(org, dir, tmin, tmax);
  std::vector<Hit> hits(r.rays.size());
  {
    nb::gil_scoped_release release;
    if (reference)
      reference::cast(scene.store(), r.rays, hits, threads);
    else
      scene.cast(r.rays, hits, threads);
  }
  return hit_arrays(hits, r.lengths);
}

Out<std::int32_t> count_hits(const trace::Scene& scene, const In2<double, 3>& org, const In2<double, 3>& dir,
                             const In1<double>& tmin, const In1<double>& tmax, bool reference, int threads) {
  const Rays r = read_rays(org, dir, tmin, tmax);
  const std::size_t n = r.rays.size();
  std::vector<std::int32_t> counts(n, 0);
  {
    nb::gil_scoped_release release;
    if (reference) {
      parallel_ranges(n, 16, threads, [&](std::size_t begin, std::size_t end) {
        std::vector<Hit> hits;
        for (std::size_t i = begin; i < end; ++i) {
          hits.clear();
          reference::cast_all(scene.store(), r.rays[i], hits);
          counts[i] = static_cast<std::int32_t>(hits.size());
        }
      });
    } else {
      scene.count_hits(r.rays, counts, threads);
    }
  }
  return array(std::move(counts), {n});
}

view::Planes planes_of(const std::vector<std::string>& names) {
  view::Planes p{.color = false};
  for (const std::string& name : names) {
    if (name == "color")
      p.color = true;
    else if (name == "depth")
      p.depth = true;
    else if (name == "position")
      p.position = true;
    else if (name == "normal")
      p.normal = true;
    else if (name == "uv")
      p.uv = true;
    else if (name == "face")
      p.face = true;
    else if (name == "instance")
      p.instance = true;
    else if (name == "time")
      p.time = true;
    else
      throw ArgumentError("unknown AOV '" + name + "'");
  }
  return p;
}

nb::typed<nb::dict, nb::str, nb::any> render(const trace::Scene& scene, const view::Camera& camera,
                                             const std::vector<std::string>& aovs, int samples,
                                             const In2<float, 4>& background, bool orientation,
                                             const std::string& mode, int threads, trace::Progress& progress,
                                             const Seeds* seeds, const trace::SecondaryOptions& secondary) {
  trace::RenderOptions options;
  options.camera = camera;
  options.planes = planes_of(aovs);
  options.samples = samples;
  options.orientation = orientation;
  options.threads = threads;
  options.secondary = secondary;
  if (background.shape(0) != 2) throw ArgumentError("background must be two colours, (2, 4)");
  for (int c = 0; c < 4; ++c)
    options.background.top[c] = background(0, c), options.background.bottom[c] = background(1, c);
  const raster::SeedBuffers* buffers = seeds ? &seeds->buffers : nullptr;
  const trace::Caster caster = make_caster(mode, scene, camera, buffers);
  view::Frame f;
  {
    nb::gil_scoped_release release;
    f = trace::render(scene.store(), caster, options, &progress);
  }
  const auto h = static_cast<std::size_t>(f.height_px), w = static_cast<std::size_t>(f.width_px);
  nb::dict planes;
  if (options.planes.color) planes["color"] = array(std::move(f.color), {h, w, 4});
  if (options.planes.depth) planes["depth"] = array(std::move(f.depth), {h, w});
  if (options.planes.position) planes["position"] = array(std::move(f.position), {h, w, 3});
  if (options.planes.normal) planes["normal"] = array(std::move(f.normal), {h, w, 3});
  if (options.planes.uv) planes["uv"] = array(std::move(f.uv), {h, w, 2});
  if (options.planes.face) planes["face"] = array(std::move(f.face), {h, w});
  if (options.planes.instance) planes["instance"] = array(std::move(f.instance), {h, w});
  if (options.planes.time) planes["time"] = array(std::move(f.time), {h, w});
  return planes;
}

}  // namespace

void bind_trace(nb::module_& m) {
  nb::class_<trace::Progress>(m, "Progress", "Tiles done of a render that another thread waits for.")
      .def(nb::init<>())
      .def_prop_ro("done", [](const trace::Progress& p) { return p.done.load(); })
      .def_prop_ro("total", [](const trace::Progress& p) { return p.total.load(); })
      .def_prop_ro("cancelled", [](const trace::Progress& p) { return p.cancelled.load(); })
      .def("cancel", [](trace::Progress& p) { p.cancelled = true; });
  nb::class_<trace::SecondaryOptions>(m, "SecondaryOptions", "Rays that go on from what a picture shows.")
      .def(nb::init<>())
      .def_rw("shadows", &trace::SecondaryOptions::shadows)
      .def_rw("ambient_occlusion", &trace::SecondaryOptions::ambient_occlusion, "Rays a sample.")
      .def_rw("occlusion_distance", &trace::SecondaryOptions::occlusion_distance, "mm.")
      .def_rw("reflections", &trace::SecondaryOptions::reflections, "Bounces.")
      .def_rw("diagonal", &trace::SecondaryOptions::diagonal, "mm, of the model's bounds.");
  nb::class_<trace::Scene>(m, "Scene", "A store made ready for rays.")
      .def(
          "__init__",
          [](trace::Scene* self, std::shared_ptr<nurbs::NurbsStore> store, int threads) {
            nb::gil_scoped_release release;
            new (self) trace::Scene(std::move(store), threads);
          },
          nb::arg("store"), nb::arg("threads") = 0)
      .def_prop_ro("bytes", [](const trace::Scene& s) { return s.stats().bytes; })
      .def_prop_ro("leaf_boxes", [](const trace::Scene& s) { return s.stats().leaf_boxes; })
      .def_prop_ro("build_seconds", [](const trace::Scene& s) { return s.stats().build_seconds; })
      .def("cast", &cast, nb::arg("org"), nb::arg("dir"), nb::arg("tmin"), nb::arg("tmax"),
           nb::arg("reference") = false, nb::arg("threads") = 0,
           "Nearest hits: t (n,), face (n,), instance (n,), uv (n, 2), normal (n, 3).")
      .def("count_hits", &count_hits, nb::arg("org"), nb::arg("dir"), nb::arg("tmin"), nb::arg("tmax"),
           nb::arg("reference") = false, nb::arg("threads") = 0, "Crossings per ray, (n,) int32.")
      .def("render", &render, nb::arg("camera"), nb::arg("aovs"), nb::arg("samples"), nb::arg("background"),
           nb::arg("orientation"), nb::arg("mode"), nb::arg("threads"), nb::arg("progress"),
           nb::arg("seeds").none() = nb::none(), nb::arg("secondary") = trace::SecondaryOptions{},
           "mode: hybrid, standard or reference; seeds: of the same camera, for hybrid. Planes of a picture "
           "by name, each (height, width[, channels]).");
}

}  // namespace trimray::bind
