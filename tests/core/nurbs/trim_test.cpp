#include "core/nurbs/trim.h"

#include <algorithm>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/core/nurbs/trim_stores.h"

namespace trimray::nurbs {
namespace {

constexpr double kPi = std::numbers::pi;

// Winding-free oracle: even-odd on a fine polyline in long double, and the distance to it.
struct Polyline {
  std::vector<dvec2> points;
  bool odd(dvec2 p) const {
    bool in = false;
    for (std::size_t i = 0, j = points.size() - 1; i < points.size(); j = i++) {
      const dvec2 a = points[i], b = points[j];
      if ((a.y > p.y) == (b.y > p.y)) continue;
      const long double u = a.x + static_cast<long double>(b.x - a.x) * (p.y - a.y) / (b.y - a.y);
      if (p.x < u) in = !in;
    }
    return in;
  }
  double distance(dvec2 p) const {
    double best = kInf;
    for (std::size_t i = 0, j = points.size() - 1; i < points.size(); j = i++) {
      const dvec2 d = points[i] - points[j];
      const double l = glm::dot(d, d);
      const double s = l > 0.0 ? std::clamp(glm::dot(p - points[j], d) / l, 0.0, 1.0) : 0.0;
      best = std::min(best, glm::length(points[j] + s * d - p));
    }
    return best;
  }
};

// Bernstein sum, independent of the library's de Casteljau.
dvec2 bernstein(const TrimPiece& c, double t) {
  dvec3 sum(0.0);
  const int n = static_cast<int>(c.size()) - 1;
  double binomial = 1.0;
  for (int i = 0; i <= n; ++i) {
    sum += binomial * std::pow(t, i) * std::pow(1.0 - t, n - i) * c[i];
    binomial *= static_cast<double>(n - i) / (i + 1);
  }
  return dvec2(sum.x, sum.y) / sum.z;
}

Polyline dense(const TrimLoop& loop, int samples) {
  Polyline line;
  for (const TrimPiece& piece : loop)
    for (int i = 0; i <= samples; ++i)
      line.points.push_back(bernstein(piece, static_cast<double>(i) / samples));
  return line;
}

dvec2 random_point(std::mt19937_64& rng, dvec2 lower, dvec2 upper) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double x = unit(rng), y = unit(rng);
  return lower + dvec2(x, y) * (upper - lower);
}

TEST(TrimIndex, CircleAndEllipseToTheLastBits) {
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * kPi);
  const dvec2 centers[] = {{0.0, 0.0}, {3.0, -2.0}};
  for (const dvec2 c : centers) {
    const double ru = 2.0, rv = 0.75;
    const TrimIndex index(one_face({ellipse(c, ru, rv)}));
    for (int i = 0; i < 20000; ++i) {
      const double a = angle(rng);
      const dvec2 rim{ru * std::cos(a), rv * std::sin(a)};
      // Relative to the largest coordinate.
      for (const double eps : {1e-14, 1e-12, 1e-9, 1e-6, 1e-3, 0.1}) {
        EXPECT_TRUE(index.inside(0, c + rim * (1.0 - eps * (1.0 + glm::length(c)))));
        EXPECT_FALSE(index.inside(0, c + rim * (1.0 + eps * (1.0 + glm::length(c)))));
      }
    }
  }
}

TEST(TrimIndex, RandomPolygonsEvenOdd) {
  std::mt19937_64 rng(2);
  for (int round = 0; round < 60; ++round) {
    std::vector<dvec2> points(3 + round);
    for (dvec2& p : points) p = random_point(rng, dvec2(-5.0, 10.0), dvec2(5.0, 10.5));
    const TrimIndex index(one_face({polygon(points)}));
    const Polyline oracle{points};
    for (int i = 0; i < 3000; ++i) {
      const dvec2 p = random_point(rng, dvec2(-5.2, 9.98), dvec2(5.2, 10.52));
      if (oracle.distance(p) < 1e-12) continue;
      ASSERT_EQ(index.inside(0, p), oracle.odd(p)) << round << " " << p.x << " " << p.y;
    }
  }
}

