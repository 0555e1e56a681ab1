// FaceNet: the nodes, sides and triangles of one face while it is meshed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/tess/face_polygon.h"

namespace trimray::tess {

// Of a few indices.
struct IndexHash {
  template <std::size_t N>
  std::size_t operator()(const std::array<int, N>& a) const {
    std::uint64_t h = 0;
    for (const int i : a) h = (h ^ static_cast<std::uint32_t>(i)) * 0x9E3779B97F4A7C15u, h ^= h >> 29;
    return h;
  }
};
template <std::size_t N, typename T>
using IndexMap = std::unordered_map<std::array<int, N>, T, IndexHash>;

class FaceNet {
 protected:
  using Triangle = std::array<int, 3>;  // of nodes, counter-clockwise in the chart

  struct Node {
    dvec2 p;               // chart
    dvec3 place, surface;  // the vertex, and the surface's point at p
    double gap;            // their distance
    VertexKey vertex;
    dvec3 normal;  // unit, where an angle is asked for
  };

  struct LongestSide {
    std::array<int, 2> ends;
    double length, height;  // its own and the triangle's over it, mm
  };

  static std::array<int, 2> ordered(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

  double corner_gap(const Triangle& t) const;
  LongestSide longest_side(const Triangle& t) const;
  // Two corners at one vertex: a triangle at a pole, which has no area.
  bool collapsed(const Triangle& t) const;
  // No height to speak of in space.
  bool degenerate(const Triangle& t) const;
  // Twice the area in the chart.
  double turned(const Triangle& t) const;
  bool some_turned() const;

  // Three places on a line of space need not lie on a line of the chart: two on a ruling and the apex. The
  // neighbour over the longest side takes the middle one in.
  void flip_degenerate();

  std::vector<Node> points_;
  std::vector<std::array<int, 2>> sides_;               // of the polygon
  std::vector<std::array<std::int32_t, 2>> side_edge_;  // by side: edge and segment, or -1
  std::vector<double> side_deviation_;                  // by side, mm, from the edge's curve
  IndexMap<2, int> boundary_;                           // side by its ends, the lower first
  std::vector<Triangle> triangles_;

 private:
  // Turns the side that two triangles share; false where they do not allow it.
  bool flip(Triangle& t, Triangle& u, const std::array<int, 2>& ends) const;
};

}  // namespace trimray::tess
