"""Hits: what rays met, one row a ray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .importer.errors import UsageError

Float64s = npt.NDArray[np.float64]
Int32s = npt.NDArray[np.int32]
Rays = tuple[Float64s, Float64s, Float64s, Float64s]  # origins, directions, tmin, tmax


@dataclass(frozen=True)
class Hits:
    """Nearest hits of n rays.

    t: (n,) float64, in multiples of the direction's length; inf for a miss.
    face: (n,) int32, number of the face; -1 for a miss. instance: (n,) int32; -1 for a miss.
    uv: (n, 2) float64, the surface parameters of the file (angles for circular directions); 0 for a miss.
    normal: (n, 3) float64, unit, outward geometric normal in the world; 0 for a miss.
    """

    t: Float64s
    face: Int32s
    instance: Int32s
    uv: Float64s
    normal: Float64s

    def __len__(self) -> int:
        return len(self.t)

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """(n,) bool: which rays met a face."""
        return self.face >= 0


def check_rays(
    origins: npt.ArrayLike, directions: npt.ArrayLike, tmin: npt.ArrayLike, tmax: npt.ArrayLike
) -> Rays:
    """Four C-contiguous arrays of one length: (n, 3), (n, 3), (n,), (n,) float64.

    A single point or direction, (3,), and a single tmin or tmax stand for all rays. Raises UsageError.
    """
    o, d = _vectors("origins", origins), _vectors("directions", directions)
    low, high = _numbers("tmin", tmin), _numbers("tmax", tmax)
    counts = {len(a) for a in (o, d, low, high)} - {1}
    if len(counts) > 1:
        raise UsageError(
            f"rays: {len(o)} origins, {len(d)} directions, {len(low)} tmin and {len(high)} tmax do not fit"
        )
    n = counts.pop() if counts else 1
    return (
        np.ascontiguousarray(np.broadcast_to(o, (n, 3))),
        np.ascontiguousarray(np.broadcast_to(d, (n, 3))),
        np.ascontiguousarray(np.broadcast_to(low, (n,))),
        np.ascontiguousarray(np.broadcast_to(high, (n,))),
    )


def _vectors(name: str, values: npt.ArrayLike) -> Float64s:
    array = _floats(name, values)
    if array.ndim not in (1, 2) or array.shape[-1] != 3:
        raise UsageError(f"{name}: shape {array.shape}, expected (n, 3)")
    return array.reshape(-1, 3)


def _numbers(name: str, values: npt.ArrayLike) -> Float64s:
    array = _floats(name, values)
    if array.ndim > 1:
        raise UsageError(f"{name}: shape {array.shape}, expected a number or (n,)")
    return array.reshape(-1)


def _floats(name: str, values: npt.ArrayLike) -> Float64s:
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "fiub":
            raise TypeError
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise UsageError(f"{name}: not an array of numbers") from None


def portions_of(rays: Rays, length: int) -> list[Rays]:
    """At least one, of so many rays at most."""
    o, d, tmin, tmax = rays
    cuts = [slice(i, i + length) for i in range(0, max(len(o), 1), length)]
    return [(o[c], d[c], tmin[c], tmax[c]) for c in cuts]
