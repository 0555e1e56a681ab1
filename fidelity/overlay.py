"""A picture of what differs: both models pale, what is only in A red, only in B blue, what differs orange,
its colour alone violet. Single pixels are made larger, and boxes are drawn round what lies together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]

ONLY_A = (0.84, 0.10, 0.11)
ONLY_B = (0.10, 0.35, 0.85)
DIFFERS = (1.0, 0.50, 0.0)
COLOR_DIFFERS = (0.60, 0.15, 0.75)
_BOX = (0.10, 0.10, 0.10)
# Pixels round a differing one that are painted, too; side of the cells by which boxes are found.
_GROW = 1
_CELL = 16


def overlay(
    frames: Sequence[Mapping[str, npt.NDArray[np.float32]]], differing: Mapping[str, Bools]
) -> Floats:
    """(h, w, 4) of two frames with color and depth, and what differs by plane (pictures.differing_pixels)."""
    hits = [np.isfinite(frame["depth"]) for frame in frames]
    base = np.where(hits[0][..., None] | ~hits[1][..., None], frames[0]["color"], frames[1]["color"])
    grey = base[..., :3].mean(axis=-1, keepdims=True)
    result = np.ones((*grey.shape[:2], 4), np.float32)
    shown = hits[0] | hits[1]
    result[..., :3] = np.where(shown[..., None], 0.72 + 0.25 * grey, 1.0)
    coverage = differing["coverage"]
    paints = (
        (differing["color"], COLOR_DIFFERS),
        (differing["depth"] | differing["normal"], DIFFERS),
        (coverage & hits[1], ONLY_B),
        (coverage & hits[0], ONLY_A),
    )
    everything = np.logical_or.reduce([mask for mask, _ in paints])
    for mask, color in paints:
        result[_grown(mask, _GROW), :3] = color
    for mask, color in paints:  # again, so that the pixel itself has its own
        result[mask, :3] = color
    for box in boxes(everything):
        _draw_box(result, box)
    return result


def boxes(mask: Bools) -> list[tuple[int, int, int, int]]:
    """(x0, y0, x1, y1), inclusive, of each group of marked pixels that lie in cells side by side."""
    rows, columns = np.nonzero(mask)
    cells = {(y // _CELL, x // _CELL) for y, x in zip(rows.tolist(), columns.tolist(), strict=True)}
    label: dict[tuple[int, int], int] = {}
    for start in sorted(cells):
        if start in label:
            continue
        number, stack = len(set(label.values())), [start]
        label[start] = number
        while stack:
            y, x = stack.pop()
            for near in ((y + i, x + j) for i in (-1, 0, 1) for j in (-1, 0, 1)):
                if near in cells and near not in label:
                    label[near] = number
                    stack.append(near)
    found: dict[int, list[int]] = {}
    for y, x in zip(rows.tolist(), columns.tolist(), strict=True):
        box = found.setdefault(label[y // _CELL, x // _CELL], [x, y, x, y])
        box[:] = min(box[0], x), min(box[1], y), max(box[2], x), max(box[3], y)
    return [(b[0], b[1], b[2], b[3]) for b in found.values()]


def _grown(mask: Bools, by: int) -> Bools:
    padded = np.pad(mask, by)
    height, width = mask.shape
    grown: Bools = np.logical_or.reduce(
        [padded[i : i + height, j : j + width] for i in range(2 * by + 1) for j in range(2 * by + 1)]
    )
    return grown


def _draw_box(picture: Floats, box: tuple[int, int, int, int]) -> None:
    height, width = picture.shape[:2]
    x0, y0, x1, y1 = box[0] - 6, box[1] - 6, box[2] + 6, box[3] + 6
    columns = slice(max(x0, 0), min(x1 + 1, width))
    rows = slice(max(y0, 0), min(y1 + 1, height))
    for y in (y0, y1):
        if 0 <= y < height:
            picture[y, columns, :3] = _BOX
    for x in (x0, x1):
        if 0 <= x < width:
            picture[rows, x, :3] = _BOX
