"""Distances: how far points are from a model, one row a point; and points spread over a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _core
from .importer.errors import UsageError

Float64s = npt.NDArray[np.float64]
Int32s = npt.NDArray[np.int32]

# Points given to the core at once; between two such portions Ctrl-C is heard.
_PORTION = 1 << 12


@dataclass(frozen=True)
class Distances:
    """The nearest points of a model to n points.

    A face ends at its edges: what counts are the points of its surface inside of its trims and those of its
    edges' shared curves in space.

    distance: (n,) float64, mm; inf where the model has nothing to be near to.
    point: (n, 3) float64, mm, world.
    face: (n,) int32, number of the face; on an edge the first of its faces. instance: (n,) int32.
    edge: (n,) int32, number of the edge that the point lies on, -1 inside of a face.
    uv: (n, 2) float64, the surface parameters of the file (angles for circular directions).
    band: (n,) float64, mm: how far from the edge's curve its faces may take their own ends to be (the
        tolerance of the file, and what was measured); 0 inside of a face.
    gap: (n,) float64, mm: nothing is nearer than distance - gap. 0 but for points that are as good as equally
        far from a whole region of a surface, and 1e-12 of the model's diagonal stands for 0.
    """

    distance: Float64s
    point: Float64s
    face: Int32s
    instance: Int32s
    edge: Int32s
    uv: Float64s
    band: Float64s
    gap: Float64s

    def __len__(self) -> int:
        return len(self.distance)

    @property
    def on_edge(self) -> npt.NDArray[np.bool_]:
        """(n,) bool: whose nearest point lies on an edge."""
        return self.edge >= 0


@dataclass(frozen=True)
class Samples:
    """n points of the faces of a model, by instance, then by face, distributed evenly by area in each face.

    point: (n, 3) float64, mm, world. normal: (n, 3) float64, unit, outward.
    face, instance: (n,) int32. uv: (n, 2) float64, as in Distances.
    """

    point: Float64s
    normal: Float64s
    face: Int32s
    instance: Int32s
    uv: Float64s

    def __len__(self) -> int:
        return len(self.point)


@dataclass(frozen=True)
class EdgeSamples:
    """n points of the edges of a model, by instance, then by edge, spread along each.

    point: (n, 3) float64, mm, world. edge, instance: (n,) int32.
    """

    point: Float64s
    edge: Int32s
    instance: Int32s

    def __len__(self) -> int:
        return len(self.point)


def distances(index: _core.PointIndex, points: npt.ArrayLike, edges: bool, threads: int) -> Distances:
    """From each of points, (n, 3) or (3,), to what is indexed, or to its edges alone. Raises UsageError."""
    try:
        array = np.ascontiguousarray(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(f"points: {error}") from None
    if array.ndim not in (1, 2) or array.shape[-1] != 3:
        raise UsageError(f"points: shape {array.shape}, expected (n, 3)")
    array = array.reshape(-1, 3)
    finite = np.isfinite(array).all(axis=1)
    if not finite.all():
        raise UsageError(f"points: number {int(np.argmin(finite))} is not finite")
    parts = [
        index.nearest(array[i : i + _PORTION], edges, threads) for i in range(0, max(len(array), 1), _PORTION)
    ]
    return Distances(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def check_count(count: int, seed: int) -> None:
    """Raises UsageError for what the core cannot take."""
    if not 0 <= int(count) <= 1 << 24:
        raise UsageError(f"count: {count!r} is not in 0..{1 << 24}")
    if not 0 <= int(seed) < 1 << 64:
        raise UsageError(f"seed: {seed!r} is not in 0..2^64 - 1")
