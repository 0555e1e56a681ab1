"""The fast tracer against the reference tracer, and both against OpenCascade, on any model.

Two tracers may differ where the ray stands on a knife's edge: a displacement of KNIFE_EDGE of the
diagonal, far below what the picture can show, turns one answer into the other. Such a difference is
explained; any other is a bug in one of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import trimray

from .closed_forms import HIT_TOL, views

Array = NDArray[np.float64]
Cast = Callable[[Array, Array], tuple[Array, NDArray[np.int32], NDArray[np.int32]]]

KNIFE_EDGE = 2e-9  # of the diagonal


@dataclass
class Result:
    rays: int = 0
    hits: int = 0
    knife_edge: int = 0
    coincident: int = 0
    unexplained: list[str] = field(default_factory=list)


def picture_rays(model: trimray.Model, n: int, seed: int = 1) -> tuple[Array, Array]:
    """n random rays from each of the 26 views over the model's bounds."""
    rng = np.random.default_rng(seed)
    low, high = model.bounds
    centre, diagonal = (low + high) / 2, float(np.linalg.norm(high - low))
    origins, directions = [], []
    for view in views():
        d = view / np.linalg.norm(view)
        target = low + rng.random((n, 3)) * (high - low)
        origins.append(target - d * (diagonal + (target - centre) @ d)[:, None])
        directions.append(np.broadcast_to(d, (n, 3)))
    return np.concatenate(origins), np.concatenate(directions)


def caster(model: trimray.Model, mode: str) -> Cast:
    def cast(o: Array, d: Array) -> tuple[Array, NDArray[np.int32], NDArray[np.int32]]:
        hits = model.cast(o, d, mode=mode)
        return hits.t, hits.face, hits.instance

    return cast


def _same(a, b, tol: float) -> NDArray[np.bool_]:  # type: ignore[no-untyped-def]
    with np.errstate(invalid="ignore"):
        close = (np.isinf(a[0]) & np.isinf(b[0])) | (np.abs(a[0] - b[0]) <= tol)
    return close & (a[1] == b[1]) & (a[2] == b[2])


def check(model: trimray.Model, n: int, fast: Cast | None = None, judge: Cast | None = None) -> Result:
    """Compares the fast tracer with the judge (default: the reference) on 26 n rays."""
    fast = fast or caster(model, "standard")
    judge = judge or caster(model, "reference")
    origins, directions = picture_rays(model, n)
    low, high = model.bounds
    diagonal = float(np.linalg.norm(high - low))
    tol = HIT_TOL * diagonal
    a, b = fast(origins, directions), judge(origins, directions)
    result = Result(rays=len(origins), hits=int((b[1] >= 0).sum()))
    rng = np.random.default_rng(7)
    for i in np.flatnonzero(~_same(a, b, tol)):
        if np.isfinite(a[0][i]) and abs(a[0][i] - b[0][i]) <= tol:
            result.coincident += 1  # two faces in one place: either is right
            continue
        shift = rng.normal(size=(48, 3))
        shift *= KNIFE_EDGE * diagonal / np.linalg.norm(shift, axis=1)[:, None]
        around = judge(origins[i] + shift, np.broadcast_to(directions[i], (48, 3)).copy())
        # Grazing hits move by the square root of the displacement, so only face and instance count.
        if ((around[1] == a[1][i]) & (around[2] == a[2][i])).any():
            result.knife_edge += 1
            continue
        result.unexplained.append(
            f"ray {origins[i].tolist()} {directions[i].tolist()}: "
            f"fast t={a[0][i]!r} face={a[1][i]} instance={a[2][i]}, "
            f"judge t={b[0][i]!r} face={b[1][i]} instance={b[2][i]}"
        )
    return result
