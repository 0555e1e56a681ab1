"""How far p-curves, put on their surfaces, are from the edges they are images of.

The faces of both models end at their edges' curves in space, so a bad p-curve moves no point of them; yet
programs that trim by p-curves will see gaps there. Only what is worse in B counts: readers improve p-curves
as they please, and nothing is lost by that. What is within the tolerance that A declares for its edge is as
good as it was.
"""

from __future__ import annotations

import numpy as np

from .findings import found, limited
from .match import Matching, nearest_pairs
from .parts import edge_sums
from .record import Finding
from .side import Float64s, Int64s, Side, placed
from .tolerances import Tolerances

# Edge::band is so many times what was measured (core/nurbs/build_store.cpp).
_SAFETY = 1.5
# Measured at points, so twice as much may be the same.
_NOISE = 2.0


def compare_pcurves(matching: Matching, tolerances: Tolerances) -> list[Finding]:
    """Edge by edge, of all pairs of prototypes."""
    a, b = matching.a, matching.b
    tolerance = tolerances.distance * matching.scale
    largest = [float(_off(side)[_used(side)].max(initial=0.0)) for side in (a, b)]
    wrong: list[Finding] = []
    seen: set[tuple[int, int]] = set()
    for part_a, part_b in matching.pairs:
        key = int(a.prototypes[part_a.number]), int(b.prototypes[part_b.number])
        if key in seen:
            continue
        seen.add(key)
        edges = [_edges(side, prototype) for side, prototype in zip((a, b), key, strict=True)]
        places = [
            placed(centers, part.placement)
            for (_, centers), part in zip(edges, (part_a, part_b), strict=True)
        ]
        pairs = nearest_pairs(places[0], places[1], 0.01 * matching.scale)
        numbers = edges[0][0][pairs[:, 0]], edges[1][0][pairs[:, 1]]
        off = _off(a)[numbers[0]], _off(b)[numbers[1]]
        allowed = np.maximum(_NOISE * off[0], a.arrays["edges"]["tolerance"][numbers[0]])
        for i in np.flatnonzero((off[1] - off[0] > tolerance) & (off[1] > allowed)).tolist():
            edge = int(numbers[0][i])
            owner = int(a.arrays["coedges"]["face"][a.arrays["coedges"]["edge"] == edge][0])
            wrong.append(
                found(
                    "geometry", "p-curve off its edge", [float(off[0][i]), float(off[1][i])], False, "mm",
                    float(off[1][i] - off[0][i]), tolerance, where=f"edge {edge} of {a.where(owner)}",
                )
            )  # fmt: skip
    wrong.sort(key=lambda finding: -(finding.difference or 0.0))
    summary = found(
        "geometry", "largest distance of p-curves from edges", largest, not wrong, "mm",
        largest[1] - largest[0], tolerance, reason="edge by edge",
    )  # fmt: skip
    return [summary, *limited(wrong)]


def _off(side: Side) -> Float64s:
    """(e,) mm, as measured."""
    return np.asarray(side.arrays["edges"]["band"] / _SAFETY, np.float64)


def _used(side: Side) -> Int64s:
    """Edges with a curve and a face."""
    edges = side.arrays["edges"]
    full = ~edges["degenerate"].astype(bool) & (np.diff(edges["coedges"], axis=1).ravel() > 0)
    return np.flatnonzero(full)


def _edges(side: Side, prototype: int) -> tuple[Int64s, Float64s]:
    """Numbers of a prototype's edges, and their middles."""
    begin, end = side.arrays["prototypes"]["edges"][prototype].tolist()
    used = _used(side)
    numbers = used[(used >= begin) & (used < end)]
    total, count = edge_sums(side)
    return numbers, total[numbers] / np.maximum(count[numbers], 1)[:, None]