TEST(TrimIndex, RandomRationalCurvesOfAnyDegree) {
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> weight(0.2, 5.0);
  for (int round = 0; round < 80; ++round) {
    const int degree = 2 + round % 9, pieces = 1 + round % 5;
    TrimLoop loop;
    dvec2 last = random_point(rng, dvec2(0.0), dvec2(1.0));
    const dvec2 first = last;
    for (int p = 0; p < pieces; ++p) {
      TrimPiece piece{dvec3(last, 1.0)};
      for (int i = 1; i < degree; ++i)
        piece.push_back((round % 2 ? weight(rng) : 1.0) *
                        dvec3(random_point(rng, dvec2(0.0), dvec2(1.0)), 1.0));
      last = p + 1 == pieces && round % 3 ? first : random_point(rng, dvec2(0.0), dvec2(1.0));
      piece.push_back(dvec3(last, 1.0));
      loop.push_back(piece);
    }
    const TrimIndex index(one_face({loop}));  // every third loop is open: closed by a straight link
    const Polyline oracle = dense(loop, 600);
    for (int i = 0; i < 600; ++i) {
      const dvec2 p = random_point(rng, dvec2(-0.05), dvec2(1.05));
      if (oracle.distance(p) < 3e-4) continue;
      ASSERT_EQ(index.inside(0, p), oracle.odd(p)) << round << " " << p.x << " " << p.y;
    }
  }
}

// Tiles that share corners and edges: the half-open rule gives every point, corners included, to exactly one.
TEST(TrimIndex, EveryPointOfAPartitionBelongsToOneTile) {
  std::mt19937_64 rng(4);
  constexpr int kSide = 6;
  dvec2 corner[kSide + 1][kSide + 1];
  for (int i = 0; i <= kSide; ++i)
    for (int j = 0; j <= kSide; ++j) {
      corner[i][j] = dvec2(i, j);
      // Half of the rows keep their horizontal edges.
      if (i > 0 && i < kSide && j > 0 && j < kSide && j % 2)
        corner[i][j] += random_point(rng, dvec2(-0.3), dvec2(0.3));
    }
  NurbsStore store;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      std::vector<dvec2> quad{corner[i][j], corner[i + 1][j], corner[i + 1][j + 1], corner[i][j + 1]};
      if ((i + j) % 2) std::reverse(quad.begin(), quad.end());
      add_face(store, {polygon(quad)});
    }
  const TrimIndex index(store);
  const auto owners = [&](dvec2 p) {
    int count = 0;
    for (int f = 0; f < kSide * kSide; ++f) count += index.inside(f, p);
    return count;
  };
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      EXPECT_EQ(owners(corner[i][j]), 1) << i << " " << j;
      for (double s : {0.25, 0.5, 0.75}) {
        if (j % 2 == 0) {
          EXPECT_EQ(owners(dvec2(i + s, j)), 1);  // on a horizontal edge
        }
        // At the height of a corner, anywhere.
        EXPECT_EQ(owners(dvec2(kSide * s, corner[i][j].y)), 1);
      }
    }
  for (int i = 0; i < 20000; ++i) EXPECT_EQ(owners(random_point(rng, dvec2(0.0), dvec2(kSide))), 1);
}

// The same with curved borders: neighbours hold the same pieces, one of them turned round.
TEST(TrimIndex, CurvedNeighboursShareEveryPoint) {
  std::mt19937_64 rng(5);
  const auto turned = [](TrimPiece p) { return TrimPiece(p.rbegin(), p.rend()); };
  const auto line = [](dvec2 a, dvec2 b) { return TrimPiece{dvec3(a, 1), dvec3(b, 1)}; };
  for (int round = 0; round < 40; ++round) {
    TrimPiece wave{dvec3(0.5, 0, 1)};
    for (int i = 0; i < 3; ++i)
      wave.push_back((1.0 + round % 3) * dvec3(random_point(rng, dvec2(0.1, 0.2), dvec2(0.9, 0.8)), 1));
    wave.push_back(dvec3(0.5, 1, 1));
    NurbsStore store;
    add_face(store, {{line({0, 0}, {0.5, 0}), wave, line({0.5, 1}, {0, 1}), line({0, 1}, {0, 0})}});
    add_face(store, {{line({0.5, 0}, {1, 0}), line({1, 0}, {1, 1}), line({1, 1}, {0.5, 1}), turned(wave)}});
    const TrimIndex index(store);
    int both = 0;
    for (int i = 0; i < 4000; ++i) {
      dvec2 p = random_point(rng, dvec2(0.0), dvec2(1.0));
      const int in = index.inside(0, p) + index.inside(1, p);
      both += in == 2;
      EXPECT_EQ(in, 1);
    }
    EXPECT_EQ(both, 0);
  }
}

