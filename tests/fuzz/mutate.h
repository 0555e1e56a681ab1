// Mutations that keep a binary format's framing: libFuzzer's own ones mostly move bytes, which a checked
// parser refuses at once; these replace a number in place, so that the damage reaches the geometry.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <random>

namespace trimray::fuzz {

// Overwrites one value in place with an interesting one, or copies 8 bytes from elsewhere.
inline void replace_number(std::uint8_t* data, std::size_t size, std::minstd_rand& random) {
  using Limits = std::numeric_limits<double>;
  static constexpr double kReals[] = {0.0,
                                      -0.0,
                                      1.0,
                                      -1.0,
                                      0.5,
                                      1e-300,
                                      1e300,
                                      1e-9,
                                      6.283185307179586,
                                      1e9,
                                      -1e9,
                                      2.0,
                                      1e-7,
                                      100.0,
                                      Limits::quiet_NaN(),
                                      Limits::infinity(),
                                      -Limits::infinity(),
                                      Limits::denorm_min(),
                                      Limits::max()};
  static constexpr std::int32_t kIntegers[] = {
      0,  1,  2,  3,       4,       5,          7,
      10, 26, -1, 1 << 16, 1 << 30, 0x7fffffff, std::numeric_limits<std::int32_t>::min()};
  if (size < 8) return;
  const std::size_t at = random() % (size - 7);
  switch (random() % 4) {
    case 0: {
      const double value = kReals[random() % std::size(kReals)];
      std::memcpy(data + at, &value, 8);
      break;
    }
    case 1: {
      const std::int32_t value = kIntegers[random() % std::size(kIntegers)];
      std::memcpy(data + at, &value, 4);
      break;
    }
    case 2:
      data[at] = static_cast<std::uint8_t>(random() % 12);
      break;
    default:
      std::memmove(data + at, data + random() % (size - 7), 8);
      break;
  }
}

// Several replacements; the number of bytes does not change.
inline std::size_t replace_numbers(std::uint8_t* data, std::size_t size, unsigned seed) {
  std::minstd_rand random(seed);
  for (unsigned n = 1 + random() % 4; n > 0; --n) replace_number(data, size, random);
  return size;
}

}  // namespace trimray::fuzz

// libFuzzer's hook: one half in-place replacements, one half its own mutations.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (seed % 2 == 0) return LLVMFuzzerMutate(data, size, max_size);
  return trimray::fuzz::replace_numbers(data, size, seed / 2);
}
