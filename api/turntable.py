"""A model that turns: frames of one framing, each rendered while the raster pass of the next one runs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import _core
from .frame import Frame
from .importer.errors import TimeLimitError, UsageError
from .pictures import Look, seeds_of, trace
from .run import run_watched
from .views import UP_AXES, View, choose

if TYPE_CHECKING:
    from .model import Model

MAX_FRAMES = 10_000
# Steps of a turn that the framing is fitted to: between two of them nothing moves out by more than 4e-5 of
# its distance from the axis.
_STEPS = 360


def parse_frames(frames: int | str) -> int:
    """Raises UsageError."""
    try:
        count = int(frames)
    except (TypeError, ValueError):
        count = 0
    if not 1 <= count <= MAX_FRAMES:
        raise UsageError(f"frames: '{frames}' is not a whole number from 1 to {MAX_FRAMES}")
    return count


def cameras(
    model: Model, frames: int, size: tuple[int, int], view: View, projection: str, up: str
) -> list[_core.Camera]:
    """Of one full turn about the upright line through the middle of the model's bounds, from `view` on, the
    azimuth growing. All frame the whole turn alike. Raises EmptyError, UsageError."""
    axis = choose("up", up.lower().lstrip("+"), UP_AXES)
    pivot = np.ascontiguousarray(model.bounds.mean(axis=0))
    outline = _turned(model._extent[1], pivot, "xyz".index(axis[-1]))
    first = model._camera(size, view, projection, up, outline)
    upright = getattr(_core.UpAxis, UP_AXES[axis])
    return [first.turned(360.0 * k / frames, pivot, upright) for k in range(frames)]


def _turned(
    points: npt.NDArray[np.float64], pivot: npt.NDArray[np.float64], axis: int
) -> npt.NDArray[np.float64]:
    """All places of the points in a turn about an axis of the world. Only the outermost at a height count."""
    p = points - pivot
    a, b = p[:, (axis + 1) % 3], p[:, (axis + 2) % 3]
    radius, height = np.hypot(a, b), p[:, axis]
    keep = _outermost(radius, height)
    angle = 2.0 * math.pi / _STEPS * np.arange(_STEPS)
    turned = np.empty((len(keep), _STEPS, 3))
    turned[..., axis] = height[keep, None]
    turned[..., (axis + 1) % 3] = radius[keep, None] * np.cos(angle)
    turned[..., (axis + 2) % 3] = radius[keep, None] * np.sin(angle)
    return np.ascontiguousarray(turned.reshape(-1, 3) + pivot)


def _outermost(radius: npt.NDArray[np.float64], height: npt.NDArray[np.float64]) -> list[int]:
    """Indices of the points whose circles the hull of all circles rests on (Andrew's monotone chain)."""
    hull: list[int] = []
    for i in np.lexsort((radius, height)).tolist():
        while len(hull) > 1:
            o, q = hull[-2], hull[-1]
            cross = (height[q] - height[o]) * (radius[i] - radius[o])
            if cross - (radius[q] - radius[o]) * (height[i] - height[o]) < 0.0:
                break
            hull.pop()
        hull.append(i)
    return hull


def turntable(
    model: Model,
    views: list[_core.Camera],
    look: Look,
    time_limit: float | None,
    progress: Callable[[str, float | None], None] | None,
) -> Iterator[Frame]:
    """Frames of the cameras, in their order. While one is traced, the seeds of the next are made. Raises
    TimeLimitError."""
    deadline = None if time_limit is None else time.monotonic() + time_limit
    pool = ThreadPoolExecutor(1, "trimray-seeds")
    try:
        ahead = pool.submit(seeds_of, model, views[0], look)
        for k, camera in enumerate(views):
            now, ahead = ahead, _next(pool, model, views[k + 1 : k + 2], look)

            def work(
                tiles: _core.Progress, camera: _core.Camera = camera, now: Future[_core.Seeds | None] = now
            ) -> Frame:
                return trace(model, camera, look, now.result(), tiles)

            def told(stage: str, fraction: float | None, k: int = k) -> None:
                if progress is not None:
                    progress("turn", (k + (fraction or 0.0)) / len(views))

            left = None if deadline is None else deadline - time.monotonic()
            if left is not None and left <= 0.0:
                raise TimeLimitError(f"frame {k + 1} of {len(views)} was not reached within {time_limit:g} s")
            yield run_watched(work, _core.Progress(), left, told)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _next(
    pool: ThreadPoolExecutor, model: Model, views: list[_core.Camera], look: Look
) -> Future[_core.Seeds | None]:
    return pool.submit(seeds_of, model, views[0], look) if views else Future()
