"""The fast tracer against the reference tracer, and both against OpenCascade, on any model.

Two tracers may differ where the ray stands on a knife's edge: a displacement of KNIFE_EDGE of the
diagonal, far below what the picture can show, turns one answer into the other. Such a difference is
explained. So is one where the ray passes an edge within its band and the answers lie no farther apart
than a grazing ray can carry that band: there the file itself does not say more. These are counted apart,
and few. Any other is a bug in one of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import trimray
from trimray import _core

from .closed_forms import HIT_TOL, views

Array = NDArray[np.float64]
# t, face, instance, |cos| of the angle between normal and ray
Cast = Callable[[Array, Array], tuple[Array, NDArray[np.int32], NDArray[np.int32], Array]]

KNIFE_EDGE = 2e-9  # of the diagonal
BAND_REACH = 1e-3  # of the diagonal
EDGE_ON = 1e-9  # |cos| below which a ray lies in the face


@dataclass
class Result:
    rays: int = 0
    hits: int = 0
    knife_edge: int = 0
    edge_on: int = 0
    band: int = 0
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


def aimed_rays(model: trimray.Model, n: int, seed: int = 2) -> tuple[Array, Array]:
    """n random rays that pass edges and vertices at 1e-7 to 1e-2 of the diagonal."""
    rng = np.random.default_rng(seed)
    low, high = model.bounds
    diagonal = float(np.linalg.norm(high - low))
    targets = _core.edge_points(model._core, 3)
    if len(targets) == 0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    targets = targets[rng.integers(len(targets), size=n)]
    d = rng.normal(size=(n, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    shift = rng.normal(size=(n, 3))
    shift *= (10 ** rng.uniform(-7, -2, n) * diagonal / np.linalg.norm(shift, axis=1))[:, None]
    return targets + shift - 2 * diagonal * d, d


def caster(model: trimray.Model, mode: str) -> Cast:
    def cast(o: Array, d: Array) -> tuple[Array, NDArray[np.int32], NDArray[np.int32], Array]:
        hits = model.cast(o, d, mode=mode)
        return hits.t, hits.face, hits.instance, np.abs((hits.normal * d).sum(axis=1))

    return cast


def _same(a, b, tol: float) -> NDArray[np.bool_]:  # type: ignore[no-untyped-def]
    with np.errstate(invalid="ignore"):
        close = (np.isinf(a[0]) & np.isinf(b[0])) | (np.abs(a[0] - b[0]) <= tol)
    return close & (a[1] == b[1]) & (a[2] == b[2])


def check(model: trimray.Model, n: int, fast: Cast | None = None, judge: Cast | None = None) -> Result:
    """Compares the fast tracer with the judge (default: the reference) on 26 n rays over the model, and
    as many aimed at its edges."""
    fast = fast or caster(model, "standard")
    judge = judge or caster(model, "reference")
    seen, aimed = picture_rays(model, n), aimed_rays(model, 26 * n)
    origins, directions = (np.concatenate(pair) for pair in zip(seen, aimed, strict=True))
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
        if any(side[1][i] >= 0 and side[3][i] < EDGE_ON for side in (a, b)):
            result.edge_on += 1  # the ray lies in a plane: where it meets it is nobody's to say
            continue
        shift = rng.normal(size=(48, 3))
        shift *= KNIFE_EDGE * diagonal / np.linalg.norm(shift, axis=1)[:, None]
        around = judge(origins[i] + shift, np.broadcast_to(directions[i], (48, 3)).copy())
        # Grazing hits move by the square root of the displacement, so only face and instance count.
        if ((around[1] == a[1][i]) & (around[2] == a[2][i])).any():
            result.knife_edge += 1
            continue
        reach = min(a[0][i], b[0][i]) + BAND_REACH * diagonal
        if _core.near_edge(model._scene, origins[i].tolist(), directions[i].tolist(), reach):
            result.band += 1
            continue
        result.unexplained.append(
            f"ray {origins[i].tolist()} {directions[i].tolist()}: "
            f"fast t={a[0][i]!r} face={a[1][i]} instance={a[2][i]}, "
            f"judge t={b[0][i]!r} face={b[1][i]} instance={b[2][i]}"
        )
    return result
