#include "core/trace/secondary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/tolerance.h"

namespace trimray::trace {

namespace {

constexpr std::size_t kSamplesAtOnce = 1024;  // so that their rays stay in cache
constexpr double kReflectance = 0.16;         // of polished parts, seen straight on
constexpr double kLargestBand = 1e-4;         // as a fraction of the diagonal

// The normal on the side that the ray comes from.
dvec3 facing(const Sample& s) {
  return glm::dot(s.hit.normal, s.ray.dir) > 0.0 ? -s.hit.normal : s.hit.normal;
}

double fraction(double x) { return x - std::floor(x); }

// A number in [0, 1) that is a pixel's own.
double noise(int x, int y) {
  auto h = static_cast<std::uint32_t>(x) * 0x9e3779b1u ^ static_cast<std::uint32_t>(y) * 0x85ebca77u;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return (h ^ (h >> 15)) * 0x1p-32;
}

// Two axes that make an orthonormal frame with n (Duff et al., Building an Orthonormal Basis, Revisited,
// 2017).
void axes_of(const dvec3& n, dvec3& a, dvec3& b) {
  const double sign = std::copysign(1.0, n.z), f = -1.0 / (sign + n.z), g = n.x * n.y * f;
  a = {1.0 + sign * n.x * n.x * f, sign * g, -sign * n.x};
  b = {g, sign + n.y * n.y * f, -n.y};
}

}  // namespace

// Rays that go on from samples, and which.
struct Secondary::Batch {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<std::size_t> of;

  void clear() { rays.clear(), of.clear(); }
  void add(const Ray& ray, std::size_t sample) { rays.push_back(ray), of.push_back(sample); }
};

Secondary::Secondary(const Caster& caster, const FaceColors& colors, const view::Lighting& lighting,
                     const view::Background& background, bool orientation, int samples,
                     const SecondaryOptions& options)
    : caster_(caster),
      colors_(colors),
      lighting_(lighting),
      background_(background),
      orientation_(orientation),
      samples_(samples),
      options_(options) {}

void Secondary::light(std::span<const Sample> samples, std::vector<Surroundings>& out) const {
  out.assign(samples.size(), {});
  for (std::size_t begin = 0; begin < samples.size(); begin += kSamplesAtOnce) {
    const auto part = samples.subspan(begin, std::min(kSamplesAtOnce, samples.size() - begin));
    if (options_.shadows) {
      shadows(part, lighting_.key, &view::Visibility::key, &out[begin]);
      shadows(part, lighting_.fill, &view::Visibility::fill, &out[begin]);
    }
    if (options_.ambient_occlusion > 0) occlusion(part, &out[begin]);
    if (options_.reflections > 0) reflections(part, options_.reflections, &out[begin]);
  }
}

// A hit may be off by the promised tolerance, along its ray: the new ray starts a few times as far outside of
// the surface, which it then does not meet again unless the surface bends towards it.
Ray Secondary::leaving(const Sample& from, const dvec3& dir, double tmax) const {
  const dvec3 p = from.ray.org + from.hit.t * from.ray.dir;
  const double rounding = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) * 0x1p-49;
  return {p + (4.0 * kHitTol * options_.diagonal + rounding) * facing(from), dir, 0.0, tmax};
}

// Within an edge's band a hit may lie a little outside of its own face, and so behind the neighbouring one:
// what a ray meets on its first steps, not longer than the bands are wide, may be the surface that it leaves.
void Secondary::cast(Batch& batch) const {
  batch.hits.resize(batch.rays.size());
  caster_.nearest(batch.rays, batch.hits);
  const double band = std::min(caster_.edge_band, kLargestBand * options_.diagonal);
  std::vector<Ray> again;
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < batch.hits.size(); ++i) {
    if (batch.hits[i].face == kNoFace || batch.hits[i].t >= band) continue;
    batch.rays[i].tmin = band;
    again.push_back(batch.rays[i]), which.push_back(i);
  }
  if (again.empty()) return;
  std::vector<Hit> hits(again.size());
  caster_.nearest(again, hits);
  for (std::size_t i = 0; i < which.size(); ++i) batch.hits[which[i]] = hits[i];
}

// What part of a lamp's light comes through all that the ray meets.
double Secondary::through(const Ray& ray, const Hit& first) const {
  double left = 1.0 - opacity(colors_.of(first));
  if (left <= 0.0) return 0.0;
  std::vector<Hit> all;
  caster_.all(ray, all);
  for (const Hit& hit : all)
    if (hit.t > first.t) left *= 1.0 - opacity(colors_.of(hit));
  return left;
}

