// Fuzzes the parser of the B-rep stream. How to run: tests/fuzz/CMakeLists.txt.
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  trimray::fuzz::parse_stream({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
