"""Parity: a ray aimed at an edge or a vertex of a closed solid must cross it an even number of times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import trimray
from trimray import _core

OFFSETS = (0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)  # of the diagonal


@dataclass
class Result:
    rays: int = 0
    odd: int = 0
    solids: int = 0


def check(model: trimray.Model, rays_per_target: int, seed: int = 1) -> Result:
    """Rays from outside at points of every edge and vertex, displaced by each of OFFSETS.

    Counts only models all of whose shells are closed: a ray's count is over the whole model.
    """
    closed_shells, open_shells = model._core.prototype_shells().sum(axis=0).tolist()
    if open_shells or not closed_shells:
        return Result()
    targets = _core.edge_points(model._core, 2)
    rng = np.random.default_rng(seed)
    low, high = model.bounds
    diagonal = float(np.linalg.norm(high - low))
    result = Result(solids=closed_shells)
    for offset in OFFSETS:
        points = np.repeat(targets, rays_per_target, axis=0)
        d = rng.normal(size=points.shape)
        d /= np.linalg.norm(d, axis=1)[:, None]
        shift = rng.normal(size=points.shape)
        shift *= offset * diagonal / np.linalg.norm(shift, axis=1)[:, None]
        origins = points + shift - 3 * diagonal * d
        counts = model.count_hits(origins, d)
        result.rays += len(points)
        result.odd += int((counts % 2 != 0).sum())
    return result
