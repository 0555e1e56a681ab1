// Seeds are a hint: whatever they say, the hits stay those of Scene::cast, bit
// by bit.
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/core/hybrid/picture.h"

namespace trimray::hybrid {
namespace {

using raster::SeedBuffers;
using raster::SeedProcess;
using raster::SeedTarget;
using testing::all_cameras;
using testing::all_scenes;
using testing::expect_hybrid;
using testing::NamedScene;
using testing::Picture;
using testing::Random;
using testing::standard_picture;

const std::vector<NamedScene>& scenes() {
  static const std::vector<NamedScene> all = all_scenes();
  return all;
}

// SeedBuffers and the memory that they look at.
struct Seeds {
  std::vector<std::uint32_t> id;
  std::vector<float> uv;
  SeedBuffers buffers;

  Seeds(SeedProcess process, const view::Camera& camera) {
    const std::size_t pixels = static_cast<std::size_t>(camera.width_px) * camera.height_px;
    buffers.process = process;
    buffers.width_px = camera.width_px, buffers.height_px = camera.height_px;
    id.assign(pixels, 0);
    if (process == SeedProcess::kUv) uv.assign(2 * pixels, 0.5f);
    look();
  }
  Seeds(const Seeds&) = delete;
  void look() { buffers.id = id, buffers.uv = uv; }

