#include "core/reference/reference.h"

#include "core/base/parallel.h"
#include "core/reference/model.h"

namespace trimray::reference {

void cast(const nurbs::NurbsStore& store, std::span<const trace::Ray> rays, std::span<trace::Hit> out,
          int threads) {
  const Model model(store, nullptr, threads);
  parallel_ranges(rays.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::vector<trace::Hit> hits = model.hits(rays[k]);
      out[k] = hits.empty() ? trace::Hit{} : hits.front();
    }
  });
}

void cast_all(const nurbs::NurbsStore& store, const trace::Ray& ray, std::vector<trace::Hit>& out) {
  out = Model(store, &ray, 1).hits(ray);
}

}  // namespace trimray::reference
