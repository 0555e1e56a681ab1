#include "core/tess/mesh_file.h"

#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace trimray::tess {
namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

template <typename T>
std::string raw(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof(T) * values.size()};
}

// A binary STL file of triangles given by nine numbers each.
std::string binary_stl(const std::vector<std::array<float, 9>>& triangles) {
  std::string s(80, ' ');
  s += raw(std::vector<std::uint32_t>{static_cast<std::uint32_t>(triangles.size())});
  for (const auto& t : triangles) {
    s += std::string(12, '\0') + raw(std::vector<float>(t.begin(), t.end())) + std::string(2, '\0');
  }
  return s;
}

std::string error_of(std::string_view bytes, MeshFormat format) {
  try {
    read_mesh(bytes, format);
  } catch (const FormatError& e) {
    return e.what();
  }
  return "";
}

double area(const MeshFile& m) {
  double sum = 0.0;
  for (const auto& [a, b, c] : m.triangles)
    sum += glm::length(glm::cross(m.vertices[b] - m.vertices[a], m.vertices[c] - m.vertices[a])) / 2;
  return sum;
}

// Three triangles on the edge 0-1, one of them twice, once more turned round.
const char* const kBookObj =
    "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 -1 0\n"
    "f 1 2 3\nf 1 2 4\nf 1 2 5\nf 1 2 3\nf 2 1 3\n";
const char* const kBookOff =
    "OFF # a book\n5 5 0\n0 0 0\n0 0 1\n1 0 0\n0 1 0\n-1 -1 0\n"
    "3 0 1 2\n3 0 1 3 # page\n3 0 1 4\n3 0 1 2\n3 1 0 2\n";
const char* const kBookPly =
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\n"
    "element face 5\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n0 0 1\n1 0 0\n0 1 0\n-1 -1 0\n3 0 1 2\n3 0 1 3\n3 0 1 4\n3 0 1 2\n3 1 0 2\n";
const Triangles kBook = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 1, 2}, {1, 0, 2}};

TEST(MeshFile, KeepsEveryTriangleOfANonManifoldBook) {
  EXPECT_EQ(read_mesh(kBookObj, MeshFormat::kObj).triangles, kBook);
  EXPECT_EQ(read_mesh(kBookOff, MeshFormat::kOff).triangles, kBook);
  EXPECT_EQ(read_mesh(kBookPly, MeshFormat::kPly).triangles, kBook);
  const std::array<float, 9> page1{0, 0, 0, 0, 0, 1, 1, 0, 0}, page2{0, 0, 0, 0, 0, 1, 0, 1, 0},
      page3{0, 0, 0, 0, 0, 1, -1, -1, 0}, turned{0, 0, 1, 0, 0, 0, 1, 0, 0};
  const MeshFile stl = read_mesh(binary_stl({page1, page2, page3, page1, turned}), MeshFormat::kStl);
  EXPECT_EQ(stl.triangles, kBook);
  EXPECT_EQ(stl.vertices.size(), 5u);
  EXPECT_TRUE(stl.binary);
}

TEST(MeshFile, ReadsTextAndBinaryStlAlike) {
  const std::string text =
      "solid one\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1e0 0\n"
      "  endloop\n endfacet\nendsolid one\r\nSOLID two\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\n"
      "vertex 1 0 0\nvertex 0 0 +2.5\nendloop\nendfacet\nendsolid\n";
  const MeshFile a = read_mesh(text, MeshFormat::kStl);
  const MeshFile b =
      read_mesh(binary_stl({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 1, 0, 0, 0, 0, 2.5f}}), MeshFormat::kStl);
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
  ASSERT_EQ(a.groups.size(), 2u);
  EXPECT_EQ(a.groups[0].name, "one");
  EXPECT_EQ(a.groups[0].end, 1);
  EXPECT_EQ(a.groups[1].name, "two");
  EXPECT_EQ(b.groups.size(), 1u);
}

