// Speed of the patch kernel alone, without hierarchy or trimming: parallel rays in blocks of 4 x 2 pixels
// against every leaf whose box they meet.
//
//   patch_bench [PATCHES.txt]     bicubic patches, 16 lines "x y z [w]" each; without a file, random ones
//   patch_bench DU DV [0|1]       random patches of other degrees; 1: rational
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/nurbs/make_store.h"
#include "core/trace/newton.h"
#include "core/trace/patch.h"

namespace trimray::trace {
namespace {

constexpr int kWidthPx = 1024;

// Processor time: other work on the machine does not count.
double seconds_now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

std::vector<std::vector<dvec4>> read_patches(const char* path) {
  std::vector<std::vector<dvec4>> patches;
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream values(line);
    dvec3 p;
    double w = 1.0;
    if (!(values >> p.x >> p.y >> p.z)) continue;
    values >> w;
    if (patches.empty() || patches.back().size() == 16) patches.emplace_back();
    patches.back().push_back(dvec4(p * w, w));
  }
  return patches;
}

std::vector<std::vector<dvec4>> random_patches(int side, int du, int dv, bool rational) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> noise(-0.06, 0.06), weight(0.7, 1.4);
  std::vector<std::vector<dvec4>> patches;
  for (int k = 0; k < side * side; ++k) {
    patches.emplace_back();
    for (int i = 0; i <= du; ++i)
      for (int j = 0; j <= dv; ++j) {
        const dvec3 p(k % side + double(i) / du + noise(rng), k / side + double(j) / dv + noise(rng),
                      3.0 * noise(rng));
        const double w = rational ? weight(rng) : 1.0;
        patches.back().push_back(dvec4(p * w, w));
      }
  }
  return patches;
}

struct Counts {
  long long rays = 0, one = 0, none = 0, steps = 0, calls = 0;
  double seconds = 0.0, clip_seconds = 0.0;
  long long clipped = 0, clip_roots = 0;
  double seeded_seconds = 0.0, again_seconds = 0.0;  // seeded, and solve() on the same lanes
  long long seeds = 0, seeded = 0, seeded_steps = 0, again_steps = 0;
};

// The roots of `out` once more, from seeds about `off` of a patch away, and by solve() for comparison.
void shoot_seeded(const PatchSet& set, std::int32_t leaf, const std::vector<RayLanes>& blocks,
                  const std::vector<RootLanes>& out, double off, Counts& counts) {
  std::vector<RayLanes> rays;
  std::vector<SeedLanes> seeds;
  std::mt19937 rng(17);
  std::uniform_real_distribution<double> noise(-off, off);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    if (out[k].one == 0) continue;
    rays.push_back(blocks[k]);
    rays.back().active = out[k].one;
    seeds.emplace_back();
    for (int i = 0; i < kLanes; ++i) {
      const bool one = out[k].one >> i & 1u;
      seeds.back().u[i] = one ? out[k].u[i] + noise(rng) : 0.5;
      seeds.back().v[i] = one ? out[k].v[i] + noise(rng) : 0.5;
    }
    counts.seeds += std::popcount(out[k].one);
  }
  const std::int32_t patch = set.leaves()[leaf].patch;
  std::vector<SeededRoots> seeded(rays.size());
  std::vector<RootLanes> again(rays.size());
  const double start = seconds_now();
  for (std::size_t k = 0; k < rays.size(); ++k) set.solve_seeded(patch, rays[k], seeds[k], seeded[k]);
  const double middle = seconds_now();
  for (std::size_t k = 0; k < rays.size(); ++k) set.solve(leaf, rays[k], again[k]);
  const double end = seconds_now();
  counts.seeded_seconds += middle - start, counts.again_seconds += end - middle;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    counts.seeded += std::popcount(seeded[k].one), counts.seeded_steps += seeded[k].steps;
    counts.again_steps += again[k].steps;
  }
}

