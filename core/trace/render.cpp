#include "core/trace/render.h"

#include <algorithm>
#include <array>

#include "core/base/parallel.h"
#include "core/view/sampling.h"

namespace trimray::trace {

namespace {

constexpr int kTile = 32;                              // px along each side: 1024 neighbouring rays a packet
constexpr float kNeutral[4] = {0.79f, 0.81f, 0.84f, 1.0f};  // light steel

constexpr double kOpaque = 1.0 - 1.0 / 512.0;  // what an 8-bit picture cannot tell from opaque

// Linear, premultiplied.
struct Light {
  dvec3 rgb{0.0};
  double alpha = 0.0;
  void behind(const dvec3& color, double a) {  // adds a layer behind what is there
    const double share = (1.0 - alpha) * a;
    rgb += share * color, alpha += share;
  }
};

class Renderer {
 public:
  Renderer(const nurbs::NurbsStore& store, const Caster& caster, const RenderOptions& options)
      : store_(store), caster_(caster), options_(options),
        lighting_(options.camera.right, options.camera.up, options.camera.forward),
        pattern_(view::sample_pattern(options.samples)),
        frame_(options.camera.width_px, options.camera.height_px, options.planes) {
    face_colors_.resize(store.faces.size());
    for (std::size_t i = 0; i < store.faces.size(); ++i) {
      if (store.faces[i].has_color()) face_colors_[i] = view::linear_color(store.faces[i].color);
    }
    instance_colors_.resize(store.instances.size());
    for (std::size_t i = 0; i < store.instances.size(); ++i) {
      float srgb[4];
      face_color(store, kNoFace, static_cast<std::int32_t>(i), srgb);
      instance_colors_[i] = view::linear_color(srgb);
    }
  }

  void tile(int x0, int y0) {
    const int x1 = std::min(x0 + kTile, frame_.width_px), y1 = std::min(y0 + kTile, frame_.height_px);
    const std::size_t pixels = static_cast<std::size_t>(x1 - x0) * (y1 - y0);
    std::vector<Ray> rays(pixels);
    std::vector<Hit> hits(pixels);
    std::vector<Light> light(options_.planes.color ? pixels : 0);
    std::vector<Hit> layers;
    const auto cast_at = [&](const dvec2& place) {
      std::size_t i = 0;
      for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x, ++i) {
          const view::CameraRay r = options_.camera.ray(x + place.x, y + place.y);
          rays[i] = {r.org, r.dir, 0.0, kInf};
          hits[i] = {};
        }
      }
      caster_.nearest(rays, hits);
    };
    if (options_.planes.color) {
      for (const dvec2& place : pattern_) {
        cast_at(place);
        std::size_t i = 0;
        for (int y = y0; y < y1; ++y) {
          const view::Color back = options_.background.at((y + place.y) / frame_.height_px);
          for (int x = x0; x < x1; ++x, ++i) add(seen(rays[i], hits[i], back, layers), light[i]);
        }
      }
      std::size_t i = 0;
      for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x, ++i) write_color(x, y, light[i]);
      }
    }
    if (!options_.planes.geometric()) return;
    if (!options_.planes.color || pattern_.size() != 1) cast_at({0.5, 0.5});
    std::size_t i = 0;
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x, ++i) write_geometry(x, y, rays[i], hits[i]);
    }
  }

  view::Frame take() { return std::move(frame_); }

 private:
  static void add(const Light& sample, Light& sum) { sum.rgb += sample.rgb, sum.alpha += sample.alpha; }

  const view::Color& color_of(const Hit& hit) const {
    return store_.faces[hit.face].has_color() ? face_colors_[hit.face] : instance_colors_[hit.instance];
  }

  // One sample: the face, whatever shines through it, and the background.
  Light seen(const Ray& ray, const Hit& hit, const view::Color& back, std::vector<Hit>& layers) const {
    Light light;
    if (hit.face != kNoFace) {
      const view::Color& color = color_of(hit);
      light.behind(view::shade(lighting_, hit.normal, ray.dir, color.rgb, options_.orientation), opacity(color));
      if (light.alpha < kOpaque) {
        layers.clear();
        caster_.all(ray, layers);
        for (const Hit& layer : layers) {
          if (!(layer.t > hit.t) || light.alpha >= kOpaque) continue;
          const view::Color& c = color_of(layer);
          light.behind(view::shade(lighting_, layer.normal, ray.dir, c.rgb, options_.orientation), opacity(c));
        }
      }
    }
    light.behind(back.rgb, back.alpha);
    return light;
  }

  static double opacity(const view::Color& color) { return color.alpha >= kOpaque ? 1.0 : color.alpha; }

  void write_color(int x, int y, const Light& sum) {
    float* out = &frame_.color[4 * index(x, y)];
    const double alpha = sum.alpha / static_cast<double>(pattern_.size());
    for (int c = 0; c < 3; ++c) {
      out[c] = sum.alpha > 0.0 ? static_cast<float>(view::srgb_from_linear(sum.rgb[c] / sum.alpha)) : 0.0f;
    }
    out[3] = static_cast<float>(std::min(alpha, 1.0));
  }

  void write_geometry(int x, int y, const Ray& ray, const Hit& hit) {
    if (hit.face == kNoFace) return;
    const std::size_t i = index(x, y);
    if (options_.planes.depth) frame_.depth[i] = hit.t;
    const dvec3 p = ray.org + hit.t * ray.dir;
    for (int c = 0; c < 3; ++c) {
      if (options_.planes.position) frame_.position[3 * i + c] = p[c];
      if (options_.planes.normal) frame_.normal[3 * i + c] = hit.normal[c];
    }
    for (int c = 0; c < 2 && options_.planes.uv; ++c) frame_.uv[2 * i + c] = hit.uv_face[c];
    if (options_.planes.face) frame_.face[i] = hit.face;
    if (options_.planes.instance) frame_.instance[i] = hit.instance;
  }

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * frame_.width_px + x; }

  const nurbs::NurbsStore& store_;
  const Caster& caster_;
  const RenderOptions& options_;
  view::Lighting lighting_;
  std::vector<dvec2> pattern_;
  view::Frame frame_;
  std::vector<view::Color> face_colors_, instance_colors_;
};

}  // namespace

view::Frame render(const nurbs::NurbsStore& store, const Caster& caster, const RenderOptions& options,
                   Progress* progress) {
  Renderer renderer(store, caster, options);
  const int columns = (options.camera.width_px + kTile - 1) / kTile;
  const int rows = (options.camera.height_px + kTile - 1) / kTile;
  const std::size_t tiles = static_cast<std::size_t>(columns) * rows;
  if (progress) progress->total = static_cast<std::int64_t>(tiles);
  parallel_ranges(tiles, 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (progress && progress->cancelled) return;
      renderer.tile(static_cast<int>(i % columns) * kTile, static_cast<int>(i / columns) * kTile);
      if (progress) ++progress->done;
    }
  });
  return renderer.take();
}

void face_color(const nurbs::NurbsStore& store, std::int32_t face, std::int32_t instance, float srgb[4]) {
  const float* color = kNeutral;
  if (face != kNoFace && store.faces[face].has_color()) {
    color = store.faces[face].color;
  } else if (instance >= 0) {
    const nurbs::Instance& placed = store.instances[instance];
    const nurbs::Prototype& prototype = store.prototypes[placed.prototype];
    if (placed.color[0] >= 0.0f) color = placed.color;
    else if (prototype.color[0] >= 0.0f) color = prototype.color;
  }
  std::copy_n(color, 4, srgb);
}

}  // namespace trimray::trace
