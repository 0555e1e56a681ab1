// The exact way: every hit of one ray, with the edge rule where the ray comes near an edge.
#include <algorithm>
#include <cmath>

#include "core/trace/scene_impl.h"

namespace trimray::trace {

Root PrototypeScene::make_root(std::int32_t face, double t, dvec2 uv, dvec3 normal, dvec3 dir) const {
  Root root;
  root.t = t;
  root.uv_face = trim.wrap(face, uv);
  root.normal = normal;
  root.face = face;
  root.sign = glm::dot(normal, dir) > 0.0 ? 1 : -1;
  root.inside = inside(face, root.uv_face);
  return root;
}

Root PrototypeScene::closed_root(std::int32_t face, const ClosedRoot& root, dvec3 dir) const {
  return make_root(face, root.t, root.uv, store.faces[face].reversed ? -root.normal : root.normal, dir);
}

void PrototypeScene::leaf_roots(std::int32_t leaf, const Ray& ray, std::vector<Root>& out) const {
  RayLanes lanes;
  for (int k = 0; k < kLanes; ++k) {
    lanes.org_x[k] = ray.org.x, lanes.org_y[k] = ray.org.y, lanes.org_z[k] = ray.org.z;
    lanes.dir_x[k] = ray.dir.x, lanes.dir_y[k] = ray.dir.y, lanes.dir_z[k] = ray.dir.z;
  }
  lanes.active = 1;
  RootLanes roots;
  patches.solve(leaf, lanes, roots);
  if (roots.none & 1u) return;
  const std::int32_t face = patches.leaves()[leaf].face;
  if (roots.one & 1u) {
    const dvec3 n{roots.normal_x[0], roots.normal_y[0], roots.normal_z[0]};
    out.push_back(
        make_root(face, roots.t[0], {roots.u[0], roots.v[0]}, store.faces[face].reversed ? -n : n, ray.dir));
    return;
  }
  const std::size_t begin = out.size();
  patches.all_roots(leaf, ray, out);
  for (std::size_t i = begin; i < out.size(); ++i)
    out[i] = make_root(face, out[i].t, out[i].uv_face, out[i].normal, ray.dir);
}

dvec3 PrototypeScene::mesh_normal(std::int32_t triangle) const {
  const nurbs::Triangle& t = store.mesh_triangles[triangle];
  return triangle_normal(store.mesh_vertices[t[0]], store.mesh_vertices[t[1]], store.mesh_vertices[t[2]]);
}

void PrototypeScene::mesh_roots(std::span<const std::int32_t> blocks, const Ray& ray,
                                std::vector<Root>& out) const {
  const RayShear shear(ray.org, ray.dir);
  std::vector<std::pair<std::int32_t, Root>> found;
  for (const std::int32_t primitive : blocks) {
    const TriangleBlock& block = triangles.blocks[primitives[primitive].leaf];
    TriangleCrossing crossings[kTrianglesPerBlock];
    const int count = cross_triangles(block, {&shear, 1}, 1, crossings);
    for (int i = 0; i < count; ++i) {
      const std::int32_t triangle = block.triangle[crossings[i].lane];
      Root root;
      root.t = crossings[i].t, root.uv_face = crossings[i].weights;
      root.face = primitives[primitive].face, root.normal = mesh_normal(triangle);
      root.sign = glm::dot(root.normal, ray.dir) > 0.0 ? 1 : -1;
      root.inside = true;
      found.push_back({triangle, root});
    }
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [triangle, root] : found) out.push_back(root);
}

void merge_roots(std::vector<Root>& roots, std::size_t begin, double diagonal) {
  const auto first = roots.begin() + static_cast<std::ptrdiff_t>(begin);
  std::stable_sort(first, roots.end(), [](const Root& a, const Root& b) { return a.t < b.t; });
  roots.erase(std::unique(first, roots.end(),
                          [&](const Root& a, const Root& b) { return same_root(a, b, diagonal); }),
              roots.end());
}

void PrototypeScene::face_roots(std::int32_t face, const Ray& ray, std::vector<Root>& out) const {
  const ClosedForm& f = form(face);
  const std::size_t begin = out.size();
  if (f.kind != nurbs::SurfaceKind::kNone) {
    ClosedRoot roots[kMaxClosedRoots];
    const int count = closed_form_roots(f, ray.org, ray.dir, f.uv, -kInf, kInf, roots);
    for (int i = 0; i < count; ++i) out.push_back(closed_root(face, roots[i], ray.dir));
    return;
  }
  // A slab test in double against the leaf's own box, before the solver.
  const std::int32_t local = face - first_face;
  for (std::int32_t k = leaf_begin[local]; k < leaf_begin[local + 1]; ++k) {
    const std::int32_t leaf = leaf_order[k];
    const Box3& b = patches.leaves()[leaf].box;
    const double slop = 1e-12 * (glm::length(ray.org - b.lower) + diagonal);
    double enter = -kInf, leave = kInf;
    for (int a = 0; a < 3; ++a) {
      const double lower = b.lower[a] - ray.org[a] - slop, upper = b.upper[a] - ray.org[a] + slop;
      if (ray.dir[a] == 0.0) {
        if (lower > 0.0 || upper < 0.0) leave = -kInf, enter = kInf;
        continue;
      }
      const double p = lower / ray.dir[a], q = upper / ray.dir[a];
      enter = std::max(enter, std::min(p, q)), leave = std::min(leave, std::max(p, q));
    }
    if (enter <= leave) leaf_roots(leaf, ray, out);
  }
  merge_roots(out, begin, diagonal);
}

Ray InstanceScene::local(const Ray& world, double& scale) const {
  Ray ray = world;
  if (!identity) ray.org = to_prototype * (world.org - translation), ray.dir = to_prototype * world.dir;
  const double length2 = glm::dot(ray.dir, ray.dir);
  scale = 1.0;
  if (!is_unit(length2)) {
    scale = std::sqrt(length2);
    ray.dir /= scale;
    ray.tmin = world.tmin * scale, ray.tmax = world.tmax * scale;
    // The product may round past the caller's limit; the limit itself is checked in the world again.
    ray.tmin -= 1e-15 * std::abs(ray.tmin);
    ray.tmax += 1e-15 * std::abs(ray.tmax);
    if (std::isnan(ray.tmin)) ray.tmin = -kInf;
    if (std::isnan(ray.tmax)) ray.tmax = kInf;
  }
  return ray;
}

namespace {

// Near edges that matter up to limit; the others stand behind what the ray meets first.
bool any_within(const nurbs::NurbsStore& store, const std::vector<NearEdge>& near, double tmin,
                double limit) {
  return std::any_of(near.begin(), near.end(), [&](const NearEdge& n) {
    const double slack = EdgeSieve::slack(store.edges[n.edge]);
    return n.t >= tmin - slack && n.t <= limit + slack;
  });
}

// The faces of the near edges, each once.
void affected_faces(const nurbs::NurbsStore& store, const std::vector<NearEdge>& near,
                    std::vector<std::int32_t>& faces) {
  faces.clear();
  for (const NearEdge& n : near) {
    const nurbs::Range& uses = store.edges[n.edge].coedges;
    for (std::int32_t c = uses.begin; c < uses.end; ++c)
      faces.push_back(store.coedges[store.edge_coedges[c]].face);
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  std::erase_if(faces,
                [&](std::int32_t f) { return f < 0 || store.faces[f].status != nurbs::FaceStatus::kOk; });
}

}  // namespace

bool Scene::Impl::near_edge(const Ray& ray, double best_t) const {
  bool found = false;
  double slack = 0.0;
  for (const auto& p : prototypes) slack = std::max(slack, p->sieves[0].max_slack());
  std::vector<NearEdge> near;
  // Every instance on the line is asked: the instance's own frame scales its slack.
  traverse_one(bvh, ray.org, ray.dir, -kInf, kInf, [&](std::int32_t index) {
    if (found) return;
    const InstanceScene& instance = instances[index];
    const PrototypeScene& prototype = *prototypes[instance.prototype];
    double scale;
    Ray world = ray;
    world.tmax = best_t;
    const Ray local = instance.local(world, scale);
    Ray wide = local;
    wide.tmin -= prototype.sieves[0].max_slack(), wide.tmax += prototype.sieves[0].max_slack();
    near.clear();
    prototype.rule.near_edges(wide, near);
    found = any_within(*store, near, local.tmin, local.tmax);
  });
  return found;
}

void Scene::Impl::all_hits(const Ray& ray, std::vector<Hit>& out) const {
  std::vector<NearEdge> near;
  std::vector<std::int32_t> affected, faces, primitives;
  std::vector<Root> roots, kept;
  traverse_one(bvh, ray.org, ray.dir, -kInf, kInf, [&](std::int32_t index) {
    const InstanceScene& instance = instances[index];
    const PrototypeScene& p = *prototypes[instance.prototype];
    double scale;
    Ray local = instance.local(ray, scale);
    local.tmin = -kInf, local.tmax = kInf;
    near.clear();
    p.rule.near_edges(local, near);
    affected_faces(*store, near, affected);
    kept.clear();
    for (const std::int32_t face : affected) {
      roots.clear();
      p.face_roots(face, local, roots);
      p.rule.resolve(local, face, near, roots);
      kept.insert(kept.end(), roots.begin(), roots.end());
    }
    // The other faces: the trim loops decide. Closed forms are solved once a face, patches leaf by leaf.
    primitives.clear();
    traverse_one(p.bvh, local.org, local.dir, -kInf, kInf, [&](std::int32_t primitive) {
      if (!std::binary_search(affected.begin(), affected.end(), p.primitives[primitive].face))
        primitives.push_back(primitive);
    });
    std::sort(primitives.begin(), primitives.end(), [&](std::int32_t a, std::int32_t b) {
      return std::pair(p.primitives[a].face, a) < std::pair(p.primitives[b].face, b);
    });
    for (std::size_t i = 0; i < primitives.size();) {
      const std::int32_t face = p.primitives[primitives[i]].face;
      if (store->faces[face].is_mesh()) {  // every crossing counts: none is found twice
        const std::size_t first = i;
        while (i < primitives.size() && p.primitives[primitives[i]].face == face) ++i;
        p.mesh_roots(std::span(primitives).subspan(first, i - first), local, kept);
        continue;
      }
      roots.clear();
      for (bool first = true; i < primitives.size() && p.primitives[primitives[i]].face == face;
           ++i, first = false) {
        const ScenePrimitive& primitive = p.primitives[primitives[i]];
        if (primitive.kind == PrimitiveKind::kPatch)
          p.leaf_roots(primitive.leaf, local, roots);
        else if (first)
          p.face_roots(face, local, roots);
      }
      merge_roots(roots, 0, p.diagonal);
      for (const Root& root : roots)
        if (root.inside) kept.push_back(root);
    }
    for (const Root& root : kept) {
      const double t = root.t / scale;
      if (!(t >= ray.tmin && t <= ray.tmax)) continue;
      out.push_back({t, root.face, index, root.uv_face, instance.normal(root.normal)});
    }
  });
  // Stable: equal ones of a mesh face stay in the order of the triangles, as comes_before() has it.
  std::stable_sort(out.begin(), out.end(), [](const Hit& a, const Hit& b) {
    return std::tuple(a.t, a.instance, a.face, a.uv_face.x, a.uv_face.y) <
           std::tuple(b.t, b.instance, b.face, b.uv_face.x, b.uv_face.y);
  });
}

}  // namespace trimray::trace
