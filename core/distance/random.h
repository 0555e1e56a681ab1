// Random numbers that depend on where they are used alone, never on the order.
#pragma once

#include <cstdint>

namespace trimray::distance {

// splitmix64 (Steele, Lea, Flood 2014) of a key that is built from numbers.
class RandomKey {
 public:
  explicit RandomKey(std::uint64_t seed) : key_(mix(seed)) {}
  RandomKey with(std::uint64_t x) const {
    RandomKey k = *this;
    k.key_ = mix(key_ ^ mix(x + 0x632be59bd9b4e019u));
    return k;
  }
  // The i-th number in [0, 1).
  double unit(std::uint64_t i) const { return static_cast<double>(mix(key_ + i) >> 11) * 0x1p-53; }

 private:
  static std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  std::uint64_t key_;
};

}  // namespace trimray::distance
