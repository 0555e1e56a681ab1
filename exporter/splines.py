"""Splines as arrays: Bezier pieces put together again, Bezier forms moved to other ends. No OpenCascade."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_ROUNDING = 64 * float(np.finfo(np.float64).eps)  # of the coordinates, of a control point cut out of a spline
_GAP = 1e-12  # of the range of parameters, between pieces
_MOST_FITTED = 500  # control points: their matrix is dense
_SAME = 1e-13  # of the coordinates: what putting pieces together may move them


class CurveError(ValueError):
    """Pieces that are no one curve."""


@dataclass(frozen=True)
class Spline:
    """A clamped B-spline with homogeneous control points (n, d + 1), and its flat knots."""

    degree: int
    knots: Floats
    ctrl_h: Floats

    @property
    def first(self) -> float:
        return float(self.knots[0])

    @property
    def last(self) -> float:
        return float(self.knots[-1])


def joined(pieces: Any, ctrl_h: Floats, *, turned: bool = False) -> Spline:
    """The pieces of an edge or a co-edge as one spline over increasing parameters.

    pieces: records of trim_pieces or edge_pieces; turned: they run against their parameter.
    Raises CurveError where they do not follow each other.
    """
    parts = [
        (t0, t1, ctrl_h[begin:end])
        for t0, t1, (begin, end) in zip(
            pieces["t0"].tolist(), pieces["t1"].tolist(), pieces["ctrl"].tolist(), strict=True
        )
    ]
    if turned:
        parts = [(t1, t0, points[::-1]) for t0, t1, points in reversed(parts)]
    degree = len(parts[0][2]) - 1
    if any(len(points) != degree + 1 for _, _, points in parts):
        raise CurveError("pieces of several degrees")
    ends = [parts[0][0], *(t1 for _, t1, _ in parts)]
    if any(not a < b for a, b in pairwise(ends)):
        raise CurveError("pieces that do not follow each other")
    if any(abs(b[0] - a[1]) > _GAP * (ends[-1] - ends[0]) for a, b in pairwise(parts)):
        raise CurveError("pieces with a gap between them")
    return _smooth(degree, ends, [points for _, _, points in parts])


def _smooth(degree: int, ends: list[float], parts: list[Floats]) -> Spline:
    """The spline with the fewest knots that has these pieces: files hold smooth splines, and readers cut
    again what is smooth to one derivative only."""
    at, ctrl = np.array(ends), np.array(parts)
    full = np.full(len(parts) - 1, degree)
    inner = degree - _continuity(degree, at, ctrl)
    if (inner < degree).any():
        spline = _spline(degree, at, inner, ctrl)
        bound = _SAME * np.abs(ctrl).max()
        if np.abs(_cut(spline, at) - ctrl).max() <= bound:
            return spline
        spline = _fitted(spline, at, ctrl)
        if np.abs(_cut(spline, at) - ctrl).max() <= bound:
            return spline
    return _spline(degree, at, full, ctrl)


def _continuity(degree: int, ends: Floats, ctrl: Floats) -> NDArray[np.intp]:
    """How many derivatives (of the homogeneous curve) agree where pieces meet, below the degree.

    ends (m + 1,), ctrl (m, degree + 1, d): of the pieces.
    """
    left, right = ctrl[:-1], ctrl[1:]
    before, after = np.diff(ends[:-1]), np.diff(ends[1:])
    # The longer piece is carried on over the shorter one: that loses less.
    swap = (after > before)[:, None, None]
    row, other = np.where(swap, right, left[:, ::-1]), np.where(swap, left[:, ::-1], right)
    s = 1.0 + np.minimum(before, after) / np.maximum(before, after)
    smooth = np.ones(len(left), dtype=bool)
    found = np.zeros(len(left), dtype=np.intp)
    bound = _ROUNDING * np.abs(ctrl).max() * np.ones(len(left))
    for k in range(degree):
        # row[:, 0]: control point k of the longer piece's continuation over the shorter one
        smooth &= np.abs(row[:, 0] - other[:, k]).max(axis=1) <= bound
        found[smooth] = k
        row = (1.0 - s)[:, None, None] * row[:, 1:] + s[:, None, None] * row[:, :-1]
        bound *= 2.0 * s
    return found


def _spline(degree: int, ends: Floats, inner: NDArray[np.intp], ctrl: Floats) -> Spline:
    """inner: multiplicities of the inner knots."""
    counts = np.concatenate([[degree + 1], inner, [degree + 1]])
    knots = np.repeat(ends, counts)
    last = np.cumsum(counts) - 1  # index of the last of equal knots: where a piece begins
    piece = np.full(len(knots), -1)
    piece[last[:-1]] = np.arange(len(ctrl))
    # A control point is the polar form of any piece in whose knots it is one; the longest loses least.
    index = np.arange(len(knots) - degree - 1)
    around = index[:, None] + np.arange(degree + 1)
    lengths = np.where(piece[around] >= 0, knots[around + 1] - knots[around], -1.0)
    chosen = piece[around[index, np.argmax(lengths, axis=1)]]
    work, a, b = ctrl[chosen], ends[chosen], ends[chosen + 1]
    for level in range(1, degree + 1):
        t = knots[index + level]
        s = ((t - a) / (b - a))[:, None, None]
        work = (1.0 - s) * work[:, :-1] + s * work[:, 1:]
    points = work[:, 0]
    weight = ctrl[0, 0, -1]
    if (ctrl[:, :, -1] == weight).all():
        points[:, -1] = weight  # not rational, whatever rounding says
    return Spline(degree, knots, points)


def _fitted(spline: Spline, ends: Floats, ctrl: Floats) -> Spline:
    """Its control points from all pieces at once: those of high degree are lost to rounding when they come
    from one piece alone."""
    count = len(spline.ctrl_h)
    if count > _MOST_FITTED:
        return spline
    unit = replace(spline, ctrl_h=np.eye(count))
    matrix = _cut(unit, ends).reshape(-1, count)
    points = np.linalg.lstsq(matrix, ctrl.reshape(len(matrix), -1), rcond=None)[0].astype(np.float64)
    if np.ptp(spline.ctrl_h[:, -1]) == 0.0:
        points[:, -1] = spline.ctrl_h[:, -1]
    return replace(spline, ctrl_h=points)


def _cut(spline: Spline, ends: Floats) -> Floats:
    """The Bezier pieces of a spline (m, degree + 1, d), by de Boor's triangle."""
    p, knots = spline.degree, spline.knots
    span = np.searchsorted(knots, ends[:-1], side="right") - 1
    local = spline.ctrl_h[span[:, None] - p + np.arange(p + 1)]
    pieces: Floats = np.empty_like(local)
    for k in range(p + 1):
        work = local
        for level in range(1, p + 1):
            t = ends[:-1] if level <= p - k else ends[1:]
            low = knots[span[:, None] - p + level + np.arange(p - level + 1)]
            high = knots[span[:, None] + 1 + np.arange(p - level + 1)]
            s = ((t[:, None] - low) / (high - low))[:, :, None]
            work = (1.0 - s) * work[:, :-1] + s * work[:, 1:]
        pieces[:, k] = work[:, 0]
    return pieces


def distinct(knots: Floats) -> tuple[list[float], list[int]]:
    """Knots and their multiplicities."""
    values, counts = np.unique(knots, return_counts=True)
    return values.tolist(), counts.tolist()


def over_unit(ctrl: Floats, first: float, last: float) -> Floats:
    """Bezier control points (degree + 1, ...) over [first, last] as those over [0, 1], by blossoming."""
    if first == 0.0 and last == 1.0:
        return ctrl
    degree = len(ctrl) - 1
    zero, one = (0.0 - first) / (last - first), (1.0 - first) / (last - first)
    result = np.empty_like(ctrl)
    for k in range(degree + 1):
        work = ctrl.copy()
        for level, s in enumerate([zero] * (degree - k) + [one] * k):
            n = degree - level
            work[:n] = (1.0 - s) * work[:n] + s * work[1 : n + 1]
        result[k] = work[0]
    return result
