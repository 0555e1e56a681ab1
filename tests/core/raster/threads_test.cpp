// Draws from several threads, before and after a fork, and with backends that are not there.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <functional>
#include <thread>

#include "core/base/error.h"
#include "raster/dynamic_library.h"
#include "tests/core/raster/scenes.h"

namespace trimray::raster::testing {
namespace {

bool equal(const SeedBuffers& a, const SeedBuffers& b) {
  if (a.id.size() != b.id.size() || a.targets.size() != b.targets.size()) return false;
  for (std::size_t i = 0; i < a.id.size(); ++i) {
    if (a.id[i] != b.id[i]) return false;
    // uv of what nothing covers is not set.
    if (!a.uv.empty() && a.id[i] != 0 && std::memcmp(&a.uv[2 * i], &b.uv[2 * i], 2 * sizeof(float)) != 0)
      return false;
  }
  return true;
}

// A view that is fine enough for several batches.
struct Scene {
  std::shared_ptr<NurbsStore> store = placed(ring_and_ball(), {at(dvec3(0.0)), turned({1, 1, 1}, 1.0)});
  Camera c = camera(300, 200, 0.02);
  tess::ViewMeshes meshes = tess::MeshLevels(store).meshes(c, 0.02);

  SeedBuffers draw(Rasterizer& r, SeedProcess process = SeedProcess::kUv, int threads = 0) const {
    return r.draw(meshes, *store, c, process, threads);
  }
};

class Threads : public EachBackend {
 protected:
  const Scene scene{};
};
INSTANTIATE_TEST_SUITE_P(Backends, Threads, ::testing::ValuesIn(kBackends), backend_test_name);

TEST_P(Threads, SameBytesForAnyNumber) {
  ASSERT_GT(scene.meshes.triangles, 20'000u);
  for (const SeedProcess process : {SeedProcess::kUv, SeedProcess::kId}) {
    const SeedBuffers one =
        make_rasterizer(GetParam())->draw(scene.meshes, *scene.store, scene.c, process, 1);
    for (const int threads : {2, 3, 0})
      EXPECT_TRUE(equal(
          one, make_rasterizer(GetParam())->draw(scene.meshes, *scene.store, scene.c, process, threads)));
    EXPECT_TRUE(equal(one, scene.draw(*rasterizer, process)));
    EXPECT_TRUE(equal(one, scene.draw(*rasterizer, process))) << "drawn again";
  }
}

TEST_P(Threads, FourDrawAtOnce) {
  const SeedBuffers uv = scene.draw(*rasterizer), id = scene.draw(*rasterizer, SeedProcess::kId);
  int wrong[4] = {};
  std::vector<std::thread> threads;
  for (int& w : wrong)
    threads.emplace_back([&] {
      for (int k = 0; k < 5; ++k) {
        w += !equal(uv, scene.draw(*rasterizer));
        w += !equal(id, scene.draw(*rasterizer, SeedProcess::kId, 1));
      }
    });
  for (std::thread& t : threads) t.join();
  for (const int w : wrong) EXPECT_EQ(w, 0);
}

TEST_P(Threads, BuffersOutliveTheRasterizer) {
  const SeedBuffers first = scene.draw(*rasterizer);
  const std::vector<std::uint32_t> copy(first.id.begin(), first.id.end());
  scene.draw(*rasterizer);
  rasterizer.reset();
  scene.draw(*make_rasterizer(GetParam()));
  EXPECT_TRUE(std::equal(copy.begin(), copy.end(), first.id.begin()));
}

// Runs `body` in a child; whether it returned true, and did not hang.
bool in_child(const std::function<bool()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(600);
    bool good = false;
    try {
      good = body();
    } catch (...) {
    }
    _exit(good ? 0 : 1);
  }
  int status = 1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST_P(Threads, TheChildOfOneThatHasDrawnDraws) {
  const SeedBuffers before = scene.draw(*rasterizer);
  EXPECT_TRUE(in_child([&] { return equal(before, scene.draw(*rasterizer)); }));
  EXPECT_TRUE(in_child([&] { return equal(before, scene.draw(*make_rasterizer(GetParam()))); }));
  EXPECT_TRUE(in_child([&] {
    const SeedBuffers again = scene.draw(*rasterizer, SeedProcess::kUv, 1);
    return equal(before, again) && in_child([&] { return equal(before, scene.draw(*rasterizer)); });
  }));
  EXPECT_TRUE(equal(before, scene.draw(*rasterizer)));
}

TEST(Fork, TheChildOfOneThatHasNotDrawnDraws) {
  const Scene scene;
  for (const Backend backend : kBackends) {
    // This process may have drawn in other tests; the outer child stands for one that has not where it has
    // not.
    EXPECT_TRUE(in_child([&] {
      return in_child([&] {
               return !available(backend) || scene.draw(*make_rasterizer(backend)).id.size() > 0;
             }) &&
             (!available(backend) || scene.draw(*make_rasterizer(backend)).id.size() > 0);
    })) << backend_name(backend);
  }
}

// Threads of Mesa's own would be missing in the child: it must be told, not hang.
TEST(ForkDeathTest, AChildWithoutMesasThreadsIsRefused) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // a process of its own, in which nothing was drawn yet
  EXPECT_EXIT(
      {
        setenv("LP_NUM_THREADS", "2", 1);
        if (!available(Backend::kOsmesa)) std::exit(0);
        const Scene scene;
        const auto r = make_rasterizer(Backend::kOsmesa);
        const SeedBuffers before = scene.draw(*r);
        const bool refused = in_child([&] {
          try {
            scene.draw(*r);
            return false;
          } catch (const Error&) {
            return true;
          }
        });
        std::exit((refused ? 0 : 1) + (equal(before, scene.draw(*r)) ? 0 : 2));  // 0: as it should be
      },
      ::testing::ExitedWithCode(0), "");
}

TEST(Backends, TheEnvironmentIsLeftAlone) {
  if (!available(Backend::kOsmesa) || std::getenv("LP_NUM_THREADS")) GTEST_SKIP();
  make_rasterizer(Backend::kOsmesa)->warm_up();
  EXPECT_EQ(std::getenv("LP_NUM_THREADS"), nullptr);
}

class NoRaster : public ::testing::Test {
 protected:
  void TearDown() override { unsetenv("TRIMRAY_NO_RASTER"); }
};

TEST_F(NoRaster, SaysSoAndChoosesNone) {
  setenv("TRIMRAY_NO_RASTER", "all", 1);
  for (const Backend backend : kBackends) {
    std::string why_not;
    EXPECT_FALSE(available(backend, &why_not));
    EXPECT_NE(why_not.find("TRIMRAY_NO_RASTER"), std::string::npos);
    EXPECT_EQ(version(backend), "");
    EXPECT_THROW(make_rasterizer(backend), Error);
  }
  EXPECT_EQ(choose(1e5, 1000), std::nullopt);
}

TEST_F(NoRaster, ChoosesTheNextBest) {
  if (!available(Backend::kOsmesa) || !available(Backend::kEmbree)) GTEST_SKIP();
  EXPECT_EQ(choose(1e5, 1000), Backend::kOsmesa);
  EXPECT_EQ(choose(1e5, 1'000'000), Backend::kEmbree);
  EXPECT_EQ(choose(1e5, 1'000'000, Meshes::kFresh), Backend::kOsmesa);
  EXPECT_EQ(choose(0.0, 0), Backend::kOsmesa);
  setenv("TRIMRAY_NO_RASTER", "osmesa,egl", 1);
  EXPECT_EQ(choose(1e5, 1000), Backend::kEmbree);
  setenv("TRIMRAY_NO_RASTER", "egl,embree", 1);
  EXPECT_EQ(choose(1e5, 1'000'000), Backend::kOsmesa);
}

TEST(Backends, HaveNames) {
  for (const Backend backend : kBackends) EXPECT_EQ(backend_of(backend_name(backend)), backend);
  EXPECT_EQ(backend_of("vulkan"), std::nullopt);
  for (const Backend backend : kBackends) EXPECT_EQ(version(backend).size() > 5, available(backend));
}

TEST(DynamicLibrary, NamesWhatIsMissing) {
  try {
    DynamicLibrary({"libtrimray_is_not_there.so.1", "libtrimray_nor_there.so"});
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("libtrimray_is_not_there.so.1"), std::string::npos);
  }
  const DynamicLibrary c{"libc.so.6"};
  int (*nothing)() = nullptr;
  EXPECT_THROW(c.get(nothing, "trimray_has_no_such_function"), Error);
}

}  // namespace
}  // namespace trimray::raster::testing
