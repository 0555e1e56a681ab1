// Fuzzes the reader of saved stores. How to run: tests/fuzz/CMakeLists.txt.
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/store_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  trimray::fuzz::load_saved({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
