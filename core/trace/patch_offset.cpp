#include "core/trace/patch_offset.h"

#include <algorithm>
#include <cmath>

#include "core/nurbs/knot_vector.h"
#include "core/trace/certificate.h"

namespace trimray::trace {
namespace {

constexpr int kMaxOffsetBoxes = 20000;
constexpr double kMinWidth = 1.0 / (1 << 29);

// Point and derivatives of the base surface up to the second, by the Bernstein basis.
struct BaseJet {
  dvec3 s, su, sv, suu, suv, svv;
};

struct BasisRow {
  double d[3][nurbs::kMaxDegree + 1];
};

BasisRow basis(int n, double x) {
  BasisRow r = {};
  double b[3][nurbs::kMaxDegree + 1] = {};  // degrees n - 2, n - 1, n (padded)
  const auto fill = [x](int degree, double* out) {
    out[0] = 1.0;
    for (int k = 1; k <= degree; ++k) {
      out[k] = out[k - 1] * x;
      for (int i = k - 1; i >= 1; --i) out[i] = out[i] * (1.0 - x) + out[i - 1] * x;
      out[0] *= 1.0 - x;
    }
  };
  fill(n, b[2]), fill(n - 1, b[1]);
  if (n >= 2) fill(n - 2, b[0]);
  const auto at = [](const double* v, int i, int degree) { return i >= 0 && i <= degree ? v[i] : 0.0; };
  for (int i = 0; i <= n; ++i) {
    r.d[0][i] = b[2][i];
    r.d[1][i] = n * (at(b[1], i - 1, n - 1) - at(b[1], i, n - 1));
    if (n >= 2)
      r.d[2][i] = n * (n - 1) * (at(b[0], i - 2, n - 2) - 2.0 * at(b[0], i - 1, n - 2) + at(b[0], i, n - 2));
  }
  return r;
}

BaseJet base_jet(const Patch& patch, const dvec4* net, double u, double v) {
  const BasisRow bu = basis(patch.degree_u, u), bv = basis(patch.degree_v, v);
  dvec4 h[3][3] = {};
  for (auto& row : h)
    for (dvec4& x : row) x = dvec4(0.0);
  for (int i = 0; i <= patch.degree_u; ++i)
    for (int j = 0; j <= patch.degree_v; ++j)
      for (int a = 0; a <= 2; ++a)
        for (int b = 0; a + b <= 2; ++b) h[a][b] += bu.d[a][i] * bv.d[b][j] * net[i * (patch.degree_v + 1) + j];
  const auto p = [&](int a, int b) { return dvec3(h[a][b].x, h[a][b].y, h[a][b].z); };
  const double w = h[0][0].w;
  BaseJet j;
  j.s = p(0, 0) / w;
  j.su = (p(1, 0) - j.s * h[1][0].w) / w;
  j.sv = (p(0, 1) - j.s * h[0][1].w) / w;
  j.suu = (p(2, 0) - 2.0 * j.su * h[1][0].w - j.s * h[2][0].w) / w;
  j.suv = (p(1, 1) - j.su * h[0][1].w - j.sv * h[1][0].w - j.s * h[1][1].w) / w;
  j.svv = (p(0, 2) - 2.0 * j.sv * h[0][1].w - j.s * h[0][2].w) / w;
  return j;
}

struct OffsetJet {
  dvec3 p, pu, pv, normal;  // normal: of the base surface, unit
};

// The offset's tangents: n_u = (N_u - n (n . N_u)) / |N| with N = S_u x S_v.
OffsetJet offset_jet(const Patch& patch, const dvec4* net, double u, double v) {
  const BaseJet j = base_jet(patch, net, u, v);
  const dvec3 n = glm::cross(j.su, j.sv);
  const double length = glm::length(n);
  const dvec3 unit = n / length;
  const dvec3 nu = glm::cross(j.suu, j.sv) + glm::cross(j.su, j.suv);
  const dvec3 nv = glm::cross(j.suv, j.sv) + glm::cross(j.su, j.svv);
  const auto turn = [&](const dvec3& d) { return (d - unit * glm::dot(unit, d)) / length; };
  return {j.s + patch.offset * unit, j.su + patch.offset * turn(nu), j.sv + patch.offset * turn(nv), unit};
}

struct OffsetSearch {
  const Patch& patch;
  const dvec4* net;
  const Ray& ray;
  std::vector<PatchRoot>& roots;
  std::size_t first;
  dvec3 o{0.0};
  double t_shift = 0.0;

  OffsetSearch(const Patch& p, const dvec4* n, const Ray& r, std::vector<PatchRoot>& out)
      : patch(p), net(n), ray(r), roots(out), first(out.size()) {
    const dvec3 org = ray.org - patch.origin;
    t_shift = -glm::dot(org, ray.dir);
    o = org + t_shift * ray.dir;
  }

