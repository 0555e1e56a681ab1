// What the lanes of open_lanes.cpp leave to its scalar part. Internal to it.
#pragma once

#include <algorithm>
#include <vector>

#include "core/trace/certificate.h"
#include "core/trace/open_lanes.h"

namespace trimray::trace {

// Halvings, both directions together, before the whole leaf goes to clip_roots: roots nearer than this, and
// lines that graze the surface nearer, are rare.
inline constexpr int kMaxHalvings = 14;

// Newton ends beside the part where its root was expected: clip_roots looks at that part, or, after so many
// of them, at the whole leaf.
inline constexpr int kMaxSearchedParts = 4;

// A root at which the line is flatter to the surface than this, the sine of the angle, sends the line to
// clip_roots: of roots that nearly coincide Newton does not give the same bits from every start.
inline constexpr double kTangent = 3e-5;

// A part in which a lane has at most one root, and where to look for it.
struct OpenCandidate {
  int lane;
  double u, v;
  SubDomain part;
};

struct OpenPart {
  int lane;
  SubDomain part;
};

// What the lanes find, for the scalar rest.
struct OpenWork {
  std::vector<LanePatchRoot> roots;
  std::vector<OpenPart> parts;
  std::uint32_t whole = 0;  // lanes of which the whole leaf is to be searched
  int parts_of[kLanes] = {};
  OpenStats stats;

  void clear() {
    roots.clear(), parts.clear();
    whole = 0, stats = {};
    std::fill_n(parts_of, kLanes, 0);
  }
  void search(int lane, const SubDomain& part) {
    if (++parts_of[lane] > kMaxSearchedParts) whole |= 1u << lane;
    parts.push_back({lane, part});
  }
};

inline bool contains(const SubDomain& d, double u, double v) {
  return u >= d.u0 - kLeafSlack && u <= d.u1 + kLeafSlack && v >= d.v0 - kLeafSlack && v <= d.v1 + kLeafSlack;
}

inline SubDomain core_of(const LeafBound& leaf) {
  return {leaf.mid_u - leaf.half_u, leaf.mid_u + leaf.half_u, leaf.mid_v - leaf.half_v,
          leaf.mid_v + leaf.half_v};
}

}  // namespace trimray::trace