void shoot(const PatchSet& set, const dvec3& dir, const Box3& bounds, Counts& counts) {
  const dvec3 away = std::fabs(dir.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
  const dvec3 right = glm::normalize(glm::cross(dir, away)), up = glm::cross(right, dir);
  const double pixel = bounds.diagonal() / kWidthPx;
  const dvec3 corner = bounds.center() - 0.5 * bounds.diagonal() * (right + up) - bounds.diagonal() * dir;
  std::vector<Root> roots;
  for (std::size_t leaf = 0; leaf < set.leaves().size(); ++leaf) {
    Box2 shadow;
    const Box3& box = set.leaves()[leaf].box;
    for (int k = 0; k < 8; ++k) {
      const dvec3 p(k & 1 ? box.upper.x : box.lower.x, k & 2 ? box.upper.y : box.lower.y,
                    k & 4 ? box.upper.z : box.lower.z);
      shadow.add(dvec2(glm::dot(p - corner, right), glm::dot(p - corner, up)) / pixel);
    }
    std::vector<RayLanes> blocks;
    for (int y = int(shadow.lower.y) & ~1; y <= shadow.upper.y; y += 2)
      for (int x = int(shadow.lower.x) & ~3; x <= shadow.upper.x; x += 4) {
        RayLanes rays = {};
        for (int k = 0; k < 8; ++k) {
          const dvec3 o = corner + pixel * (double(x + (k & 3)) * right + double(y + (k >> 2)) * up);
          rays.org_x[k] = o.x, rays.org_y[k] = o.y, rays.org_z[k] = o.z;
          rays.dir_x[k] = dir.x, rays.dir_y[k] = dir.y, rays.dir_z[k] = dir.z;
          // The box itself, by slabs.
          double near = -kInf, far = kInf;
          for (int c = 0; c < 3; ++c) {
            const double a = (box.lower[c] - o[c]) / dir[c], b = (box.upper[c] - o[c]) / dir[c];
            near = std::max(near, std::min(a, b)), far = std::min(far, std::max(a, b));
          }
          if (near <= far) rays.active |= 1u << k;
        }
        if (rays.active != 0) blocks.push_back(rays);
      }
    std::vector<RootLanes> out(blocks.size());
    const double start = seconds_now();
    for (std::size_t k = 0; k < blocks.size(); ++k)
      set.solve(static_cast<std::int32_t>(leaf), blocks[k], out[k]);
    const double middle = seconds_now();
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const RayLanes& r = blocks[k];
      const std::uint32_t open = r.active & ~(out[k].one | out[k].none);
      for (int i = 0; i < kLanes; ++i)
        if (open >> i & 1u) {
          roots.clear();
          set.all_roots(static_cast<std::int32_t>(leaf),
                        {{r.org_x[i], r.org_y[i], r.org_z[i]}, {r.dir_x[i], r.dir_y[i], r.dir_z[i]}}, roots);
          ++counts.clipped;
          counts.clip_roots += static_cast<long long>(roots.size());
        }
      counts.rays += std::popcount(r.active), counts.one += std::popcount(out[k].one);
      counts.none += std::popcount(out[k].none), counts.steps += out[k].steps;
    }
    const double end = seconds_now();
    shoot_seeded(set, static_cast<std::int32_t>(leaf), blocks, out, 0.01, counts);
    counts.calls += static_cast<long long>(blocks.size());
    counts.seconds += middle - start;
    counts.clip_seconds += end - middle;
  }
}

int run(int argc, char** argv) {
  std::vector<nurbs::FaceSpec> faces;
  const bool degrees = argc > 2;
  const int du = degrees ? std::atoi(argv[1]) : 3, dv = degrees ? std::atoi(argv[2]) : 3;
  const bool rational = argc > 3 ? std::atoi(argv[3]) != 0 : !degrees;
  for (const auto& net : argc == 2 ? read_patches(argv[1]) : random_patches(6, du, dv, rational)) {
    nurbs::FaceSpec face;
    face.surface = nurbs::make_bezier(du, dv, net);
    face.uv_box.add(dvec2(0.0)), face.uv_box.add(dvec2(1.0));
    faces.push_back(face);
  }
  const auto store = nurbs::make_store(faces);
  const std::vector<double> margin(faces.size(), 1e-6);
  const double start = seconds_now();
  const PatchSet set(store, 0, margin, 1);
  const double built = seconds_now() - start;
  Box3 bounds;
  for (const PatchLeaf& leaf : set.leaves()) bounds.add(leaf.box);
  Counts c;
  for (const dvec3& dir : {dvec3(1, 1, -1), dvec3(-1, 2, -0.5), dvec3(0.2, 0.1, -3)})
    shoot(set, glm::normalize(dir), bounds, c);
  std::printf("target %s\n%zu patches, %.1f leaves per patch, %.1f kB, built in %.2f ms\n",
              simd_target_name(), faces.size(), double(set.leaves().size()) / faces.size(),
              set.bytes() / 1024.0, built * 1e3);
  std::printf("%lld rays against leaves, %.2f lanes per call: %.2f ns per ray, %.1f ns per root\n", c.rays,
              double(c.rays) / c.calls, c.seconds / c.rays * 1e9, c.seconds / c.one * 1e9);
  std::printf("one %.2f %%, none %.2f %%, open %.3f %%; %.2f steps per root\n", 100.0 * c.one / c.rays,
              100.0 * c.none / c.rays, 100.0 * c.clipped / c.rays, double(c.steps) / c.one);
  std::printf("open rays: %.0f ns each, %.2f roots each; %.2f ns spread over all rays\n",
              c.clip_seconds / c.clipped * 1e9, double(c.clip_roots) / c.clipped,
              c.clip_seconds / c.rays * 1e9);
  std::printf(
      "seeds 1e-2 of a patch off: %.1f ns per root, one %.2f %%, %.2f steps; solve on these lanes: %.1f "
      "ns, %.2f steps\n",
      c.seeded_seconds / c.seeds * 1e9, 100.0 * c.seeded / c.seeds, double(c.seeded_steps) / c.seeds,
      c.again_seconds / c.seeds * 1e9, double(c.again_steps) / c.seeds);
  return 0;
}

}  // namespace
}  // namespace trimray::trace

int main(int argc, char** argv) { return trimray::trace::run(argc, argv); }
