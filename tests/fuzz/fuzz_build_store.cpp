// Fuzzes the way from the B-rep stream to the NURBS store. How to run: tests/fuzz/CMakeLists.txt.
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/store_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  trimray::fuzz::build_from_stream({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