  // Newton with the true derivative; the answer is one full step from a point of the root grid.
  bool newton(dvec2 x, double max_step, PatchRoot& root) const {
    const auto step = [&](const dvec2& at, OffsetJet& j) {
      j = offset_jet(patch, net, at.x, at.y);
      const dvec3 g = glm::cross(j.p - o, ray.dir);
      const double den = glm::dot(glm::cross(j.pu, j.pv), ray.dir);
      return dvec2(glm::dot(g, j.pv), -glm::dot(g, j.pu)) / den;
    };
    OffsetJet j;
    bool converged = false;
    for (int k = 0; k < 4 * kMaxNewtonSteps && !converged; ++k) {
      const dvec2 d = step(x, j);
      if (!(std::fabs(d.x) < kInf && std::fabs(d.y) < kInf)) return false;
      converged = std::fabs(d.x) <= 1e-8 && std::fabs(d.y) <= 1e-8;
      x += glm::clamp(d, dvec2(-max_step), dvec2(max_step));
    }
    if (!converged) return false;
    x = glm::round(x / kRootGrid) * kRootGrid;
    const dvec2 d = step(x, j);
    if (!(std::fabs(d.x) <= 4.0 * kRootGrid && std::fabs(d.y) <= 4.0 * kRootGrid)) return false;
    const dvec3 p = j.p + j.pu * d.x + j.pv * d.y;
    dvec3 normal = j.normal;
    // Where the offset exceeds a radius of curvature its tangents turn over, and with them its normal.
    if (glm::dot(glm::cross(j.pu, j.pv), normal) < 0.0) normal = -normal;
    root = {x.x + d.x, x.y + d.y, t_shift + glm::dot(p - o, ray.dir), normal};
    return true;
  }

  void add(const PatchRoot& root) {
    for (std::size_t k = first; k < roots.size(); ++k)
      if (std::fabs(roots[k].u - root.u) <= 1e-10 && std::fabs(roots[k].v - root.v) <= 1e-10) return;
    roots.push_back(root);
  }
};

// Distance of the line from a point.
double line_distance(const dvec3& p, const dvec3& o, const dvec3& d) { return glm::length(glm::cross(p - o, d)); }

// At most one root, judged by the tangents at the middle and at eight points of the rim, their spread taken
// four times: an estimate, not a proof.
bool looks_unique(const OffsetSearch& s, const SubDomain& d, const OffsetJet& middle) {
  double ru = 0.0, rv = 0.0;
  for (int k = 0; k < 9; ++k) {
    const OffsetJet j = offset_jet(s.patch, s.net, glm::mix(d.u0, d.u1, 0.5 * (k / 3)),
                                   glm::mix(d.v0, d.v1, 0.5 * (k % 3)));
    ru = std::max(ru, glm::length(j.pu - middle.pu)), rv = std::max(rv, glm::length(j.pv - middle.pv));
  }
  ru *= 4.0, rv *= 4.0;
  const double den = std::fabs(glm::dot(glm::cross(middle.pu, middle.pv), s.ray.dir));
  return den > glm::length(middle.pu) * rv + glm::length(middle.pv) * ru + ru * rv;
}

}  // namespace

void offset_roots(const Patch& patch, const PatchPool& pool, const LeafBound& leaf, const Ray& ray,
                  std::vector<PatchRoot>& roots) {
  const dvec4* net = pool.net.data() + patch.net;
  OffsetSearch search(patch, net, ray, roots);
  std::vector<SubDomain> stack{{leaf.mid_u - leaf.half_u, leaf.mid_u + leaf.half_u, leaf.mid_v - leaf.half_v,
                                leaf.mid_v + leaf.half_v}};
  for (int boxes = 0; !stack.empty() && boxes < kMaxOffsetBoxes; ++boxes) {
    const SubDomain d = stack.back();
    stack.pop_back();
    const LeafProof proof = prove_leaf(patch, net, d);
    const LeafBound& b = proof.bound;
    const dvec3 c(b.center[0], b.center[1], b.center[2]), n(b.ab[0], b.ab[1], b.ab[2]);
    const dvec3 a(b.a[0], b.a[1], b.a[2]), t(b.b[0], b.b[1], b.b[2]);
    const double wu = d.u1 - d.u0, wv = d.v1 - d.v0;
    const bool small = wu <= kMinWidth && wv <= kMinWidth;

    // Exclusion: the hull's ball, the offset about the middle normal n +- the cone of normals.
    const Box3& hull = proof.box;
    // The hull is widened by the offset on every side; unless it is a cube, its diagonal grows by less than
    // sqrt(3) times as much.
    const double radius = 0.5 * glm::length(glm::max(hull.extent() - 2.0 * std::fabs(patch.offset), dvec3(0.0)));
    const bool cone = proof.sine < 1.0;
    const double spread = cone ? 2.0 * std::sin(0.5 * std::asin(proof.sine)) : 2.0;
    const dvec3 center = cone ? c + patch.offset * n / glm::length(n) : hull.center();
    const double reach = cone ? radius + glm::length(c - hull.center()) + std::fabs(patch.offset) * spread
                              : radius + std::fabs(patch.offset);
    if (line_distance(center, search.o, ray.dir) > reach * (1.0 + 1e-9) + 1e-13 * patch.size) continue;

    if (cone) {
      const OffsetJet middle = offset_jet(patch, net, b.mid_u, b.mid_v);
      const SubDomain wide{d.u0 - 0.0625 * wu, d.u1 + 0.0625 * wu, d.v0 - 0.0625 * wv, d.v1 + 0.0625 * wv};
      PatchRoot root;
      if (looks_unique(search, wide, middle) &&
          search.newton(dvec2(b.mid_u, b.mid_v), std::max(wu, wv), root) && root.u >= wide.u0 &&
          root.u <= wide.u1 && root.v >= wide.v0 && root.v <= wide.v1) {
        if (root.u >= d.u0 - kLeafSlack && root.u <= d.u1 + kLeafSlack && root.v >= d.v0 - kLeafSlack &&
            root.v <= d.v1 + kLeafSlack)
          search.add(root);
        continue;
      }
    }
    if (small) continue;
    SubDomain low = d, high = d;
    if (wv <= kMinWidth || (wu > kMinWidth && glm::length(a) >= glm::length(t))) low.u1 = high.u0 = 0.5 * (d.u0 + d.u1);
    else low.v1 = high.v0 = 0.5 * (d.v0 + d.v1);
    stack.push_back(high), stack.push_back(low);
  }
}

}  // namespace trimray::trace