TEST(MeshFile, ReadsABinaryStlWhoseHeaderBeginsLikeText) {
  std::string s = binary_stl({{0, 0, 0, 1, 0, 0, 0, 1, 0}});
  s.replace(0, 5, "solid");
  EXPECT_EQ(read_mesh(s, MeshFormat::kStl).triangles.size(), 1u);
}

TEST(MeshFile, CountsFacesWithoutArea) {
  const MeshFile m =
      read_mesh(binary_stl({{0, 0, 0, 1, 0, 0, 1, 0, 0}, {0, 0, 0, 1, 0, 0, 0, 1, 0}}), MeshFormat::kStl);
  EXPECT_EQ(m.faces, 2);
  EXPECT_EQ(m.left_out, 1);
  EXPECT_EQ(m.triangles.size(), 1u);
}

TEST(MeshFile, KeepsCoordinatesExactly) {
  const char* const obj = "v 1234567.123456789 0.1 -3e-300\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const MeshFile m = read_mesh(obj, MeshFormat::kObj);
  EXPECT_EQ(m.vertices[0], dvec3(1234567.123456789, 0.1, -3e-300));
}

TEST(MeshFile, ReadsObjCornersInAllSpellings) {
  const char* const obj =
      "# a comment\nmtllib none.mtl\no box\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
      "f 1/1 2/1 3/1\ng side\nusemtl red\nf -4//1 -2//-1 \\\n -1//1\nusemtl blue\nf 1/1/1 2/1/1 4/1/1\nl 1 "
      "2\n";
  const MeshFile m = read_mesh(obj, MeshFormat::kObj);
  EXPECT_EQ(m.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}}));
  ASSERT_EQ(m.groups.size(), 3u);
  EXPECT_EQ(m.groups[0].name, "box");
  EXPECT_EQ(m.groups[1].name, "box side red");
  EXPECT_EQ(m.groups[2].name, "box side blue");
  EXPECT_EQ(m.groups[1].end, 2);
}

TEST(MeshFile, CutsConcavePolygonsWithinTheirOutline) {
  // An arrow head: a fan from corner 0 would cover more than the polygon.
  const MeshFile m = read_mesh("OFF\n4 1 0\n4 2 0\n0 0 0\n1 2 0\n0 4 0\n4 0 1 2 3\n", MeshFormat::kOff);
  EXPECT_EQ(m.triangles.size(), 2u);
  EXPECT_NEAR(area(m), 6.0, 1e-12);
  for (const auto& [a, b, c] : m.triangles)
    EXPECT_LT(glm::cross(m.vertices[b] - m.vertices[a], m.vertices[c] - m.vertices[a]).z, 0.0);
}

TEST(MeshFile, ReadsPlyInEveryEncodingAndSkipsWhatItDoesNotKnow) {
  const std::string properties =
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float quality\n"
      "element face 1\nproperty list uchar float texcoord\nproperty list uchar uint vertex_index\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement edge 1\nproperty int "
      "a\nend_header\n";
  const std::string text = "ply\r\nformat ascii 1.0\r\ncomment hello\r\n" + properties +
                           "0 0 0 1\n1 0 0 1\n0 1 0 1\n6 0 0 1 0 0 1 3 0 1 2 255 0 51\n7\n";
  std::string little = "ply\nformat binary_little_endian 1.0\n" + properties;
  std::string big = "ply\nformat binary_big_endian 1.0\n" + properties;
  const auto put = [&](auto value) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    little += bytes;
    big += std::string(bytes.rbegin(), bytes.rend());
  };
  for (const float f : {0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1}) put(f);
  put(std::uint8_t{6});
  for (const float f : {0, 0, 1, 0, 0, 1}) put(f);
  put(std::uint8_t{3});
  for (const std::uint32_t v : {0u, 1u, 2u}) put(v);
  for (const std::uint8_t c : {255, 0, 51}) put(c);
  put(std::int32_t{7});
  for (const std::string& bytes : {text, little, big}) {
    const MeshFile m = read_mesh(bytes, MeshFormat::kPly);
    EXPECT_EQ(m.triangles, (Triangles{{0, 1, 2}}));
    EXPECT_EQ(m.vertices[2], dvec3(0, 1, 0));
    EXPECT_EQ(m.groups[0].color, (std::array<float, 4>{1.0f, 0.0f, 0.2f, 1.0f}));
  }
}