TEST(TrimIndex, HolesIslandsAndOrientationDoNotMatter) {
  std::mt19937_64 rng(6);
  TrimLoop hole = ellipse({0, 0}, 2, 2);
  std::reverse(hole.begin(), hole.end());
  for (auto& piece : hole) std::reverse(piece.begin(), piece.end());
  for (const TrimLoop& middle : {ellipse({0, 0}, 2, 2), hole}) {
    const TrimIndex index(one_face({ellipse({0, 0}, 4, 4), middle, ellipse({0, 0}, 1, 1)}));
    for (int i = 0; i < 20000; ++i) {
      const dvec2 p = random_point(rng, dvec2(-4.5), dvec2(4.5));
      const double r = glm::length(p);
      EXPECT_EQ(index.inside(0, p), r < 1.0 || (r > 2.0 && r < 4.0));
    }
  }
}

TEST(TrimIndex, DegeneratePiecesChangeNothing) {
  std::mt19937_64 rng(7);
  TrimLoop square = polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  const TrimPiece point{dvec3(1, 0, 1), dvec3(1, 0, 1), dvec3(1, 0, 1), dvec3(1, 0, 1)};
  const TrimPiece spike_out{dvec3(1, 0, 1), dvec3(2, 0.5, 1)}, spike_back{dvec3(2, 0.5, 1), dvec3(1, 0, 1)};
  // A straight line written as a cubic that doubles back on itself, along the right side.
  const TrimPiece cubic{dvec3(1, 0, 1), dvec3(1, 1.5, 1), dvec3(1, -0.5, 1), dvec3(1, 1, 1)};
  TrimLoop loop{square[0], point, spike_out, spike_back, point, cubic, square[2], square[3]};
  const TrimIndex index(one_face({loop}));
  for (int i = 0; i < 20000; ++i) {
    const dvec2 p = random_point(rng, dvec2(-0.5, -0.5), dvec2(2.5, 1.5));
    EXPECT_EQ(index.inside(0, p), p.x > 0 && p.x < 1 && p.y > 0 && p.y < 1) << p.x << " " << p.y;
  }
}

TEST(TrimIndex, SeamJumpsAreLinks) {
  // A band round a cylinder given by its two rims only: the links close it along u = 0 and u = 2 pi.
  const TrimPiece bottom{dvec3(0, 1, 1), dvec3(2 * kPi, 1, 1)}, top{dvec3(2 * kPi, 3, 1), dvec3(0, 3, 1)};
  const TrimIndex index(one_face({{bottom, top}}));
  std::mt19937_64 rng(8);
  for (int i = 0; i < 5000; ++i) {
    const dvec2 p = random_point(rng, dvec2(-1, 0), dvec2(7.5, 4));
    EXPECT_EQ(index.inside(0, p), p.x > 0 && p.x < 2 * kPi && p.y > 1 && p.y < 3);
  }
}

TEST(TrimIndex, ExtremeScalesAndOffsets) {
  std::mt19937_64 rng(9);
  for (const dvec2 scale : {dvec2(1e-9, 1e6), dvec2(1e6, 1e-9), dvec2(1e-12, 1e-12)}) {
    for (const double offset : {0.0, 1e5}) {
      const dvec2 c = offset * scale;
      const TrimIndex index(one_face({ellipse(c, scale.x, scale.y)}));
      for (int i = 0; i < 5000; ++i) {
        const dvec2 n = random_point(rng, dvec2(-1.1), dvec2(1.1));
        const double r = glm::length(n);
        if (std::abs(r - 1.0) < 1e-9) continue;
        EXPECT_EQ(index.inside(0, c + scale * n), r < 1.0);
      }
    }
  }
}

