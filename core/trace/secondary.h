// Secondary rays: shadows, ambient occlusion and reflections of what a tile's rays have met.
#pragma once

#include <span>
#include <vector>

#include "core/trace/caster.h"
#include "core/trace/face_colors.h"
#include "core/view/shade.h"

namespace trimray::trace {

struct SecondaryOptions {
  bool shadows = false;
  int ambient_occlusion = 0;        // rays a sample; 0: none
  double occlusion_distance = 0.0;  // mm; what is farther away occludes nothing
  int reflections = 0;              // bounces; 0: none
  double diagonal = 0.0;            // mm, of the model's bounds: what the tolerance of hits is a fraction of
  bool any() const { return shadows || ambient_occlusion > 0 || reflections > 0; }
};

// A ray of the picture that met something.
struct Sample {
  int x = 0, y = 0;  // its pixel
  int number = 0;    // among the samples of the pixel
  Ray ray;
  Hit hit;
};

// What comes to a surface point beyond the lamps' own light.
struct Surroundings {
  view::Visibility visibility;
  dvec3 reflected{0.0};  // linear
  double reflectance = 0.0;
  // Of the light that the point sends back by itself.
  dvec3 over(const dvec3& shaded) const { return glm::mix(shaded, reflected, reflectance); }
};

// Thread-safe; everything must outlive it.
class Secondary {
 public:
  Secondary(const Caster& caster, const FaceColors& colors, const view::Lighting& lighting,
            const view::Background& background, bool orientation, int samples,
            const SecondaryOptions& options);

  // out[i]: of samples[i]. The same for any grouping of the samples, and any number of threads.
  void light(std::span<const Sample> samples, std::vector<Surroundings>& out) const;

 private:
  struct Batch;
  Ray leaving(const Sample& from, const dvec3& dir, double tmax) const;
  void cast(Batch& batch) const;
  void shadows(std::span<const Sample> samples, const dvec3& lamp, double view::Visibility::*lit,
               Surroundings* out) const;
  void occlusion(std::span<const Sample> samples, Surroundings* out) const;
  void reflections(std::span<const Sample> samples, int bounces, Surroundings* out) const;
  double through(const Ray& ray, const Hit& first) const;
  dvec3 around(const dvec3& dir) const;

  const Caster& caster_;
  const FaceColors& colors_;
  const view::Lighting& lighting_;
  const view::Background& background_;
  bool orientation_;
  int samples_;
  SecondaryOptions options_;
};

}  // namespace trimray::trace
