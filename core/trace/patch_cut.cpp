#include "core/trace/patch_cut.h"

#include <algorithm>
#include <cmath>

#include "core/nurbs/spline.h"
#include "core/trace/certificate.h"

namespace trimray::trace {
namespace {

// Leaves are halved until the proof of one root holds for rays as flat as wanted, or so often.
constexpr int kMaxCuts = 8;
constexpr int kMaxCutsAtPole = 6;  // a leaf at a collapsed side is never proven

bool touches_pole(const Patch& patch, const SubDomain& d) {
  return ((patch.poles & kSideU0) && d.u0 <= 0.0) || ((patch.poles & kSideU1) && d.u1 >= 1.0) ||
         ((patch.poles & kSideV0) && d.v0 <= 0.0) || ((patch.poles & kSideV1) && d.v1 >= 1.0);
}

// sine: PatchInput's. Returns the part's place in the tree, as LeafSplit::child.
std::int32_t cut(std::int32_t index, const SubDomain& d, int cuts, double sine, PatchPool& pool) {
  const Patch patch = pool.patches[index];
  const dvec4* net = pool.net.data() + patch.net;
  const LeafProof proof = prove_leaf(patch, net, d);
  const int allowed = touches_pole(patch, d) ? kMaxCutsAtPole : kMaxCuts;
  if (proof.sine > sine && cuts < allowed) {
    SubDomain low = d, high = d;
    const bool in_u = std::isfinite(proof.bend_u) && proof.bend_u != proof.bend_v
                          ? proof.bend_u > proof.bend_v
                          : (cuts & 1) == 0;
    if (in_u)
      low.u1 = high.u0 = 0.5 * (d.u0 + d.u1);
    else
      low.v1 = high.v0 = 0.5 * (d.v0 + d.v1);
    const auto place = static_cast<std::int32_t>(pool.splits.size());
    pool.splits.push_back({static_cast<float>(in_u ? low.u1 : low.v1), in_u, {-1, -1}});
    const std::int32_t below = cut(index, low, cuts + 1, sine, pool),
                       above = cut(index, high, cuts + 1, sine, pool);
    pool.splits[place].child[0] = below, pool.splits[place].child[1] = above;
    return place;
  }
  PatchLeaf leaf;
  leaf.box = proof.box;
  leaf.box.lower += patch.origin, leaf.box.upper += patch.origin;
  leaf.uv_face.add(dvec2(patch.u.to_face(d.u0), patch.v.to_face(d.v0)));
  leaf.uv_face.add(dvec2(patch.u.to_face(d.u1), patch.v.to_face(d.v1)));
  leaf.face = patch.face;
  leaf.patch = index;
  leaf.sub = static_cast<std::int32_t>(pool.leaves.size());
  pool.leaves.push_back(leaf);
  pool.bounds.push_back(proof.bound);
  return ~leaf.sub;
}

// Into how many equal parts the curves along one direction of a net must be cut so that each is at most
// flat_mm from its chord: Wang's bound from second differences ("The subdivision method for finding the
// intersection between two Bezier curves or surfaces", 1984). A guess where weights differ. At most 64.
int flat_parts(const dvec4* net, int degree, int stride, int across, int across_stride, double flat_mm) {
  double bend = 0.0;
  for (int j = 0; j <= across; ++j)
    for (int i = 0; i + 2 <= degree; ++i) {
      const auto point = [&](int k) { return nurbs::project(net[j * across_stride + k * stride]); };
      bend = std::max(bend, glm::length(point(i) - 2.0 * point(i + 1) + point(i + 2)));
    }
  const double parts = std::ceil(std::sqrt(degree * (degree - 1) * bend / (8.0 * flat_mm)));
  return parts > 1.0 ? static_cast<int>(std::min(parts, 64.0)) : 1;  // 1 for what is not a number
}

// At least nu x nv leaves.
struct UniformCut {
  std::int32_t index;
  int nu, nv, cuts;  // cuts: what the parts amount to
  double sine;
  PatchPool& pool;

  // Of the parts [i0, i1) x [j0, j1), as cut().
  std::int32_t operator()(int i0, int i1, int j0, int j1) const {
    const auto u = [&](int i) { return static_cast<double>(i) / nu; };
    const auto v = [&](int j) { return static_cast<double>(j) / nv; };
    if (i1 - i0 == 1 && j1 - j0 == 1) return cut(index, {u(i0), u(i1), v(j0), v(j1)}, cuts, sine, pool);
    const bool in_u = i1 - i0 >= j1 - j0;
    const int i = (i0 + i1) / 2, j = (j0 + j1) / 2;
    const auto place = static_cast<std::int32_t>(pool.splits.size());
    pool.splits.push_back({static_cast<float>(in_u ? u(i) : v(j)), in_u, {-1, -1}});
    const std::int32_t below = in_u ? (*this)(i0, i, j0, j1) : (*this)(i0, i1, j0, j);
    const std::int32_t above = in_u ? (*this)(i, i1, j0, j1) : (*this)(i0, i1, j, j1);
    pool.splits[place].child[0] = below, pool.splits[place].child[1] = above;
    return place;
  }
};

}  // namespace

std::int32_t cut_patch(std::int32_t index, const PatchInput& input, PatchPool& pool) {
  const int du = input.degree_u, dv = input.degree_v;
  const int nu = std::max(input.parts_u, flat_parts(input.net, du, dv + 1, dv, 1, input.flat_mm)),
            nv = std::max(input.parts_v, flat_parts(input.net, dv, 1, du, dv + 1, input.flat_mm));
  int cuts = 0;
  while (1 << cuts < nu * nv) ++cuts;
  return UniformCut{index, nu, nv, cuts, input.sine, pool}(0, nu, 0, nv);
}

}  // namespace trimray::trace