TEST(TrimIndex, RectanglesDomainsAndBadFaces) {
  NurbsStore store = one_face({polygon({{1, 2}, {3, 2}, {3, 5}, {1, 5}})});
  add_face(store, {polygon({{1, 2}, {3, 2}, {3, 5}, {1, 5}})});
  store.faces[0].iso_rectangle = true;
  add_face(store, {});  // a whole sphere
  store.faces[2].uv_box = {dvec2(0, -kPi / 2), dvec2(2 * kPi, kPi / 2)};
  Surface& sphere = store.surfaces[store.faces[2].surface];
  sphere.kind = SurfaceKind::kSphere, sphere.periodic_u = true, sphere.period_u = 2 * kPi;
  add_face(store, {polygon({{0, 0}, {1, 0}, {0, 1}})});
  store.faces[3].status = FaceStatus::kBadTrim;
  const TrimIndex index(store);
  std::mt19937_64 rng(10);
  for (int i = 0; i < 10000; ++i) {
    dvec2 p = random_point(rng, dvec2(0.5, 1.5), dvec2(3.5, 5.5));
    if (i % 3 == 0) p.x = i % 2 ? 1.0 : 3.0;
    if (i % 5 == 0) p.y = i % 2 ? 2.0 : 5.0;
    EXPECT_EQ(index.inside(0, p), index.inside(1, p)) << p.x << " " << p.y;
    EXPECT_FALSE(index.inside(3, dvec2(0.2, 0.2)));
    const dvec2 s = random_point(rng, dvec2(-10, -1.5), dvec2(10, 1.5));
    EXPECT_TRUE(index.inside(2, index.wrap(2, s)));
  }
  EXPECT_TRUE(index.inside(2, dvec2(2 * kPi, kPi / 2)));
  EXPECT_TRUE(index.inside(2, dvec2(0.0, -kPi / 2)));
  EXPECT_FALSE(index.inside(2, dvec2(0.0, 1.6)));
  EXPECT_FALSE(index.inside(0, dvec2(kNaN, 3.0)));
  EXPECT_FALSE(index.inside(1, dvec2(2.0, kNaN)));
}

TEST(TrimIndex, WrapBringsNextToTheBox) {
  NurbsStore store = one_face({polygon({{5, 0}, {7, 0}, {7, 1}, {5, 1}})});
  store.surfaces[0].periodic_u = true, store.surfaces[0].period_u = 2 * kPi;
  const TrimIndex index(store);
  for (int k = -5; k <= 5; ++k) {
    const dvec2 p = index.wrap(0, dvec2(6.5 + k * 2 * kPi, 0.25));
    EXPECT_NEAR(p.x, 6.5, 1e-13);
    EXPECT_EQ(p.y, 0.25);
    EXPECT_TRUE(index.inside(0, p));
  }
}

TEST(TrimIndex, CoverageIsConservative) {
  std::mt19937_64 rng(11);
  NurbsStore store = one_face({ellipse({0, 0}, 4, 4), ellipse({1, 0}, 2, 1)});
  add_face(store, {polygon({{-3, -3}, {3, -3}, {3, 3}, {-3, 3}})});
  store.faces[1].iso_rectangle = true;
  const TrimIndex index(store);
  int decided[3] = {0, 0, 0};
  for (int i = 0; i < 4000; ++i) {
    for (int face = 0; face < 2; ++face) {
      Box2 box;
      const dvec2 p = random_point(rng, dvec2(-5), dvec2(5));
      box.add(p), box.add(p + random_point(rng, dvec2(0), dvec2(0.7)));
      const Coverage c = index.coverage(face, box);
      ++decided[static_cast<int>(c)];
      for (int k = 0; k < 20; ++k) {
        const dvec2 q = random_point(rng, box.lower, box.upper);
        if (c == Coverage::kInside) {
          EXPECT_TRUE(index.inside(face, q));
        }
        if (c == Coverage::kOutside) {
          EXPECT_FALSE(index.inside(face, q));
        }
      }
    }
  }
  EXPECT_GT(decided[0], 2500);  // true share of boxes outside: about 3,500 of 8,000
  EXPECT_GT(decided[1], 1500);
}

