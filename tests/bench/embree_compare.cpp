// Own hierarchy against Embree's, on the same leaves with the same leaf code (docs/decisions/0003).
//
//   embree_compare FILE [--size 1024] [--repeat 5]
//
// Every leaf of the scene is one box: in build_bvh()/traverse() with 64 rays a packet, and in an Embree user
// geometry with rtcIntersect8 and rtcIntersect16. Nearest hits by the trim loops alone; the edge rule is left
// out on both sides. One thread, processor time. FILE as for trace_bench; all instances at the origin.
#include <embree3/rtcore.h>

#include <bit>
#include <cstdio>
#include <functional>
#include <string>

#include "core/trace/scene_impl.h"
#include "tests/bench/bench_scene.h"

namespace {

using namespace trimray;
using trace::kPacketSize;

struct Leaf {
  const trace::PrototypeScene* prototype;
  std::int32_t primitive;
};

// 64 rays and their nearest hits; what both hierarchies call at a leaf.
struct Tester {
  std::vector<Leaf> leaves;
  trace::RayBlock block;
  std::int32_t face[kPacketSize];
  std::uint64_t tests = 0;

  bool take(int i, const trace::PrototypeScene& scene, const trace::ScenePrimitive& p, double t, dvec2 raw) {
    if (!(t >= block.tmin[i] && t < block.tmax[i])) return false;
    if (!p.inside && !scene.inside(p.face, scene.trim.wrap(p.face, raw))) return false;
    block.tmax[i] = t, face[i] = p.face;
    return true;
  }

  void closed(const trace::PrototypeScene& scene, const trace::ScenePrimitive& p, std::uint64_t rays) {
    const trace::ClosedLeaf& leaf = scene.closed_leaves[p.leaf];
    for (; rays != 0; rays &= rays - 1) {
      const int i = std::countr_zero(rays);
      trace::ClosedRoot roots[trace::kMaxClosedRoots];
      const int count = trace::closed_form_roots(scene.form(p.face), block.origin(i), block.direction(i),
                                                 leaf.uv, block.tmin[i], block.tmax[i], roots);
      for (int k = 0; k < count; ++k)
        if (take(i, scene, p, roots[k].t, roots[k].uv)) break;
    }
  }

  void patch(const trace::PrototypeScene& scene, const trace::ScenePrimitive& p, std::uint64_t rays) {
    while (rays != 0) {
      trace::RayLanes lanes;
      int index[trace::kLanes], count = 0;
      for (; rays != 0 && count < trace::kLanes; rays &= rays - 1, ++count)
        index[count] = std::countr_zero(rays);
      for (int k = 0; k < trace::kLanes; ++k) {
        const int i = index[k < count ? k : 0];
        lanes.org_x[k] = block.org[0][i], lanes.org_y[k] = block.org[1][i], lanes.org_z[k] = block.org[2][i];
        lanes.dir_x[k] = block.dir[0][i], lanes.dir_y[k] = block.dir[1][i], lanes.dir_z[k] = block.dir[2][i];
      }
      lanes.active = (1u << count) - 1u;
      trace::RootLanes roots;
      scene.patches.solve(p.leaf, lanes, roots);
      for (int k = 0; k < count; ++k) {
        if ((roots.one >> k) & 1) {
          take(index[k], scene, p, roots.t[k], {roots.u[k], roots.v[k]});
        } else if (!((roots.none >> k) & 1)) {
          std::vector<trace::Root> found;
          const int i = index[k];
          scene.patches.all_roots(p.leaf, {block.origin(i), block.direction(i), block.tmin[i], block.tmax[i]},
                                  found);
          for (const trace::Root& root : found) take(i, scene, p, root.t, root.uv_face);
        }
      }
    }
  }