  void set(std::size_t pixel, std::int32_t instance, std::int32_t face, float u, float v) {
    buffers.targets.push_back({instance, face, u, v});
    id[pixel] = static_cast<std::uint32_t>(buffers.targets.size());
    if (buffers.process == SeedProcess::kUv) uv[2 * pixel] = u, uv[2 * pixel + 1] = v;
  }
};

// What a perfect raster pass would see; `shift` pixels away.
void set_right(Seeds& seeds, const nurbs::NurbsStore& store, const Picture& centres, std::size_t shift) {
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const trace::Hit& hit = centres[(i + shift) % centres.size()];
    if (hit.face == kNoFace) continue;
    const Box2& box = store.faces[hit.face].uv_box;
    const dvec2 at = (hit.uv_face - box.lower) / box.extent();
    seeds.set(i, hit.instance, hit.face, static_cast<float>(at.x), static_cast<float>(at.y));
  }
}

float any_fraction(Random& random) {
  switch (random.below(8)) {
    case 0:
      return NAN;
    case 1:
      return random.chance(0.5) ? INFINITY : -INFINITY;
    case 2:
      return static_cast<float>(random.between(-1.0, 1.0) * random.log_between(1.0, 1e38));
    case 3:
      return random.chance(0.5) ? 0.0f : 1.0f;
    default:
      return static_cast<float>(random.between(-0.6, 1.6));
  }
}

std::int32_t any_index(Random& random, std::size_t count) {
  switch (random.below(12)) {
    case 0:
      return -1 - static_cast<std::int32_t>(random.below(3));
    case 1:
      return static_cast<std::int32_t>(count + random.below(3));
    case 2:
      return random.chance(0.5) ? INT32_MAX : INT32_MIN;
    default:
      return static_cast<std::int32_t>(random.below(std::max<std::size_t>(count, 1)));
  }
}

void set_anything(Seeds& seeds, const nurbs::NurbsStore& store, Random& random) {
  for (std::size_t i = 0; i < seeds.id.size(); ++i) {
    if (random.chance(0.1)) continue;
    // Runs of one target, as pictures have them.
    if (i > 0 && seeds.id[i - 1] != 0 && random.chance(0.7)) {
      seeds.id[i] = seeds.id[i - 1];
      if (!seeds.uv.empty())
        seeds.uv[2 * i] = any_fraction(random), seeds.uv[2 * i + 1] = any_fraction(random);
      continue;
    }
    seeds.set(i, any_index(random, store.instances.size()), any_index(random, store.faces.size()),
              any_fraction(random), any_fraction(random));
    if (random.chance(0.05)) seeds.id[i] = random.chance(0.5) ? UINT32_MAX : seeds.id[i] + 1;
    if (random.chance(0.05)) seeds.id[i] = static_cast<std::uint32_t>(random.engine());
  }
}

template <typename Fill>
void expect_hits_despite(unsigned cameras, const Fill& fill, std::uint64_t& seeded) {
  for (const NamedScene& s : scenes()) {
    const auto all = all_cameras(s.bounds, 45, 38);
    for (std::size_t c = 0; c < all.size(); ++c) {
      if (!(cameras >> (c % 6) & 1u)) continue;
      const view::Camera& camera = all[c].camera;
      const Picture centres = standard_picture(s.scene, camera, view::sample_pattern(1));
      for (const int samples : {1, 4}) {
        const std::vector<dvec2> places = view::sample_pattern(samples);
        const Picture expected = samples == 1 ? centres : standard_picture(s.scene, camera, places);
        for (const SeedProcess process : {SeedProcess::kUv, SeedProcess::kId}) {
          Seeds seeds(process, camera);
          fill(seeds, s.scene.store(), centres);
          HybridStats stats;
          expect_hybrid(s.scene, camera, &seeds.buffers, places, 32, 32, expected,
                        s.name + ", " + all[c].name + ", " + std::to_string(samples) + " samples, process " +
                            std::to_string(static_cast<int>(process)),
                        &stats);
          seeded += stats.seeded;
        }
      }
    }
  }
}

TEST(Seeds, RightOnesGiveMostHits) {
  for (const NamedScene& s : scenes()) {
    // Offset surfaces and meshes are found among the leaves alone.
    if (s.name == "empty" || s.name == "mesh" || s.name == "mixed" || s.name == "offset surfaces") continue;
    for (const auto& [name, camera] : all_cameras(s.bounds, 67, 45)) {
      if (name.find("whole") == name.npos) continue;
      const std::vector<dvec2> places = view::sample_pattern(1);
      const Picture expected = standard_picture(s.scene, camera, places);
      for (const SeedProcess process : {SeedProcess::kUv, SeedProcess::kId}) {
        Seeds seeds(process, camera);
        set_right(seeds, s.scene.store(), expected, 0);
        HybridStats with, without;
        expect_hybrid(s.scene, camera, &seeds.buffers, places, 32, 32, expected, s.name + ", " + name, &with);
        expect_hybrid(s.scene, camera, nullptr, places, 32, 32, expected, s.name + ", " + name, &without);
        EXPECT_GT(2 * with.seeded, with.hits) << s.name << ", " << name;
        EXPECT_LE(with.seeded, with.rays) << s.name << ", " << name;
      }
    }
  }
}

TEST(Seeds, RightOnes) {
  std::uint64_t seeded = 0;
  expect_hits_despite(
      0b110101, [](Seeds& s, const auto& store, const Picture& p) { set_right(s, store, p, 0); }, seeded);
  EXPECT_GT(seeded, 50000u);
}

TEST(Seeds, OfOtherPixels) {
  std::uint64_t seeded = 0;
  std::size_t shift = 0;
  expect_hits_despite(
      0b010101, [&](Seeds& s, const auto& store, const Picture& p) { set_right(s, store, p, shift += 131); },
      seeded);
  EXPECT_GT(seeded, 10000u);
}

TEST(Seeds, OfAnotherInstance) {
  std::uint64_t seeded = 0;
  expect_hits_despite(
      0b000101,
      [](Seeds& s, const nurbs::NurbsStore& store, const Picture& p) {
        set_right(s, store, p, 0);
        for (SeedTarget& t : s.buffers.targets)
          t.instance = (t.instance + 1) % static_cast<std::int32_t>(store.instances.size());
      },
      seeded);
  EXPECT_GT(seeded, 1000u);
}

// Of two instances in one place the first counts, and of two faces; seeds name
// the other.
TEST(Seeds, OfTheSecondOfTwoInOnePlace) {
  std::uint64_t seeded = 0;
  expect_hits_despite(
      0b000101,
      [](Seeds& s, const nurbs::NurbsStore& store, const Picture& p) {
        set_right(s, store, p, 0);
        for (SeedTarget& t : s.buffers.targets) {
          if (t.instance + 1 < static_cast<std::int32_t>(store.instances.size()) &&
              store.instances[t.instance + 1].placement.translation ==
                  store.instances[t.instance].placement.translation)
            ++t.instance;
          else if (t.face == 2 && store.faces.size() == 7)  // "sheets"
            t.face = 6;
        }
      },
      seeded);
  EXPECT_GT(seeded, 10000u);
}

TEST(Seeds, OneWrongFaceForAll) {
  std::uint64_t seeded = 0;
  std::int32_t face = 0;
  expect_hits_despite(
      0b000011,
      [&](Seeds& s, const nurbs::NurbsStore& store, const Picture&) {
        ++face;
        for (std::size_t i = 0; i < s.id.size(); ++i)
          s.set(i, 0, face % std::max<std::int32_t>(1, static_cast<std::int32_t>(store.faces.size())),
                0.001f * static_cast<float>(face % 1000), 0.3f);
      },
      seeded);
  EXPECT_GT(seeded, 1000u);
}

TEST(Seeds, OfNoSense) {
  std::uint64_t seeded = 0;
  Random random(31);
  expect_hits_despite(
      0b111111,
      [&](Seeds& s, const nurbs::NurbsStore& store, const Picture&) { set_anything(s, store, random); },
      seeded);
  EXPECT_GT(seeded, 1000u);
}

TEST(Seeds, OfAnotherSizeAreRefused) {
  const NamedScene& s = scenes()[0];
  const view::Camera camera = all_cameras(s.bounds, 67, 45)[0].camera;
  const auto refused = [&](const auto& spoil) {
    for (const SeedProcess process : {SeedProcess::kUv, SeedProcess::kId}) {
      Seeds seeds(process, camera);
      EXPECT_NO_THROW(HybridView(s.scene, camera, &seeds.buffers));
      spoil(seeds);
      EXPECT_THROW(HybridView(s.scene, camera, &seeds.buffers), ArgumentError);
    }
  };
  refused([](Seeds& x) { x.buffers.width_px = 66; });
  refused([](Seeds& x) { x.buffers.height_px = 46; });
  refused([](Seeds& x) { std::swap(x.buffers.width_px, x.buffers.height_px); });
  refused([](Seeds& x) { x.id.pop_back(), x.look(); });
  refused([](Seeds& x) { x.id.push_back(0), x.look(); });
  refused([](Seeds& x) { x.buffers.id = {}; });
  Seeds seeds(SeedProcess::kUv, camera);
  seeds.uv.pop_back(), seeds.look();
  EXPECT_THROW(HybridView(s.scene, camera, &seeds.buffers), ArgumentError);
  seeds.uv.clear(), seeds.look();
  EXPECT_THROW(HybridView(s.scene, camera, &seeds.buffers), ArgumentError);
}

}  // namespace
}  // namespace trimray::hybrid