TEST(TrimIndex, EightPointsAtOnceGetTheirOwnAnswers) {
  std::mt19937_64 rng(14);
  NurbsStore store = one_face({ellipse({0, 0}, 3, 4), ellipse({1, 0}, 1, 0.5)});
  add_face(store, {polygon({{1, 2}, {3, 2}, {3, 5}, {1, 5}})});
  store.faces[1].iso_rectangle = true;
  std::vector<dvec2> star(80);
  for (dvec2& p : star) p = random_point(rng, dvec2(-4.0), dvec2(4.0));
  add_face(store, {polygon(star)});
  add_face(store, {polygon(star)});
  store.faces[3].status = FaceStatus::kBadTrim;
  for (const std::int32_t face : {0, 2}) {
    Surface& surface = store.surfaces[store.faces[face].surface];
    surface.periodic_u = true, surface.period_u = 2 * kPi;
  }
  const TrimIndex index(store);
  int inside = 0;
  for (int round = 0; round < 20000; ++round) {
    const std::int32_t face = round % 4;
    double u[8], v[8], wrapped_u[8], wrapped_v[8];
    for (int i = 0; i < 8; ++i) {
      const dvec2 p = random_point(rng, dvec2(-12.0, -6.0), dvec2(12.0, 6.0));
      u[i] = wrapped_u[i] = i == 7 && round % 64 == 0 ? kNaN : p.x, v[i] = wrapped_v[i] = p.y;
    }
    const std::uint32_t which = rng() & 0xff;
    index.wrap(face, wrapped_u, wrapped_v, which);
    const std::uint32_t got = index.inside(face, wrapped_u, wrapped_v, which);
    for (int i = 0; i < 8; ++i) {
      if (!(which >> i & 1u)) {
        EXPECT_FALSE(got >> i & 1u);
        EXPECT_EQ(wrapped_v[i], v[i]);
        continue;
      }
      const dvec2 one = index.wrap(face, dvec2(u[i], v[i]));
      EXPECT_TRUE(wrapped_u[i] == one.x || std::isnan(u[i]));
      EXPECT_EQ(wrapped_v[i], one.y);
      EXPECT_EQ((got >> i & 1u) != 0, index.inside(face, one)) << face << " " << one.x << " " << one.y;
      inside += static_cast<int>(got >> i & 1u);
    }
  }
  EXPECT_GT(inside, 5000);
}

TEST(TrimIndex, SameAnswersFromAnyNumberOfThreads) {
  NurbsStore store;
  std::mt19937_64 rng(12);
  for (int f = 0; f < 40; ++f) add_face(store, {ellipse(random_point(rng, dvec2(0), dvec2(1)), 1.0, 0.5)});
  const TrimIndex one(store, 1), all(store, 0);
  for (int i = 0; i < 20000; ++i) {
    const dvec2 p = random_point(rng, dvec2(-1), dvec2(2));
    EXPECT_EQ(one.inside(i % 40, p), all.inside(i % 40, p));
  }
}

TEST(TrimIndex, ManyPieces) {
  std::mt19937_64 rng(13);
  for (const int pieces : {4, 16, 64, 256, 1024}) {
    TrimLoop loop;
    std::vector<dvec2> points;
    for (int i = 0; i < 3 * pieces; ++i) {
      const double a = 2 * kPi * i / (3 * pieces);
      points.push_back((1.0 + 0.2 * std::sin(7 * a) + (i % 3 ? 0.3 / pieces : 0.0)) *
                       dvec2(std::cos(a), std::sin(a)));
    }
    for (int i = 0; i < pieces; ++i) {
      TrimPiece piece;
      for (int k = 0; k < 4; ++k) piece.push_back(dvec3(points[(3 * i + k) % points.size()], 1.0));
      loop.push_back(piece);
    }
    const TrimIndex index(one_face({loop}));
    const Polyline oracle = dense(loop, 20000 / pieces);
    std::vector<dvec2> queries(300);
    for (dvec2& q : queries) q = random_point(rng, dvec2(-1.2), dvec2(1.2));
    for (const dvec2& q : queries) {
      if (oracle.distance(q) > 1e-5) {
        EXPECT_EQ(index.inside(0, q), oracle.odd(q));
      }
    }
  }
}

}  // namespace
}  // namespace trimray::nurbs
