// Which rays of a packet may come near an edge: a cheap, conservative sieve before EdgeRule::near_edges.
#pragma once

#include "core/nurbs/store.h"
#include "core/trace/traverse.h"

namespace trimray::trace {

// The paths of one prototype's edges as capsules, in a hierarchy of their own.
class EdgeSieve {
 public:
  // chord_tolerance: how far a capsule's segment may be from the path, as a fraction of the prototype's
  // diagonal. The farther, the fewer capsules and the thicker.
  EdgeSieve(const nurbs::NurbsStore& store, std::int32_t prototype, double chord_tolerance);

  const Bvh& bvh() const { return bvh_; }
  std::int64_t bytes() const {
    return bvh_.bytes() + static_cast<std::int64_t>(capsules_.size() * sizeof(Capsule));
  }
  const Box3& box() const { return box_; }
  std::span<const Capsule> capsules() const { return capsules_; }  // the primitives of bvh()

  // How far along a ray, before and behind its place on an edge's path, the edge can matter.
  static double slack(const nurbs::Edge& edge) { return 4.0 * edge.band; }
  double chord_tolerance() const { return chord_tolerance_; }  // mm
  double max_slack() const { return max_slack_; }

  // The live rays of the packet (set up for bvh()) that may pass within the band of some edge at a t
  // in [tmin - slack, tmax + slack]. Clears packet.live.
  std::uint64_t near(RayPacket& packet, std::uint64_t* nodes) const;

 private:
  Bvh bvh_;
  Box3 box_;
  std::vector<Capsule> capsules_;
  double max_slack_ = 0.0, chord_tolerance_ = 0.0;
};

// The tolerances of a prototype's sieves, the first the finest.
inline constexpr double kChordTolerances[] = {1e-5, 4e-5, 1.6e-4, 6.4e-4, 2.5e-3};

}  // namespace trimray::trace
