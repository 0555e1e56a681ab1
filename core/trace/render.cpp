#include "core/trace/render.h"

#include <time.h>

#include <algorithm>
#include <vector>

#include "core/base/parallel.h"
#include "core/view/sampling.h"

namespace trimray::trace {

namespace {

constexpr std::size_t kMostRays = 1 << 14;  // of a tile, so that its hits stay near the core
constexpr int kTimedTile = 8;               // px: a packet of the standard tracer
// Linear, premultiplied.
struct Light {
  dvec3 rgb{0.0};
  double alpha = 0.0;
  void behind(const dvec3& color, double a) {  // adds a layer behind what is there
    const double share = (1.0 - alpha) * a;
    rgb += share * color, alpha += share;
  }
};

// Of this thread.
double processor_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Renderer {
 public:
  Renderer(const nurbs::NurbsStore& store, const Caster& caster, const RenderOptions& options)
      : caster_(caster),
        options_(options),
        lighting_(options.camera.right, options.camera.up, options.camera.forward),
        pattern_(view::sample_pattern(options.samples)),
        colors_(store),
        secondary_(caster, colors_, lighting_, options.background, options.orientation, options.samples,
                   options.secondary),
        side_(std::max(options.tile, 1)),
        frame_(options.camera.width_px, options.camera.height_px, options.planes) {
    // Secondary rays count, too: a tile is what a wish to stop has to wait for.
    const std::size_t each =
        pattern_.size() * (1 + static_cast<std::size_t>(options.secondary.ambient_occlusion) / 16);
    const auto rays = [&] { return static_cast<std::size_t>(side_) * side_ * each; };
    if (options.planes.time) side_ = std::min(side_, kTimedTile);
    while (side_ > 1 && rays() > kMostRays) side_ = (side_ + 1) / 2;
  }

  // What a thread keeps from tile to tile.
  struct Scratch {
    TileHits hits;
    std::vector<Hit> layers;
    std::vector<Sample> samples;       // of the hits, where there are secondary rays
    std::vector<Surroundings> around;  // of them
    int back_y0 = -1;                  // the row of tiles that `back` and `untouched` are of
    std::vector<view::Color> back;     // of all samples of a row of pixels, then of the next
    std::vector<float> untouched;      // 4 a row: pixels that no ray met anything in
  };

  int side() const { return side_; }

  void tile(int x0, int y0, Scratch& scratch) {
    Tile tile{x0, y0, std::min(x0 + side_, frame_.width_px), std::min(y0 + side_, frame_.height_px),
              pattern_};
    if (options_.planes.color) {
      look_behind(tile, scratch);
      cast(tile, scratch.hits);
      if (options_.secondary.any()) look_around(tile, scratch);
      color(tile, scratch);
    }
    const bool geometric = options_.planes.geometric() || (options_.planes.time && !options_.planes.color);
    if (!geometric) return;
    if (!options_.planes.color || pattern_.size() != 1) {
      tile.places = {&kCentre, 1};
      cast(tile, scratch.hits);
    }
    geometry(tile, scratch.hits);
  }

  view::Frame take() { return std::move(frame_); }

 private:
  static constexpr dvec2 kCentre{0.5, 0.5};

  void cast(const Tile& tile, TileHits& hits) {
    if (!options_.planes.time) return caster_.tile(tile, hits);
    const double start = processor_seconds();
    caster_.tile(tile, hits);
    const int pixels = tile.width() * (tile.y1 - tile.y0);
    const auto ns = static_cast<float>(1e9 * (processor_seconds() - start) / pixels);
    for (int y = tile.y0; y < tile.y1; ++y)
      for (int x = tile.x0; x < tile.x1; ++x) frame_.time[index(x, y)] += ns;
  }

  void look_behind(const Tile& tile, Scratch& scratch) const {
    if (scratch.back_y0 == tile.y0) return;
    scratch.back_y0 = tile.y0;
    scratch.back.clear(), scratch.untouched.clear();
    for (int y = tile.y0; y < tile.y1; ++y) {
      Light light;
      for (const dvec2& place : pattern_) {
        scratch.back.push_back(options_.background.at((y + place.y) / frame_.height_px));
        add(seen(scratch.back.back()), light);
      }
      float encoded[4];
      encode(light, encoded);
      scratch.untouched.insert(scratch.untouched.end(), encoded, encoded + 4);
    }
  }

  void look_around(const Tile& tile, Scratch& scratch) const {
    scratch.samples.clear();
    const auto places = static_cast<std::int32_t>(tile.places.size());
    for (std::size_t i = 0; i < scratch.hits.ray.size(); ++i) {
      const std::int32_t pixel = scratch.hits.ray[i] / places, number = scratch.hits.ray[i] % places;
      const int x = tile.x0 + pixel % tile.width(), y = tile.y0 + pixel / tile.width();
      scratch.samples.push_back({x, y, number, ray(x, y, pattern_[number]), scratch.hits.hit[i]});
    }
    secondary_.light(scratch.samples, scratch.around);
  }

  void color(const Tile& tile, Scratch& scratch) {
    for (int y = tile.y0; y < tile.y1; ++y) {
      const float* untouched = &scratch.untouched[4 * static_cast<std::size_t>(y - tile.y0)];
      float* row = &frame_.color[4 * index(tile.x0, y)];
      for (int x = tile.x0; x < tile.x1; ++x, row += 4) std::copy_n(untouched, 4, row);
    }
    const TileHits& hits = scratch.hits;
    const auto samples = static_cast<std::int32_t>(pattern_.size());
    Light last{dvec3(-1.0), -1.0};
    float encoded[4];
    for (std::size_t i = 0; i < hits.ray.size();) {
      const std::int32_t pixel = hits.ray[i] / samples;
      const int row = pixel / tile.width(), x = tile.x0 + pixel % tile.width(), y = tile.y0 + row;
      const view::Color* back = &scratch.back[static_cast<std::size_t>(row) * samples];
      Light light;
      for (std::int32_t s = 0; s < samples; ++s) {
        if (i < hits.ray.size() && hits.ray[i] == pixel * samples + s) {
          const Surroundings* around = scratch.around.empty() ? nullptr : &scratch.around[i];
          add(seen(ray(x, y, pattern_[s]), hits.hit[i], back[s], around, scratch.layers), light);
          ++i;
        } else {
          add(seen(back[s]), light);
        }
      }
      // Flat faces give equal light over and over: the encoding costs more than the asking.
      if (light.rgb != last.rgb || light.alpha != last.alpha) encode(light, encoded);
      last = light;
      std::copy_n(encoded, 4, &frame_.color[4 * index(x, y)]);
    }
  }

  void geometry(const Tile& tile, const TileHits& hits) {
    for (std::size_t i = 0; i < hits.ray.size(); ++i) {
      const int x = tile.x0 + hits.ray[i] % tile.width(), y = tile.y0 + hits.ray[i] / tile.width();
      write_geometry(x, y, hits.hit[i]);
    }
  }

  Ray ray(int x, int y, const dvec2& place) const {
    const view::CameraRay ray = options_.camera.ray(x + place.x, y + place.y);
    return {ray.org, ray.dir, 0.0, kInf};
  }

  static void add(const Light& sample, Light& sum) { sum.rgb += sample.rgb, sum.alpha += sample.alpha; }

  // One sample: the face, whatever shines through it, and the background.
  // around: what comes to it beyond the lamps' own light, or null.
  Light seen(const Ray& ray, const Hit& hit, const view::Color& back, const Surroundings* around,
             std::vector<Hit>& layers) const {
    Light light;
    const view::Color& color = colors_.of(hit);
    const view::Visibility visibility = around ? around->visibility : view::Visibility{};
    const dvec3 shaded =
        view::shade(lighting_, hit.normal, ray.dir, color.rgb, options_.orientation, visibility);
    light.behind(around ? around->over(shaded) : shaded, opacity(color));
    if (light.alpha < kOpaque) {
      layers.clear();
      caster_.all(ray, layers);
      for (const Hit& layer : layers) {
        if (!(layer.t > hit.t) || light.alpha >= kOpaque) continue;
        const view::Color& c = colors_.of(layer);
        light.behind(view::shade(lighting_, layer.normal, ray.dir, c.rgb, options_.orientation), opacity(c));
      }
    }
    light.behind(back.rgb, back.alpha);
    return light;
  }

  // A sample that met nothing.
  static Light seen(const view::Color& back) {
    Light light;
    light.behind(back.rgb, back.alpha);
    return light;
  }

  // The mean of a pixel's samples, given their sum.
  void encode(const Light& sum, float out[4]) const {
    const double alpha = sum.alpha / static_cast<double>(pattern_.size());
    for (int c = 0; c < 3; ++c) {
      out[c] = sum.alpha > 0.0 ? view::srgb_float_from_linear(sum.rgb[c] / sum.alpha) : 0.0f;
    }
    out[3] = static_cast<float>(std::min(alpha, 1.0));
  }

  void write_geometry(int x, int y, const Hit& hit) {
    const std::size_t i = index(x, y);
    if (options_.planes.depth) frame_.depth[i] = hit.t;
    if (options_.planes.position) {
      const Ray r = ray(x, y, kCentre);
      const dvec3 p = r.org + hit.t * r.dir;
      for (int c = 0; c < 3; ++c) frame_.position[3 * i + c] = p[c];
    }
    for (int c = 0; c < 3 && options_.planes.normal; ++c) frame_.normal[3 * i + c] = hit.normal[c];
    for (int c = 0; c < 2 && options_.planes.uv; ++c) frame_.uv[2 * i + c] = hit.uv_face[c];
    if (options_.planes.face) frame_.face[i] = hit.face;
    if (options_.planes.instance) frame_.instance[i] = hit.instance;
  }

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * frame_.width_px + x; }

  const Caster& caster_;
  const RenderOptions& options_;
  view::Lighting lighting_;
  std::vector<dvec2> pattern_;
  FaceColors colors_;
  Secondary secondary_;
  int side_ = 1;
  view::Frame frame_;
};

}  // namespace

view::Frame render(const nurbs::NurbsStore& store, const Caster& caster, const RenderOptions& options,
                   Progress* progress) {
  Renderer renderer(store, caster, options);
  const int side = renderer.side();
  const int columns = (options.camera.width_px + side - 1) / side;
  const int rows = (options.camera.height_px + side - 1) / side;
  const std::size_t tiles = static_cast<std::size_t>(columns) * rows;
  if (progress) progress->total = static_cast<std::int64_t>(tiles);
  PerThread<Renderer::Scratch> scratch;
  parallel_ranges(tiles, 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (progress && progress->cancelled) return;
      renderer.tile(static_cast<int>(i % columns) * side, static_cast<int>(i / columns) * side,
                    scratch.local());
      if (progress) ++progress->done;
    }
  });
  return renderer.take();
}

}  // namespace trimray::trace
