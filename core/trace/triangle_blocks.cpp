#include "core/trace/triangle_blocks.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/trace/neighbours.h"

namespace trimray::trace {
namespace {

// With three times their middles.
std::vector<Neighbour> items_of(const nurbs::NurbsStore& store, const nurbs::Range& triangles) {
  std::vector<Neighbour> items;
  items.reserve(static_cast<std::size_t>(triangles.size()));
  for (std::int32_t i = triangles.begin; i < triangles.end; ++i) {
    const nurbs::Triangle& t = store.mesh_triangles[i];
    const dvec3 &a = store.mesh_vertices[t[0]], &b = store.mesh_vertices[t[1]],
                &c = store.mesh_vertices[t[2]];
    if (a != b && b != c && c != a) items.push_back({glm::vec3(a + b + c), i});
  }
  return items;
}

void fill(const nurbs::NurbsStore& store, std::span<const Neighbour> items, TriangleBlock& block, Box3& box) {
  block = {};
  for (const Neighbour& item : items) {
    for (int c = 0; c < 3; ++c) {
      const dvec3& p = store.mesh_vertices[store.mesh_triangles[item.index][c]];
      for (int axis = 0; axis < 3; ++axis) block.corner[c][axis][block.count] = p[axis];
      box.add(p);
    }
    block.triangle[block.count++] = item.index;
  }
}

}  // namespace

TriangleBlocks triangle_blocks(const nurbs::NurbsStore& store, std::int32_t prototype, int threads) {
  TriangleBlocks out;
  const nurbs::Range& faces = store.prototypes[prototype].faces;
  for (std::int32_t f = faces.begin; f < faces.end; ++f) {
    if (!store.faces[f].is_mesh() || store.faces[f].status != nurbs::FaceStatus::kOk) continue;
    std::vector<Neighbour> items = items_of(store, store.faces[f].triangles);
    arrange_neighbours(items, kTrianglesPerBlock, threads);
    const std::size_t first = out.blocks.size(),
                      count = (items.size() + kTrianglesPerBlock - 1) / kTrianglesPerBlock;
    out.blocks.resize(first + count), out.boxes.resize(first + count);
    out.faces.resize(first + count, f);
    parallel_ranges(count, 1024, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto all = std::span<const Neighbour>(items).subspan(i * kTrianglesPerBlock);
        fill(store, all.first(std::min<std::size_t>(all.size(), kTrianglesPerBlock)), out.blocks[first + i],
             out.boxes[first + i]);
      }
    });
  }
  return out;
}

}  // namespace trimray::trace
