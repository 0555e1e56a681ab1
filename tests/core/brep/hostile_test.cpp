// Damaged streams: every one is a FormatError that says where, never a crash and never another exception.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>

#include "core/brep/bintools.h"
#include "tests/core/brep/promises.h"
#include "tests/core/brep/streams.h"

namespace trimray::brep {
namespace {

using Bytes = std::vector<std::byte>;

const char* const kStreams[] = {"box",       "cone",   "curves2", "curves3",     "cylinder", "cylinder_v1",
                                "locations", "meshes", "points",  "rounded_box", "surfaces"};

// The last place, since one section's name ends another's.
std::size_t find(const Bytes& bytes, const std::string& text) {
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  const auto at = std::find_end(bytes.begin(), bytes.end(), data, data + text.size());
  EXPECT_NE(at, bytes.end()) << text;
  return static_cast<std::size_t>(at - bytes.begin());
}

Bytes replaced(Bytes bytes, const std::string& from, const std::string& to) {
  const std::size_t at = find(bytes, from);
  const auto* data = reinterpret_cast<const std::byte*>(to.data());
  bytes.erase(bytes.begin() + at, bytes.begin() + at + from.size());
  bytes.insert(bytes.begin() + at, data, data + to.size());
  return bytes;
}

std::string failure(const Bytes& bytes) {
  try {
    parse_bintools(bytes);
  } catch (const FormatError& error) {
    return error.what();
  }
  return "";
}

TEST(BintoolsHostile, EveryTruncationIsAnError) {
  for (const char* name : kStreams) {
    const Bytes bytes = testing::read_stream(name);
    EXPECT_EQ(failure(bytes), "");
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const Bytes cut(bytes.begin(), bytes.begin() + size);
      ASSERT_NE(failure(cut), "") << name << " cut to " << size;
    }
  }
}

TEST(BintoolsHostile, EveryFlippedBitIsAnErrorOrAValidModel) {
  for (const char* name : kStreams) {
    Bytes bytes = testing::read_stream(name);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (int bit = 0; bit < 8; ++bit) {
        const std::byte before = bytes[i];
        bytes[i] ^= std::byte{1} << bit;
        try {
          testing::check_promises(parse_bintools(bytes));
        } catch (const FormatError&) {
        }
        bytes[i] = before;
      }
    }
  }
}

TEST(BintoolsHostile, RandomDamageIsAnErrorOrAValidModel) {
  std::mt19937 random(7);
  for (const char* name : kStreams) {
    const Bytes bytes = testing::read_stream(name);
    for (int round = 0; round < 2000; ++round) {
      Bytes damaged = bytes;
      for (int k = 0; k < 4; ++k) {
        const std::size_t at = random() % (damaged.size() - 4);
        const std::uint32_t values[] = {0,          1,          0x7fffffff,
                                        0x80000000, 0xffffffff, static_cast<std::uint32_t>(random())};
        std::memcpy(damaged.data() + at, &values[random() % 6], 4);
      }
      try {
        testing::check_promises(parse_bintools(damaged));
      } catch (const FormatError&) {
      }
    }
  }
}

TEST(BintoolsHostile, HugeCountsAllocateNothing) {
  const Bytes box = testing::read_stream("box");
  for (const char* section : {"Locations 0", "Curve2ds 24", "Curves 12", "Polygon3D 0",
                              "PolygonOnTriangulations 0", "Surfaces 6", "Triangulations 0", "TShapes 34"}) {
    const std::string name = std::string(section).substr(0, std::string(section).find(' '));
    for (const char* count :
         {" 2147483647", " 4294967296", " 9999999999", " 99999999999999999999", " -1", " ", ""}) {
      const std::string message = failure(replaced(box, std::string(section) + "\n", name + count + "\n"));
      EXPECT_NE(message.find("B-rep stream, " + name + ", byte "), std::string::npos)
          << name << count << message;
    }
  }
}

TEST(BintoolsHostile, ErrorsNameSectionAndOffset) {
  EXPECT_EQ(failure({}), "B-rep stream, header, byte 0: not a BinTools shape set of version 1 to 4");
  Bytes bytes = testing::read_stream("surfaces");
  const std::size_t first = find(bytes, "Surfaces 14\n") + 12;
  bytes[first] = std::byte{12};
  EXPECT_EQ(failure(bytes),
            "B-rep stream, Surfaces, byte " + std::to_string(first + 1) + ": unknown kind of surface");
}

