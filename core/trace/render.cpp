#include "core/trace/render.h"

#include <algorithm>
#include <array>

#include "core/base/parallel.h"
#include "core/view/sampling.h"

namespace trimray::trace {

namespace {

constexpr int kTile = 32;  // px along each side, a power of two
constexpr std::size_t kRaysAtOnce =
    512;  // of a tile, so that they stay in cache; more only where one pixel has more
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
      : store_(store),
        caster_(caster),
        options_(options),
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
    std::vector<Pixel> pixels;
    pixels.reserve(order_.size());
    for (const Pixel& p : order_) {
      if (x0 + p.x < frame_.width_px && y0 + p.y < frame_.height_px) pixels.push_back({x0 + p.x, y0 + p.y});
    }
    Rays rays;
    if (options_.planes.color) {
      std::vector<view::Color> back;  // of all samples of a row of pixels, then of the next
      for (int y = y0; y < std::min(y0 + kTile, frame_.height_px); ++y) {
        for (const dvec2& place : pattern_)
          back.push_back(options_.background.at((y + place.y) / frame_.height_px));
      }
      for_portions(pixels, pattern_, rays,
                   [&](std::span<const Pixel> portion) { color(portion, rays, y0, back); });
    }
    const bool seen_centres = options_.planes.color && pattern_.size() == 1;
    if (!options_.planes.geometric() || seen_centres) return;
    const std::vector<dvec2> centre{{0.5, 0.5}};
    for_portions(pixels, centre, rays, [&](std::span<const Pixel> portion) { geometry(portion, rays); });
  }

  view::Frame take() { return std::move(frame_); }

 private:
  struct Pixel {
    int x = 0, y = 0;
  };
  // All rays of the first pixel, then all of the second.
  struct Rays {
    std::vector<Ray> rays;
    std::vector<Hit> hits, layers;
  };

  // The pixels of a tile along the Z-order curve: any 64 rays in a row, a packet, stay within a small square,
  // with the samples of a pixel side by side.
  static std::vector<Pixel> z_order() {
    std::vector<Pixel> order(kTile * kTile);
    for (int i = 0; i < kTile * kTile; ++i) {
      for (int b = 0; (1 << b) < kTile; ++b) {
        order[i].x |= ((i >> (2 * b)) & 1) << b, order[i].y |= ((i >> (2 * b + 1)) & 1) << b;
      }
    }
    return order;
  }

  template <typename Use>
  void for_portions(std::span<const Pixel> pixels, const std::vector<dvec2>& places, Rays& r,
                    const Use& use) const {
    const std::size_t most = std::max<std::size_t>(kRaysAtOnce / places.size(), 1);
    for (std::size_t begin = 0; begin < pixels.size(); begin += most) {
      const auto portion = pixels.subspan(begin, std::min(most, pixels.size() - begin));
      r.rays.clear();
      r.rays.reserve(portion.size() * places.size());
      for (const Pixel& p : portion) {
        for (const dvec2& place : places) {
          const view::CameraRay ray = options_.camera.ray(p.x + place.x, p.y + place.y);
          r.rays.push_back({ray.org, ray.dir, 0.0, kInf});
        }
      }
      r.hits.assign(r.rays.size(), {});
      caster_.nearest(r.rays, r.hits);
      use(portion);
    }
  }

  void color(std::span<const Pixel> pixels, Rays& r, int y0, std::span<const view::Color> back) {
    const std::size_t samples = pattern_.size();
    std::size_t i = 0;
    Light last{dvec3(-1.0), -1.0};
    float encoded[4];
    for (const Pixel& p : pixels) {
      Light light;
      for (std::size_t s = 0; s < samples; ++s, ++i) {
        add(seen(r.rays[i], r.hits[i], back[(p.y - y0) * samples + s], r.layers), light);
      }
      // Flat faces and backgrounds give equal light over and over: the encoding costs more than the asking.
      if (light.rgb != last.rgb || light.alpha != last.alpha) encode(light, encoded);
      last = light;
      std::copy_n(encoded, 4, &frame_.color[4 * index(p.x, p.y)]);
    }
    if (pattern_.size() == 1) geometry(pixels, r);
  }

  void geometry(std::span<const Pixel> pixels, const Rays& r) {
    if (!options_.planes.geometric()) return;
    for (std::size_t i = 0; i < pixels.size(); ++i)
      write_geometry(pixels[i].x, pixels[i].y, r.rays[i], r.hits[i]);
  }

  static void add(const Light& sample, Light& sum) { sum.rgb += sample.rgb, sum.alpha += sample.alpha; }

  const view::Color& color_of(const Hit& hit) const {
    return store_.faces[hit.face].has_color() ? face_colors_[hit.face] : instance_colors_[hit.instance];
  }

  // One sample: the face, whatever shines through it, and the background.
  Light seen(const Ray& ray, const Hit& hit, const view::Color& back, std::vector<Hit>& layers) const {
    Light light;
    if (hit.face != kNoFace) {
      const view::Color& color = color_of(hit);
      light.behind(view::shade(lighting_, hit.normal, ray.dir, color.rgb, options_.orientation),
                   opacity(color));
      if (light.alpha < kOpaque) {
        layers.clear();
        caster_.all(ray, layers);
        for (const Hit& layer : layers) {
          if (!(layer.t > hit.t) || light.alpha >= kOpaque) continue;
          const view::Color& c = color_of(layer);
          light.behind(view::shade(lighting_, layer.normal, ray.dir, c.rgb, options_.orientation),
                       opacity(c));
        }
      }
    }
    light.behind(back.rgb, back.alpha);
    return light;
  }

  static double opacity(const view::Color& color) { return color.alpha >= kOpaque ? 1.0 : color.alpha; }

  // The mean of a pixel's samples, given their sum.
  void encode(const Light& sum, float out[4]) const {
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
  const std::vector<Pixel> order_ = z_order();
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
    if (placed.color[0] >= 0.0f)
      color = placed.color;
    else if (prototype.color[0] >= 0.0f)
      color = prototype.color;
  }
  std::copy_n(color, 4, srgb);
}

}  // namespace trimray::trace
