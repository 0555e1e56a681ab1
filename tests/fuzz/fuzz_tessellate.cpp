// Fuzzes the tessellator with stores as they are saved. How to run: tests/fuzz/CMakeLists.txt.
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/tess_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  trimray::fuzz::mesh_saved({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
