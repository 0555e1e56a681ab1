// What the tracer's benchmarks share: a scene from a file, a camera's rays, processor time.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/brep/bintools.h"
#include "core/nurbs/build_store.h"
#include "core/trace/ray.h"
#include "core/trace/scene.h"

namespace bench {

using namespace trimray;

// Processor time of all threads: a busy machine does not blur it.
inline double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

inline std::vector<std::byte> read_bytes(const char* path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> chars((std::istreambuf_iterator<char>(file)), {});
  std::vector<std::byte> bytes(chars.size());
  if (!chars.empty()) std::memcpy(bytes.data(), chars.data(), chars.size());
  return bytes;
}

inline nurbs::NurbsStore from_stream(const std::vector<std::byte>& bytes) {
  const brep::Model model = brep::parse_bintools(bytes);
  std::vector<bool> used(model.shapes.size());
  for (const brep::Shape& shape : model.shapes)
    for (const brep::ShapeUse& child : shape.children) used[child.shape] = true;
  nurbs::BuildInput input;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) continue;
    input.instance_prototypes.push_back(static_cast<std::int32_t>(input.prototype_shapes.size()));
    input.prototype_shapes.push_back(static_cast<std::int32_t>(i + 1));
    for (const double x : {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}) input.instance_placements.push_back(x);
    for (int k = 0; k < 4; ++k)
      input.prototype_colors.push_back(-1.0f), input.instance_colors.push_back(-1.0f);
  }
  return nurbs::build_store(bytes, input);
}

inline Box3 world_bounds(const nurbs::NurbsStore& store) {
  Box3 bounds;
  for (const nurbs::Instance& instance : store.instances) {
    const Box3& b = store.prototypes[instance.prototype].bounds;
    for (int k = 0; k < 8; ++k)
      bounds.add(instance.placement.point(
          {(k & 1 ? b.lower : b.upper).x, (k & 2 ? b.lower : b.upper).y, (k & 4 ? b.lower : b.upper).z}));
  }
  return bounds;
}

inline std::vector<trace::Ray> camera_rays(const Box3& bounds, dvec3 from, int size) {
  const dvec3 dir = -glm::normalize(from);
  const dvec3 right =
      glm::normalize(glm::cross(dir, std::abs(dir.z) > 0.99 ? dvec3(0, 1, 0) : dvec3(0, 0, 1)));
  const dvec3 up = glm::cross(right, dir);
  dvec2 half(0.0);
  for (int k = 0; k < 8; ++k) {
    const dvec3 corner =
        dvec3((k & 1 ? bounds.lower : bounds.upper).x, (k & 2 ? bounds.lower : bounds.upper).y,
              (k & 4 ? bounds.lower : bounds.upper).z) -
        bounds.center();
    half = glm::max(half, glm::abs(dvec2(glm::dot(corner, right), glm::dot(corner, up))));
  }
  const double pixel = 2.0 * std::max(half.x, half.y) * 1.05 / size;
  std::vector<trace::Ray> rays;
  for (int tile = 0; tile < size / 8 * (size / 8); ++tile)
    for (int k = 0; k < 64; ++k) {
      // In Z order: four rays in a row are 2 x 2 pixels.
      const int column = (k & 1) | (k >> 1 & 2) | (k >> 2 & 4),
                row = (k >> 1 & 1) | (k >> 2 & 2) | (k >> 3 & 4);
      const double x = (tile % (size / 8) * 8 + column + 0.5 - size / 2.0) * pixel,
                   y = (tile / (size / 8) * 8 + row + 0.5 - size / 2.0) * pixel;
      rays.push_back({bounds.center() + x * right - y * up - bounds.diagonal() * dir, dir, 0.0, kInf});
    }
  return rays;
}

// A saved store, or a BinTools stream.
inline std::shared_ptr<const nurbs::NurbsStore> load(const char* path) {
  const std::vector<std::byte> bytes = read_bytes(path);
  try {
    return std::make_shared<nurbs::NurbsStore>(nurbs::load_store(bytes));
  } catch (const FormatError&) {
    return std::make_shared<nurbs::NurbsStore>(from_stream(bytes));
  }
}

struct Options {
  const char* file = nullptr;
  int size = 1024, repeat = 5, threads = 1;
  dvec3 from{1, -1, 1};  // the side the camera stands on
  trace::SceneOptions scene;
};

inline int main_with(int argc, char** argv, int (*run)(const Options&)) {
  if (argc < 2) {
    std::fprintf(stderr,
                 "usage: %s FILE [--size N] [--repeat N] [--threads N] [--view x,y,z] [--boxes tuned|paper] "
                 "[--packet N]\n",
                 argv[0]);
    return 2;
  }
  Options options;
  options.file = argv[1];
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    if (option == "--size") options.size = std::stoi(argv[i + 1]);
    if (option == "--repeat") options.repeat = std::stoi(argv[i + 1]);
    if (option == "--threads") options.threads = std::stoi(argv[i + 1]);
    if (option == "--packet") options.scene.packet = std::stoi(argv[i + 1]);
    if (option == "--boxes" && std::string(argv[i + 1]) == "paper")
      options.scene.boxes = trace::LeafBoxes::kPaper;
    if (option == "--view")
      std::sscanf(argv[i + 1], "%lf,%lf,%lf", &options.from.x, &options.from.y, &options.from.z);
  }
  return run(options);
}

}  // namespace bench