  void test(std::int32_t leaf, std::uint64_t rays) {
    const trace::PrototypeScene& scene = *leaves[leaf].prototype;
    const trace::ScenePrimitive& p = scene.primitives[leaves[leaf].primitive];
    tests += std::popcount(rays);
    if (p.kind == trace::PrimitiveKind::kClosedForm)
      closed(scene, p, rays);
    else
      patch(scene, p, rays);
  }
};

struct OwnContext {
  Tester& tester;
  trace::RayPacket& boxes;
};

void own_visit(void* context, std::int32_t leaf, std::uint64_t rays) {
  auto& c = *static_cast<OwnContext*>(context);
  c.tester.test(leaf, rays);
  for (; rays != 0; rays &= rays - 1) {
    const int i = std::countr_zero(rays);
    c.boxes.set_tmax(i, c.tester.block.tmax[i]);
  }
}

struct EmbreeContext {
  RTCIntersectContext base;
  Tester* tester;
  const double* t0;
};

void embree_intersect(const RTCIntersectFunctionNArguments* args) {
  auto& context = *reinterpret_cast<EmbreeContext*>(args->context);
  RTCRayN* ray = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* hit = RTCRayHitN_HitN(args->rayhit, args->N);
  std::uint64_t rays = 0;
  for (unsigned k = 0; k < args->N; ++k)
    if (args->valid[k] == -1) rays |= std::uint64_t{1} << RTCRayN_id(ray, args->N, k);
  context.tester->test(static_cast<std::int32_t>(args->primID), rays);
  for (unsigned k = 0; k < args->N; ++k) {
    const unsigned i = RTCRayN_id(ray, args->N, k);
    if (args->valid[k] != -1) continue;
    const float tfar = trace::RayPacket::float_above(context.tester->block.tmax[i] - context.t0[i]);
    if (tfar < RTCRayN_tfar(ray, args->N, k)) {
      RTCRayN_tfar(ray, args->N, k) = tfar;
      RTCHitN_geomID(hit, args->N, k) = 0;
      RTCHitN_primID(hit, args->N, k) = args->primID;
    }
  }
}

template <class RayHit, int N, class Cast>
void embree_packet(RTCScene scene, const trace::RayPacket& boxes, EmbreeContext& context, const Cast& cast) {
  for (int first = 0; first < kPacketSize; first += N) {
    alignas(64) int valid[N];
    RayHit rh;
    bool any = false;
    for (int k = 0; k < N; ++k) {
      const int i = first + k;
      valid[k] = (boxes.live >> i) & 1 ? -1 : 0;
      any |= valid[k] != 0;
      rh.ray.org_x[k] = boxes.org[0][i], rh.ray.org_y[k] = boxes.org[1][i], rh.ray.org_z[k] = boxes.org[2][i];
      rh.ray.dir_x[k] = boxes.dir[0][i], rh.ray.dir_y[k] = boxes.dir[1][i], rh.ray.dir_z[k] = boxes.dir[2][i];
      rh.ray.tnear[k] = 0.0f, rh.ray.tfar[k] = boxes.tmax[i], rh.ray.time[k] = 0.0f;
      rh.ray.mask[k] = ~0u, rh.ray.id[k] = static_cast<unsigned>(i), rh.ray.flags[k] = 0;
      rh.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID, rh.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    if (any) cast(valid, scene, &context.base, &rh);
  }
}

struct Bench {
  std::vector<trace::Ray> rays;
  Tester tester;
  trace::Bvh bvh;
  std::vector<std::int32_t> faces;

  // Median over the repeats of million rays per second; `packet` traces tester.block / boxes.
  double run(int repeat, double start_behind, const std::function<void(trace::RayPacket&)>& packet) {
    std::vector<double> times;
    auto boxes = std::make_unique<trace::RayPacket>();
    for (int r = 0; r < repeat; ++r) {
      faces.clear();
      tester.tests = 0;
      const double start = bench::cpu_seconds();
      for (std::size_t p = 0; p + kPacketSize <= rays.size(); p += kPacketSize) {
        for (int i = 0; i < kPacketSize; ++i) {
          const trace::Ray& ray = rays[p + i];
          tester.block.set(i, ray.org, ray.dir, ray.tmin, ray.tmax);
          tester.face[i] = kNoFace;
        }
        boxes->set(bvh, tester.block, ~std::uint64_t{0});
        // Embree wants tnear >= 0: its rays start outside of the model.
        if (start_behind > 0.0)
          for (int i = 0; i < kPacketSize; ++i) {
            for (int a = 0; a < 3; ++a)
              boxes->org[a][i] -= static_cast<float>(start_behind) * boxes->dir[a][i];
            boxes->t0[i] -= static_cast<float>(start_behind);
            boxes->set_tmax(i, tester.block.tmax[i]);
          }
        if (boxes->live != 0) packet(*boxes);
        faces.insert(faces.end(), tester.face, tester.face + kPacketSize);
      }
      times.push_back(bench::cpu_seconds() - start);
    }
    std::sort(times.begin(), times.end());
    return static_cast<double>(rays.size()) / times[times.size() / 2] * 1e-6;
  }
};

int run(const bench::Options& options) {
  const auto store = bench::load(options.file);
  const trace::Scene::Impl scene(store, 1);
  Bench bench;
  std::vector<Box3> boxes;
  for (const auto& prototype : scene.prototypes)
    for (std::size_t i = 0; i < prototype->primitives.size(); ++i) {
      const trace::ScenePrimitive& p = prototype->primitives[i];
      if (p.kind == trace::PrimitiveKind::kTriangles) continue;  // surfaces are compared
      bench.tester.leaves.push_back({prototype.get(), static_cast<std::int32_t>(i)});
      const bool closed = p.kind == trace::PrimitiveKind::kClosedForm;
      boxes.push_back(closed ? prototype->closed_leaves[p.leaf].box
                             : prototype->patches.leaves()[p.leaf].box);
    }
  double start = bench::cpu_seconds();
  bench.bvh = trace::build_bvh(boxes);
  const double own_build = bench::cpu_seconds() - start;
  bench.rays = bench::camera_rays(bench::world_bounds(*store), options.from, options.size);

  const double own = bench.run(options.repeat, 0.0, [&](trace::RayPacket& packet) {
    OwnContext context{bench.tester, packet};
    std::uint64_t nodes = 0;
    trace::traverse(bench.bvh, packet, own_visit, &context, &nodes);
  });
  const std::vector<std::int32_t> expected = bench.faces;
  const std::uint64_t own_tests = bench.tester.tests;
  const double own16 = bench.run(options.repeat, 0.0, [&](trace::RayPacket& packet) {
    OwnContext context{bench.tester, packet};
    std::uint64_t nodes = 0;
    for (int first = 0; first < kPacketSize; first += 16) {
      packet.set(bench.bvh, bench.tester.block, std::uint64_t{0xffff} << first);
      trace::traverse(bench.bvh, packet, own_visit, &context, &nodes);
    }
  });
  const std::uint64_t own16_tests = bench.tester.tests;

  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene embree = rtcNewScene(device);
  rtcSetSceneBuildQuality(embree, RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  struct Bounds {
    const std::vector<Box3>& boxes;
    const trace::Bvh& bvh;
  } bounds{boxes, bench.bvh};
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(boxes.size()));
  rtcSetGeometryUserData(geometry, &bounds);
  rtcSetGeometryBoundsFunction(
      geometry,
      [](const RTCBoundsFunctionArguments* args) {
        const auto& b = *static_cast<const Bounds*>(args->geometryUserPtr);
        const Box3& box = b.boxes[args->primID];
        const dvec3 lower = box.lower - b.bvh.center - 2.0 * b.bvh.dilation,
                    upper = box.upper - b.bvh.center + 2.0 * b.bvh.dilation;
        args->bounds_o->lower_x = static_cast<float>(lower.x),
        args->bounds_o->upper_x = static_cast<float>(upper.x);
        args->bounds_o->lower_y = static_cast<float>(lower.y),
        args->bounds_o->upper_y = static_cast<float>(upper.y);
        args->bounds_o->lower_z = static_cast<float>(lower.z),
        args->bounds_o->upper_z = static_cast<float>(upper.z);
      },
      nullptr);
  rtcSetGeometryIntersectFunction(geometry, embree_intersect);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(embree, geometry);
  start = bench::cpu_seconds();
  rtcCommitScene(embree);
  const double embree_build = bench::cpu_seconds() - start;

  std::printf("%zu leaves; build own %.4f s, Embree %.4f s\n", boxes.size(), own_build, embree_build);
  std::printf("own, 64 rays:    %.2f M rays/s, %.3f leaf tests a ray\n", own,
              static_cast<double>(own_tests) / static_cast<double>(bench.rays.size()));
  std::printf("own, 16 rays:    %.2f M rays/s, %.3f leaf tests a ray\n", own16,
              static_cast<double>(own16_tests) / static_cast<double>(bench.rays.size()));
  const auto compare = [&](const char* name,
                           const std::function<void(trace::RayPacket&, EmbreeContext&)>& packet) {
    const double rate =
        bench.run(options.repeat, 2.5 * bench.bvh.radius, [&](trace::RayPacket& boxes_of_rays) {
          EmbreeContext context;
          rtcInitIntersectContext(&context.base);
          context.base.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
          context.tester = &bench.tester, context.t0 = boxes_of_rays.t0;
          packet(boxes_of_rays, context);
        });
    std::size_t different = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) different += expected[i] != bench.faces[i];
    std::printf("%s %.2f M rays/s, %.3f leaf tests a ray, %zu hits differ\n", name, rate,
                static_cast<double>(bench.tester.tests) / static_cast<double>(bench.rays.size()), different);
  };
  compare("rtcIntersect8:  ", [&](trace::RayPacket& p, EmbreeContext& c) {
    embree_packet<RTCRayHit8, 8>(embree, p, c, rtcIntersect8);
  });
  compare("rtcIntersect16: ", [&](trace::RayPacket& p, EmbreeContext& c) {
    embree_packet<RTCRayHit16, 16>(embree, p, c, rtcIntersect16);
  });
  rtcReleaseGeometry(geometry), rtcReleaseScene(embree), rtcReleaseDevice(device);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return bench::main_with(argc, argv, run); }