TEST(MeshFile, GroupsTrianglesByColor) {
  const MeshFile m = read_mesh(
      "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2 1.0 0.0 0.0\n3 0 1 3 0 0 255\n3 0 2 3 1.0 0.0 0.0\n"
      "3 1 2 3\n",
      MeshFormat::kOff);
  ASSERT_EQ(m.groups.size(), 3u);
  EXPECT_EQ(m.groups[0].end, 2);
  EXPECT_EQ(m.groups[0].color, (std::array<float, 4>{1, 0, 0, 1}));
  EXPECT_EQ(m.groups[1].color, (std::array<float, 4>{0, 0, 1, 1}));
  EXPECT_LT(m.groups[2].color[0], 0.0f);
  EXPECT_EQ(m.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 3}}));
}

TEST(MeshFile, RefusesWhatIsNotFinite) {
  EXPECT_NE(error_of("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", MeshFormat::kObj), "");
  EXPECT_NE(error_of("v 0 0 1e999\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", MeshFormat::kObj), "");
  EXPECT_NE(error_of("OFF\n3 1 0\n0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n", MeshFormat::kOff), "");
  EXPECT_NE(error_of(binary_stl({{0, 0, NAN, 1, 0, 0, 0, 1, 0}}), MeshFormat::kStl), "");
  EXPECT_NE(
      error_of("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
               "endfacet\nendsolid\n",
               MeshFormat::kStl),
      "");
}

