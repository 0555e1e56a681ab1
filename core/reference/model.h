// A store made ready for the reference tracer, and the hits of one ray on it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/reference/face.h"
#include "core/reference/paths.h"

namespace trimray::reference {

class Model {
 public:
  // only: prepare no more than what this ray can meet; nullptr: everything.
  Model(const nurbs::NurbsStore& store, const trace::Ray* only, int threads);

  // Every hit in [tmin, tmax], sorted by t, then instance, then face. t in multiples of dir's length.
  std::vector<trace::Hit> hits(const trace::Ray& ray) const;

 private:
  void instance_hits(const trace::Ray& ray, std::int32_t instance, std::vector<trace::Hit>& out) const;
  std::vector<std::int32_t> edges_of(std::int32_t face) const;
  int winding(std::int32_t face, const Line& line) const;
  void resolve(std::int32_t face, const Line& line, std::span<const NearStretch> near,
               std::vector<trace::Root>& roots) const;
  void decide_by_side(std::int32_t face, const Line& line, std::span<const NearStretch> near,
                      std::vector<trace::Root>& roots) const;
  trace::Root on_path(std::int32_t face, const Line& line, const NearStretch& spot, int sign) const;

  const nurbs::NurbsStore& store_;
  std::vector<std::optional<FaceModel>> faces_;
  std::vector<EdgePath> paths_;
};

}  // namespace trimray::reference