TEST(BintoolsHostile, BytesAfterTheLastShapeAreAnError) {
  Bytes bytes = testing::read_stream("box");
  bytes.push_back(std::byte{0});
  EXPECT_NE(failure(bytes).find("bytes after the last shape"), std::string::npos);
}

// A stream whose single 3D curve is a line below `levels` trims.
Bytes nested_trims(int levels) {
  std::string text = "\nOpen CASCADE Topology V4, (c) Open Cascade\nLocations 0\nCurve2ds 0\nCurves 1\n";
  for (int i = 0; i < levels; ++i) text += std::string(1, '\x08') + std::string(16, '\0');
  text += std::string(1, '\x01') + std::string(48, '\0');
  text += "Polygon3D 0\nPolygonOnTriangulations 0\nSurfaces 0\nTriangulations 0\n\nTShapes 0\n";
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return Bytes(data, data + text.size());
}

TEST(BintoolsHostile, NestingOfBasisCurvesIsBounded) {
  EXPECT_EQ(parse_bintools(nested_trims(kMaxBasisDepth)).curves3.size(), kMaxBasisDepth + 1u);
  EXPECT_NE(failure(nested_trims(kMaxBasisDepth + 1)).find("nested too deeply"), std::string::npos);
  EXPECT_NE(failure(nested_trims(1000000)).find("nested too deeply"), std::string::npos);
}

// A chain of compounds, each the only child of the next, `uses` times; child() gives the stored index
// for shape i.
template <typename Child>
Bytes compounds(std::int32_t count, Child child, int uses = 1) {
  std::string text =
      "\nOpen CASCADE Topology V4, (c) Open Cascade\nLocations 0\nCurve2ds 0\nCurves 0\nPolygon3D 0\n";
  text +=
      "PolygonOnTriangulations 0\nSurfaces 0\nTriangulations 0\n\nTShapes " + std::to_string(count) + "\n";
  for (std::int32_t i = 0; i < count; ++i) {
    text += std::string(8, '\0');
    for (int k = 0; i > 0 && k < uses; ++k) {
      const std::int32_t values[2] = {child(i), 0};
      text += std::string(1, '\0') + std::string(reinterpret_cast<const char*>(values), 8);
    }
    text += '*';
  }
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return Bytes(data, data + text.size());
}

TEST(BintoolsHostile, NestingOfShapesIsBounded) {
  const auto chain = [](std::int32_t count) {
    return compounds(count, [count](std::int32_t i) { return count - i + 1; });
  };
  EXPECT_EQ(parse_bintools(chain(kMaxShapeDepth + 1)).shapes.size(), kMaxShapeDepth + 1u);
  EXPECT_NE(failure(chain(kMaxShapeDepth + 2)).find("nested too deeply"), std::string::npos);
}

TEST(BintoolsHostile, UsesOfShapesCannotMultiplyWithoutEnd) {
  // The root of n compounds, each holding the one before twice, meets 2^n - 2 uses.
  const auto doubling = [](std::int32_t count) {
    return compounds(
        count, [count](std::int32_t i) { return count - i + 1; }, 2);
  };
  EXPECT_EQ(parse_bintools(doubling(26)).shapes.size(), 26u);
  EXPECT_NE(failure(doubling(28)).find("too many uses"), std::string::npos);
  EXPECT_NE(failure(doubling(200)).find("too many uses"), std::string::npos);
}

TEST(BintoolsHostile, ShapesCannotContainThemselvesOrLaterOnes) {
  const auto self = compounds(3, [](std::int32_t i) { return 3 - i; });
  EXPECT_NE(failure(self).find("child does not stand before its parent"), std::string::npos);
  const auto later = compounds(3, [](std::int32_t) { return 1; });
  EXPECT_NE(failure(later).find("child does not stand before its parent"), std::string::npos);
  const auto none = compounds(3, [](std::int32_t) { return 4; });
  EXPECT_NE(failure(none).find("shape index out of range"), std::string::npos);
}

}  // namespace
}  // namespace trimray::brep