TEST(MeshFile, RefusesCornersThatDoNotExist) {
  EXPECT_NE(error_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", MeshFormat::kObj), "");
  EXPECT_NE(error_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", MeshFormat::kObj), "");
  EXPECT_NE(error_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", MeshFormat::kObj), "");
  EXPECT_NE(error_of("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", MeshFormat::kOff), "");
  EXPECT_NE(error_of("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", MeshFormat::kOff), "");
  std::string ply = kBookPly;
  ply.replace(ply.rfind("3 1 0 2"), 7, "3 1 0 9");
  EXPECT_EQ(error_of(ply, MeshFormat::kPly), "face 4: corner 9 of 5 vertices does not exist");
}

TEST(MeshFile, RefusesHugeCountsWithoutAllocatingThem) {
  EXPECT_NE(error_of("OFF\n4000000000 4000000000 0\n0 0 0\n", MeshFormat::kOff), "");
  EXPECT_NE(error_of("ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
                     "property float z\nend_header\n0 0 0\n",
                     MeshFormat::kPly),
            "");
  EXPECT_NE(error_of("ply\nformat binary_little_endian 1.0\nelement vertex 9223372036854775807\nend_header\n",
                     MeshFormat::kPly),
            "");
  std::string stl = binary_stl({{0, 0, 0, 1, 0, 0, 0, 1, 0}});
  stl.replace(80, 4, "\xff\xff\xff\xff");
  EXPECT_NE(error_of(stl, MeshFormat::kStl), "");
}

TEST(MeshFile, RefusesEveryCutOffFile) {
  const std::string stl = binary_stl({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 1, 0, 0, 0, 0, 1}});
  for (std::size_t n = 0; n < stl.size(); ++n)
    EXPECT_NE(error_of(stl.substr(0, n), MeshFormat::kStl), "") << n;
  // A text may lose blanks at its end, and a digit of its last number, unnoticed; nothing more.
  const std::string ply = kBookPly, off = kBookOff;
  for (std::size_t n = 0; n + 2 < ply.size(); ++n)
    EXPECT_NE(error_of(ply.substr(0, n), MeshFormat::kPly), "") << n;
  for (std::size_t n = 0; n + 2 < off.size(); ++n)
    EXPECT_NE(error_of(off.substr(0, n), MeshFormat::kOff), "") << n;
}

MeshToWrite to_write(const std::vector<dvec3>& vertices, const Triangles& triangles) {
  return {.vertices = vertices, .triangles = triangles, .normals = {}, .colors = {}};
}

TEST(MeshFile, WritesWhatItReads) {
  const std::vector<dvec3> vertices = {{0, 0, 0}, {0, 0, 1.0 / 3.0}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}};
  const std::vector<std::array<float, 4>> colors(5, {1.0f, 0.2f, 0.0f, 1.0f});
  const std::vector<dvec3> normals(5, {0, 0, 1});
  for (const MeshFormat f : {MeshFormat::kStl, MeshFormat::kObj, MeshFormat::kPly, MeshFormat::kOff}) {
    MeshToWrite mesh = to_write(vertices, kBook);
    for (const bool rich : {false, true}) {
      if (rich) mesh.normals = normals, mesh.colors = colors;
      const std::string bytes = write_mesh(mesh, f);
      EXPECT_EQ(bytes, write_mesh(mesh, f));
      const MeshFile back = read_mesh(bytes, f);
      EXPECT_EQ(back.triangles, kBook) << static_cast<int>(f);
      ASSERT_EQ(back.vertices.size(), 5u);
      EXPECT_LT(glm::distance(back.vertices[1], vertices[1]), 1e-7);
      const bool colored = rich && (f == MeshFormat::kPly || f == MeshFormat::kOff);
      ASSERT_EQ(back.groups.size(), 1u);
      if (colored) {
        EXPECT_NEAR(back.groups[0].color[0], 1.0f, 1e-6);
        EXPECT_NEAR(back.groups[0].color[1], 0.2f, 1e-6);
      } else {
        EXPECT_LT(back.groups[0].color[0], 0.0f);
      }
    }
  }
}

TEST(MeshFile, WritesNoCornerThatDoesNotExist) {
  const std::vector<dvec3> vertices(2);
  const Triangles triangles = {{0, 1, 2}};
  EXPECT_THROW(write_mesh(to_write(vertices, triangles), MeshFormat::kStl), ArgumentError);
}

// Whatever is changed in a file: it is read, or refused by a FormatError.
TEST(MeshFile, SurvivesDamage) {
  std::mt19937 random(7);
  const std::string stl = binary_stl({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 1, 0, 0, 0, 0, 1}});
  const std::string text =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid a\n";
  const std::string little =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
      "property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\n"
      "end_header\n" +
      std::string(36, '\1') + std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
  const std::pair<std::string, MeshFormat> files[] = {
      {stl, MeshFormat::kStl},      {text, MeshFormat::kStl},     {kBookObj, MeshFormat::kObj},
      {kBookOff, MeshFormat::kOff}, {kBookPly, MeshFormat::kPly}, {little, MeshFormat::kPly}};
  int read = 0, refused = 0;
  for (int round = 0; round < 20000; ++round) {
    auto [bytes, format] = files[round % 6];
    const auto changes = 1 + random() % 4;
    for (unsigned i = 0; i < changes; ++i) {
      const std::size_t at = random() % bytes.size();
      switch (random() % 4) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          bytes.erase(at, 1 + random() % 8);
          break;
        case 2:
          bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 16));
          break;
        default:
          bytes[at] = "0123456789-.eE \n/#"[random() % 18];
      }
      if (bytes.empty()) bytes = " ";
    }
    try {
      const MeshFile m = read_mesh(bytes, format);
      ++read;
      for (const auto& t : m.triangles) {
        for (const std::int32_t v : t) ASSERT_LT(static_cast<std::size_t>(v), m.vertices.size());
      }
      ASSERT_EQ(m.groups.back().end, static_cast<std::int32_t>(m.triangles.size()));
    } catch (const FormatError&) {
      ++refused;
    }
  }
  EXPECT_GT(read, 1000);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace trimray::tess
