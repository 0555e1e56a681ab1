"""Planes other than the colour as pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

# ns, the ends of the scale of times, and its colours in even steps: black, violet, red, yellow, white.
_TIMES = (30.0, 30_000.0)
_HEAT = np.array([(0, 0, 0), (76, 12, 120), (200, 40, 70), (250, 200, 40), (255, 255, 255)], np.float64)


def false_colors(aov: str, plane: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """(h, w, 3): a plane of a Frame so that its parts can be told from one another; nothing is black."""
    if aov in ("face", "instance"):
        picture = _numbers(plane.astype(np.int64) + 1)
    elif aov == "seed_id":
        picture = _numbers(plane.astype(np.int64))
    elif aov == "time":
        scale = np.log(np.clip(plane, *_TIMES).astype(np.float64) / _TIMES[0]) / np.log(_TIMES[1] / _TIMES[0])
        steps = np.linspace(0.0, 1.0, len(_HEAT))
        picture = np.stack([np.interp(scale, steps, _HEAT[:, c]) for c in range(3)], axis=-1)
    elif aov == "depth":
        seen = np.isfinite(plane)
        picture = np.where(seen, 255.0 - 225.0 * _spread(plane, seen), 0.0)[..., None].repeat(3, axis=-1)
    elif aov == "normal":
        picture = np.where(plane.any(-1, keepdims=True), 127.5 + 127.5 * plane, 0.0)
    else:  # uv, seed_uv, position
        seen = np.asarray(plane.any(-1), bool)
        channels = [
            _within(plane[..., c]) if aov == "seed_uv" else _spread(plane[..., c], seen)
            for c in range(plane.shape[-1])
        ]
        channels += [np.zeros(plane.shape[:2])] * (3 - len(channels))
        picture = np.where(seen[..., None], 255.0 * np.stack(channels, axis=-1), 0.0)
    return np.ascontiguousarray((np.clip(picture, 0.0, 255.0) + 0.5).astype(np.uint8))


def _within(values: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    return np.clip(values.astype(np.float64), 0.0, 1.0)


def _spread(values: npt.NDArray[Any], seen: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """From 0 for the least value that is seen to 1 for the largest."""
    if not seen.any():
        return np.zeros(values.shape)
    least, most = float(values[seen].min()), float(values[seen].max())
    return (np.where(seen, values, least) - least) / ((most - least) or 1.0)


def _numbers(ids: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Hues in steps of the golden ratio, so that no two of neighbouring numbers are alike, in three shades; 0
    is black."""
    hue = (ids * 0.6180339887498949) % 1.0
    value = np.array([1.0, 0.78, 0.6])[ids % 3]
    saturation = np.array([0.55, 0.8])[ids // 3 % 2]
    ramp = np.abs((hue[..., None] * 6.0 + np.array([0.0, 4.0, 2.0])) % 6.0 - 3.0) - 1.0
    rgb = value[..., None] * (1.0 - saturation[..., None] * (1.0 - np.clip(ramp, 0.0, 1.0)))
    return np.where((ids != 0)[..., None], 255.0 * rgb, 0.0)
