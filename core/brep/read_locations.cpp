// The section "Locations": elementary placements, and products of powers of them.
#include "core/brep/sections.h"

#include <glm/gtc/matrix_inverse.hpp>

namespace trimray::brep {
namespace {

Transform compose(const Transform& a, const Transform& b) {
  return {a.linear * b.linear, a.linear * b.translation + a.translation};
}

Transform inverse(const Transform& t) {
  const dmat3 linear = glm::inverse(t.linear);
  return {linear, -(linear * t.translation)};
}

// t to an integer power, by squaring, so that a hostile exponent costs 32 products at most.
Transform power(const Transform& t, std::int32_t exponent) {
  Transform result;
  Transform square = exponent < 0 ? inverse(t) : t;
  std::int64_t n = exponent < 0 ? -std::int64_t{exponent} : std::int64_t{exponent};
  for (; n > 0; n >>= 1) {
    if (n & 1) result = compose(result, square);
    if (n > 1) square = compose(square, square);
  }
  return result;
}

// A 3x4 matrix by rows.
Transform read_elementary(ByteReader& in) {
  Transform t;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) t.linear[column][row] = in.real();
    t.translation[row] = in.real();
  }
  return t;
}

// Pairs of (location, power), closed by a zero. The first pair is applied to a point first.
Transform read_composite(ByteReader& in, const std::vector<Transform>& known) {
  Transform t;
  std::int32_t next = in.optional_index(known.size(), "location");
  if (next < 0) in.fail("empty composite location");
  while (next >= 0) {
    t = compose(power(known[next], in.integer()), t);
    next = in.optional_index(known.size(), "location");
  }
  return t;
}

}  // namespace

void read_locations(ByteReader& in, Model& model, StreamTables& tables) {
  const std::int32_t count = in.section("Locations", 13);
  model.locations.reserve(count);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::uint8_t code = in.byte();
    if (code != 1 && code != 2) in.fail("unknown kind of location");
    model.locations.push_back(code == 1 ? read_elementary(in) : read_composite(in, model.locations));
  }
  tables.locations = count;
}

}  // namespace trimray::brep
