#include "core/tess/face_net.h"

namespace trimray::tess {

double FaceNet::corner_gap(const Triangle& t) const {
  return std::max(points_[t[0]].gap, std::max(points_[t[1]].gap, points_[t[2]].gap));
}

FaceNet::LongestSide FaceNet::longest_side(const Triangle& t) const {
  LongestSide r{};
  double longest = -1.0;
  const dvec3 cross =
      glm::cross(points_[t[1]].place - points_[t[0]].place, points_[t[2]].place - points_[t[0]].place);
  for (int k = 0; k < 3; ++k) {
    const int a = t[k], b = t[(k + 1) % 3];
    const double length = glm::distance(points_[a].place, points_[b].place);
    if (length > longest) longest = length, r.ends = {std::min(a, b), std::max(a, b)};
  }
  r.length = longest;
  r.height = longest > 0.0 ? glm::length(cross) / longest : 0.0;
  return r;
}

bool FaceNet::collapsed(const Triangle& t) const {
  const VertexKey a = points_[t[0]].vertex, b = points_[t[1]].vertex, c = points_[t[2]].vertex;
  return a == b || b == c || c == a;
}

bool FaceNet::degenerate(const Triangle& t) const {
  constexpr double kNoHeight = 1e-9;
  const LongestSide side = longest_side(t);
  return !collapsed(t) && side.height <= kNoHeight * side.length;
}

double FaceNet::turned(const Triangle& t) const {
  const dvec2 a = points_[t[1]].p - points_[t[0]].p, b = points_[t[2]].p - points_[t[0]].p;
  return a.x * b.y - a.y * b.x;
}

// The way to cells and back bends straight lines, and may turn a triangle beside them over.
bool FaceNet::some_turned() const {
  for (const auto& t : triangles_)
    if (turned(t) < 0.0 && !collapsed(t)) return true;
  return false;
}

void FaceNet::flip_degenerate() {
  constexpr int kPasses = 32;
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<int> flat;
    for (std::size_t i = 0; i < triangles_.size(); ++i)
      if (degenerate(triangles_[i])) flat.push_back(static_cast<int>(i));
    if (flat.empty()) return;
    IndexMap<2, std::array<int, 2>> beside;
    for (const int i : flat) beside[longest_side(triangles_[i]).ends] = {-1, -1};
    for (std::size_t i = 0; i < triangles_.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const auto found = beside.find(ordered(triangles_[i][k], triangles_[i][(k + 1) % 3]));
        if (found != beside.end()) found->second[found->second[0] < 0 ? 0 : 1] = static_cast<int>(i);
      }
    std::vector<bool> touched(triangles_.size(), false);
    bool any = false;
    for (const int i : flat) {
      const std::array<int, 2> ends = longest_side(triangles_[i]).ends;
      const auto [one, two] = beside[ends];
      const int other = one == i ? two : one;
      if (other < 0 || boundary_.count(ends) || touched[i] || touched[other]) continue;
      if (!flip(triangles_[i], triangles_[other], ends)) continue;
      touched[i] = touched[other] = any = true;
    }
    if (!any) return;
  }
}

bool FaceNet::flip(Triangle& t, Triangle& u, const std::array<int, 2>& ends) const {
  const auto opposite = [&](const Triangle& x) {
    int k = 0;
    while (x[k] == ends[0] || x[k] == ends[1]) ++k;
    return k;
  };
  const int k = opposite(t), a = t[k], i = t[(k + 1) % 3], j = t[(k + 2) % 3], c = u[opposite(u)];
  const Triangle first{a, i, c}, second{c, j, a};
  if (turned(first) <= 0.0 || turned(second) <= 0.0) return false;
  // Past a triangle that is collapsed at a pole the flat one goes on to the next.
  const bool better = !collapsed(first) && !collapsed(second) && !degenerate(first) && !degenerate(second);
  if (!better && !collapsed(u)) return false;
  t = first, u = second;
  return true;
}

}  // namespace trimray::tess
