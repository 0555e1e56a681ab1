#include "core/nurbs/link_edges.h"

namespace trimray::nurbs {

void link_edges(NurbsStore& store) {
  std::vector<std::int32_t> uses(store.edges.size() + 1, 0);
  for (const CoEdge& c : store.coedges) ++uses[c.edge + 1];
  for (std::size_t i = 1; i < uses.size(); ++i) uses[i] += uses[i - 1];
  for (std::size_t i = 0; i < store.edges.size(); ++i) store.edges[i].coedges = {uses[i], uses[i + 1]};
  store.edge_coedges.resize(store.coedges.size());
  for (std::size_t c = 0; c < store.coedges.size(); ++c)
    store.edge_coedges[uses[store.coedges[c].edge]++] = static_cast<std::int32_t>(c);
}

}  // namespace trimray::nurbs
