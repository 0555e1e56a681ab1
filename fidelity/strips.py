"""What p-curves made anew may change of a model's area and volume.

A face is integrated up to its p-curves, which stray from its edges by what the store has measured. Programs
may make them anew, and the strips between the old ones and the new ones are then no difference.
"""

from __future__ import annotations

import numpy as np

from .match import nearest_pairs
from .parts import edge_sums
from .side import Float64s, Side

# Edge::band is so many times what was measured (core/nurbs/build_store.cpp).
_SAFETY = 1.5
# p-curves that stray by the same, but for this share, are the same ones: files round them.
_SAME = 1e-4
# Middles of edges farther apart, as a share of the diagonal, are not those of one edge.
_NEAR = 0.01


def changed_strips(a: Side, b: Side) -> tuple[float, int]:
    """At most the area, mm², between the p-curves of A and B, of all edges whose p-curves have changed; and
    the number of these edges."""
    middles, strays, lengths = zip(*(_edges(side) for side in (a, b)), strict=True)
    pairs = nearest_pairs(middles[0], middles[1], _NEAR * max(a.diagonal, b.diagonal))
    stray = strays[0][pairs[:, 0]], strays[1][pairs[:, 1]]
    changed = np.abs(stray[0] - stray[1]) > _SAME * np.maximum(*stray)
    length = np.maximum(lengths[0][pairs[:, 0]], lengths[1][pairs[:, 1]])
    total = float((length * (stray[0] + stray[1]))[changed].sum())
    count = int(changed.sum())
    for side in (0, 1):
        alone = np.setdiff1d(np.arange(len(strays[side])), pairs[:, side])
        total += float((strays[side] * lengths[side])[alone].sum())
        count += len(alone)
    return total, count


def _edges(side: Side) -> tuple[Float64s, Float64s, Float64s]:
    """Of every edge of every instance that has a curve and a face, in the world: middle (n, 3), how far its
    p-curves stray (n,), its length as often as faces use it (n,), rather too long, mm."""
    arrays = side.arrays
    edges, spans = arrays["edges"], arrays["prototypes"]["edges"]
    uses = np.diff(edges["coedges"], axis=1).ravel()
    used = ~edges["degenerate"].astype(bool) & (uses > 0)
    total, count = edge_sums(side)
    middle = total / np.maximum(count, 1)[:, None]
    length = _lengths(side) * uses
    parts: list[tuple[Float64s, Float64s, Float64s]] = [(np.empty((0, 3)), np.empty(0), np.empty(0))]
    for prototype, placement in zip(side.prototypes.tolist(), side.placements, strict=True):
        numbers = np.arange(*spans[prototype])
        numbers = numbers[used[numbers]]
        stretch = float(np.linalg.norm(placement[:, :3], 2))
        place = middle[numbers] @ placement[:, :3].T + placement[:, 3]
        parts.append((place, stretch * edges["band"][numbers] / _SAFETY, stretch * length[numbers]))
    middles, strays, lengths = (np.concatenate(column) for column in zip(*parts, strict=True))
    return middles, strays, lengths


def _lengths(side: Side) -> Float64s:
    """(e,) mm, of the control polygons of the edges."""
    arrays = side.arrays
    points = arrays["edge_ctrl_h"][:, :3] / arrays["edge_ctrl_h"][:, 3:]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    sums = np.concatenate([np.zeros(1), np.cumsum(steps), np.zeros(1)])
    pieces = arrays["edge_pieces"]["ctrl"]
    by_piece = np.concatenate([np.zeros(1), np.cumsum(sums[pieces[:, 1] - 1] - sums[pieces[:, 0]])])
    spans = arrays["edges"]["pieces"]
    return np.asarray(by_piece[spans[:, 1]] - by_piece[spans[:, 0]], np.float64)
