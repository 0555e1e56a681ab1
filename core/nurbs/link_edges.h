// The way back from an edge to its co-edges.
#pragma once

#include "core/nurbs/store.h"

namespace trimray::nurbs {

// Fills edge_coedges and Edge::coedges, once all co-edges are there.
void link_edges(NurbsStore& store);

}  // namespace trimray::nurbs
