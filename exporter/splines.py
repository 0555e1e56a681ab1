"""Splines as arrays: Bezier pieces put together again, Bezier forms moved to other ends. No OpenCascade."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_EPS = float(np.finfo(np.float64).eps)
_SAME = 1e-14  # of the coordinates: what putting pieces together may move them


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
    return _smooth(degree, ends, [points for _, _, points in parts])


def _smooth(degree: int, ends: list[float], parts: list[Floats]) -> Spline:
    """The spline with the fewest knots that has these pieces: files cut smooth splines, and their readers
    cut again what is smooth to one derivative only."""
    inner = [
        degree - _continuity(degree, ends[i : i + 3], parts[i], parts[i + 1]) for i in range(len(parts) - 1)
    ]
    if any(count < degree for count in inner):
        spline = _spline(degree, ends, inner, parts)
        if _agrees(spline, ends, parts):
            return spline
    return _spline(degree, ends, [degree] * len(inner), parts)


def _continuity(degree: int, ends: list[float], left: Floats, right: Floats) -> int:
    """How many derivatives (of the homogeneous curve) agree where two pieces meet, below the degree."""
    a, t, b = ends
    if b - t > t - a:  # carry the longer piece on over the shorter one: that loses less
        a, t, b = -b, -t, -a
        left, right = right[::-1], left[::-1]
    s = (b - a) / (t - a)
    rounding = 16.0 * _EPS * max(float(np.abs(left).max()), float(np.abs(right).max()))
    row = left[::-1]
    for k in range(degree):
        # row[0]: the left piece's control point k of its continuation over [t, b]
        if np.abs(row[0] - right[k]).max() > rounding * (2.0 * s) ** k:
            return max(k - 1, 0)
        row = (1.0 - s) * row[1:] + s * row[:-1]
    return degree - 1


def _spline(degree: int, ends: list[float], inner: list[int], parts: list[Floats]) -> Spline:
    counts = [degree + 1, *inner, degree + 1]
    knots = [t for t, n in zip(ends, counts, strict=True) for _ in range(n)]
    first = np.cumsum([0, *counts])  # index of the first of equal knots
    points = []
    for i in range(len(knots) - degree - 1):
        wanted = knots[i + 1 : i + degree + 1]
        # Pieces in whose knots the control point is one: those that begin at knots i to i + degree.
        choices = [j for j in range(len(parts)) if i <= first[j + 1] - 1 <= i + degree]
        points.append(min((_blossom(parts[j], ends[j], ends[j + 1], wanted) for j in choices), key=_loss)[1])
    ctrl_h = np.array(points)
    weight = parts[0][0, -1]
    if all((part[:, -1] == weight).all() for part in parts):
        ctrl_h[:, -1] = weight  # not rational, whatever rounding says
    return Spline(degree, np.array(knots), ctrl_h)


def _loss(found: tuple[float, Floats]) -> float:
    return found[0]


def _blossom(ctrl: Floats, a: float, b: float, at: list[float]) -> tuple[float, Floats]:
    """How much rounding grows, and the value of the polar form of a Bezier piece over [a, b]."""
    growth = 1.0
    for t in at:
        if t == a:
            ctrl = ctrl[:-1]
        elif t == b:
            ctrl = ctrl[1:]
        else:
            s = (t - a) / (b - a)
            growth *= abs(s) + abs(1.0 - s)
            ctrl = (1.0 - s) * ctrl[:-1] + s * ctrl[1:]
    return growth, ctrl[0]


def _agrees(spline: Spline, ends: list[float], parts: list[Floats]) -> bool:
    """Cutting the spline again gives the pieces, but for rounding."""
    for j, ctrl in enumerate(parts):
        scale = float(np.abs(ctrl).max())
        for k, point in enumerate(ctrl):
            at = [ends[j]] * (spline.degree - k) + [ends[j + 1]] * k
            if np.abs(_polar(spline, ends[j], at) - point).max() > _SAME * scale:
                return False
    return True


def _polar(spline: Spline, start: float, at: list[float]) -> Floats:
    """The polar form of the segment that begins at a knot, by de Boor's triangle."""
    p, knots = spline.degree, spline.knots
    span = int(np.searchsorted(knots, start, side="right")) - 1
    work = spline.ctrl_h[span - p : span + 1]
    for level, t in enumerate(at, start=1):
        low, high = knots[span - p + level : span + 1], knots[span + 1 : span + p - level + 2]
        s = ((t - low) / (high - low))[:, None]
        work = (1.0 - s) * work[:-1] + s * work[1:]
    result: Floats = work[0]
    return result


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