void Secondary::shadows(std::span<const Sample> samples, const dvec3& lamp, double view::Visibility::*lit,
                        Surroundings* out) const {
  Batch batch;
  // A surface that is turned away from a lamp is not in a shadow: its shade fades by itself.
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (glm::dot(facing(samples[i]), lamp) > 0.0) batch.add(leaving(samples[i], lamp, kInf), i);
  cast(batch);
  for (std::size_t i = 0; i < batch.hits.size(); ++i)
    if (batch.hits[i].face != kNoFace)
      out[batch.of[i]].visibility.*lit = through(batch.rays[i], batch.hits[i]);
}

// Directions denser about the normal, by the cosine; the nearer what they meet, the more it occludes. All
// samples of a pixel share one low-discrepancy pattern (Martin Roberts's R2 over the pixels).
void Secondary::occlusion(std::span<const Sample> samples, Surroundings* out) const {
  const int rays = options_.ambient_occlusion;
  Batch batch;
  std::vector<double> occluded(samples.size(), 0.0);
  for (int k = 0; k < rays; ++k) {
    batch.clear();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Sample& s = samples[i];
      const double n = static_cast<double>(s.number) * rays + k;
      const double u = fraction((n + 0.5) / (static_cast<double>(rays) * samples_) +
                                0.7548776662466927 * s.x + 0.5698402909980532 * s.y);
      const double angle = 2.0 * std::numbers::pi * fraction(n * (std::numbers::phi - 1.0) + noise(s.x, s.y));
      const dvec3 normal = facing(s);
      dvec3 a, b;
      axes_of(normal, a, b);
      const double r = std::sqrt(u);
      const dvec3 dir = r * std::cos(angle) * a + r * std::sin(angle) * b + std::sqrt(1.0 - u) * normal;
      batch.add(leaving(s, glm::normalize(dir), options_.occlusion_distance), i);
    }
    cast(batch);
    for (std::size_t i = 0; i < batch.hits.size(); ++i) {
      const Hit& hit = batch.hits[i];
      if (hit.face != kNoFace)
        occluded[batch.of[i]] += (1.0 - hit.t / options_.occlusion_distance) * opacity(colors_.of(hit));
    }
  }
  for (std::size_t i = 0; i < samples.size(); ++i) out[i].visibility.ambient = 1.0 - occluded[i] / rays;
}

void Secondary::reflections(std::span<const Sample> samples, int bounces, Surroundings* out) const {
  Batch batch;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& s = samples[i];
    const dvec3 n = facing(s);
    const double cosine = std::clamp(-glm::dot(n, s.ray.dir), 0.0, 1.0), away = 1.0 - cosine;
    // Schlick, An Inexpensive BRDF Model for Physically-Based Rendering, 1994.
    out[i].reflectance = kReflectance + (1.0 - kReflectance) * away * away * away * away * away;
    batch.add(leaving(s, glm::normalize(s.ray.dir + 2.0 * cosine * n), kInf), i);
  }
  cast(batch);
  std::vector<Sample> met;
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    out[i].reflected = around(batch.rays[i].dir);
    if (batch.hits[i].face == kNoFace) continue;
    met.push_back({samples[i].x, samples[i].y, samples[i].number, batch.rays[i], batch.hits[i]});
    of.push_back(i);
  }
  if (met.empty()) return;
  std::vector<Surroundings> there(met.size());
  if (options_.shadows) {
    shadows(met, lighting_.key, &view::Visibility::key, there.data());
    shadows(met, lighting_.fill, &view::Visibility::fill, there.data());
  }
  if (bounces > 1) reflections(met, bounces - 1, there.data());
  for (std::size_t i = 0; i < met.size(); ++i) {
    const Sample& s = met[i];
    const view::Color& color = colors_.of(s.hit);
    const dvec3 shaded =
        view::shade(lighting_, s.hit.normal, s.ray.dir, color.rgb, orientation_, there[i].visibility);
    out[of[i]].reflected = glm::mix(out[of[i]].reflected, there[i].over(shaded), opacity(color));
  }
}

// What a part stands in: the picture's background all around it, white where that is transparent.
dvec3 Secondary::around(const dvec3& dir) const {
  const view::Color back = background_.at(0.5 - 0.5 * glm::dot(dir, lighting_.up));
  return glm::mix(dvec3(1.0), back.rgb, back.alpha);
}

}  // namespace trimray::trace
