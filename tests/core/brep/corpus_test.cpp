// Replays the inputs that the fuzzers found, so that every test run covers them without libFuzzer.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <vector>

#include "tests/core/brep/streams.h"
#include "tests/fuzz/store_targets.h"
#include "tests/fuzz/targets.h"

namespace trimray {
namespace {

// Calls the target with every file of tests/fuzz/corpus/NAME, in the order of their names.
void replay(const char* name, const std::function<void(std::span<const std::byte>)>& target) {
  const auto tests = std::filesystem::path(__FILE__).parent_path().parent_path().parent_path();
  const auto folder = tests / "fuzz" / "corpus" / name;
  std::vector<std::filesystem::path> paths;
  for (const auto& file : std::filesystem::directory_iterator(folder)) paths.push_back(file.path());
  std::ranges::sort(paths);
  EXPECT_FALSE(paths.empty());
  for (const auto& path : paths) {
    SCOPED_TRACE(path.filename().string());
    EXPECT_NO_THROW(target(testing::read_bytes(path)));
  }
}

TEST(Corpus, StreamsAreParsedOrRefused) { replay("bintools", fuzz::parse_stream); }
TEST(Corpus, StreamsAreBuiltOrRefused) { replay("build_store", fuzz::build_from_stream); }
TEST(Corpus, StoreFilesAreLoadedOrRefused) { replay("load_store", fuzz::load_saved); }

}  // namespace
}  // namespace trimray
