"""First hits against closed forms: quadrics, tori and boxes, native and as NURBS, near and far.

Every scene is a solid whose hits a few lines of long double arithmetic give; the judge shares nothing
with the tracer. A hit is wrong when one side misses, and t is wrong beyond HIT_TOL of the diagonal.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import trimray

Array = NDArray[np.float64]
Long = NDArray[np.longdouble]

HIT_TOL = 1e-9  # of the diagonal
FAR = np.array([1e5, -1e5, 1e5])  # mm


@dataclass(frozen=True)
class Scene:
    """A solid made by OpenCascade, and its judge in the solid's own frame (centre, z axis)."""

    name: str
    shape: object
    first_hit: Callable[[Long, Long], Long]  # (n, 3) origins and directions -> (n,) t, inf
    centre: Array
    diagonal: float
    height: float  # of the axis above the centre
    grazing: tuple[float, ...]  # silhouette offsets that its coordinates can still resolve


def _inside_slab(z: Long, low: float, high: float) -> NDArray[np.bool_]:
    return (z >= low) & (z <= high)


def _quadratic(a: Long, b: Long, c: Long) -> tuple[Long, Long]:
    """Both roots of a t^2 + 2 b t + c, NaN where there are none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(b * b - a * c)
        q = -(b + np.copysign(root, b))
        return q / a, c / q


def _nearest(candidates: list[tuple[Long, NDArray[np.bool_]]]) -> Long:
    best = np.full(candidates[0][0].shape, np.inf, dtype=np.longdouble)
    for t, ok in candidates:
        take = ok & np.isfinite(t) & (t >= 0) & (t < best)
        best = np.where(take, t, best)
    return best


def _at(o: Long, d: Long, t: Long) -> Long:
    return o + np.where(np.isfinite(t), t, 0)[:, None] * d


def sphere_hits(r: float) -> Callable[[Long, Long], Long]:
    def hits(o: Long, d: Long) -> Long:
        # The closest point of the line to the centre first: no cancellation.
        dd = (d * d).sum(1)
        s = -(o * d).sum(1) / dd
        p = o + s[:, None] * d
        h = np.longdouble(r) ** 2 - (p * p).sum(1)
        with np.errstate(invalid="ignore"):
            w = np.sqrt(h / dd)
        return _nearest([(s - w, h >= 0), (s + w, h >= 0)])

    return hits


def cone_hits(r0: float, r1: float, height: float) -> Callable[[Long, Long], Long]:
    """A frustum from radius r0 at z = 0 to r1 at z = height; r0 = r1 is a cylinder, r1 = 0 a cone."""
    k = (np.longdouble(r1) - np.longdouble(r0)) / np.longdouble(height)

    def hits(o: Long, d: Long) -> Long:
        radius = r0 + k * o[:, 2]
        a = d[:, 0] ** 2 + d[:, 1] ** 2 - (k * d[:, 2]) ** 2
        b = o[:, 0] * d[:, 0] + o[:, 1] * d[:, 1] - k * d[:, 2] * radius
        c = o[:, 0] ** 2 + o[:, 1] ** 2 - radius**2
        candidates = []
        for t in _quadratic(a, b, c):
            z = _at(o, d, t)[:, 2]
            candidates.append((t, _inside_slab(z, 0, height)))
        for z0, r in ((0.0, r0), (height, r1)):
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (z0 - o[:, 2]) / d[:, 2]
            p = _at(o, d, t)
            candidates.append((t, p[:, 0] ** 2 + p[:, 1] ** 2 <= np.longdouble(r) ** 2))
        return _nearest(candidates)

    return hits


def box_hits(size: tuple[float, float, float]) -> Callable[[Long, Long], Long]:
    half = np.array(size, dtype=np.longdouble) / 2

    def hits(o: Long, d: Long) -> Long:
        with np.errstate(divide="ignore", invalid="ignore"):
            t0, t1 = (-half - o) / d, (half - o) / d
        enter = np.nanmax(np.minimum(t0, t1), axis=1)
        leave = np.nanmin(np.maximum(t0, t1), axis=1)
        outside = ((d == 0) & (np.abs(o) > half)).any(1)
        return _nearest([(enter, (enter <= leave) & ~outside)])

    return hits


def torus_hits(major: float, minor: float) -> Callable[[Long, Long], Long]:
    def f(o: Long, d: Long, t: Long) -> tuple[Long, Long]:
        p = o + t[:, None] * d
        rho = np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2)
        value = (rho - major) ** 2 + p[:, 2] ** 2 - np.longdouble(minor) ** 2
        with np.errstate(invalid="ignore"):  # 0 / 0 on the axis, never at a root
            drho = (p[:, 0] * d[:, 0] + p[:, 1] * d[:, 1]) / rho
        return value, 2 * (rho - major) * drho + 2 * p[:, 2] * d[:, 2]

    def hits(o: Long, d: Long) -> Long:
        # Bracket on a fine grid of t, refine the extrema between samples, then bisect: slow and sure.
        length = np.sqrt((d * d).sum(1))
        s = -(o * d).sum(1) / length**2
        reach = np.longdouble(1.01) * (major + minor) / length
        best = np.full(len(o), np.inf, dtype=np.longdouble)
        steps = 600
        grid = np.linspace(-1, 1, steps + 1, dtype=np.longdouble)
        values = np.stack([f(o, d, s + g * reach)[0] for g in grid])
        for i in range(len(o)):
            column = values[:, i]
            ts = list(s[i] + grid * reach[i])
            fs = list(column)
            for k in range(steps - 1, 0, -1):  # a dip between samples may hide two roots
                if fs[k] > 0 and column[k] <= column[k - 1] and column[k] <= column[k + 1]:
                    tm = _minimum(f, o[i : i + 1], d[i : i + 1], ts[k - 1], ts[k + 1])
                    vm = f(o[i : i + 1], d[i : i + 1], np.array([tm]))[0][0]
                    if vm < 0:
                        at = k if tm < ts[k] else k + 1
                        ts.insert(at, tm)
                        fs.insert(at, vm)
            for k in range(len(ts) - 1):
                if fs[k] > 0 >= fs[k + 1] or fs[k] <= 0 < fs[k + 1]:
                    t = _bisect(f, o[i : i + 1], d[i : i + 1], ts[k], ts[k + 1], fs[k])
                    if t >= 0:
                        best[i] = min(best[i], t)
                        break
        return best

    return hits


def _bisect(f, o: Long, d: Long, low, high, f_low):  # type: ignore[no-untyped-def]
    for _ in range(70):
        mid = (low + high) / 2
        if (f(o, d, np.array([mid]))[0][0] > 0) == (f_low > 0):
            low = mid
        else:
            high = mid
    return (low + high) / 2


def _minimum(f, o: Long, d: Long, low, high):  # type: ignore[no-untyped-def]
    for _ in range(90):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        if f(o, d, np.array([a]))[0][0] < f(o, d, np.array([b]))[0][0]:
            high = b
        else:
            low = a
    return (low + high) / 2


def scenes() -> Iterator[Scene]:
    """30 scenes: five solids, native and as NURBS, at the origin, far away, and tiny."""
    import cadquery as cq
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert

    places = [("", np.zeros(3), 1.0), ("_far", FAR, 1.0), ("_tiny", np.zeros(3), 1e-3)]
    for place, centre, size in places:
        v = cq.Vector(*centre)
        solids = [
            ("sphere", cq.Solid.makeSphere(7 * size, v, angleDegrees1=-90), sphere_hits(7 * size), 0.0),
            (
                "cylinder",
                cq.Solid.makeCylinder(5 * size, 12 * size, v),
                cone_hits(5 * size, 5 * size, 12 * size),
                12 * size,
            ),
            (
                "cone",
                cq.Solid.makeCone(6 * size, 0, 9 * size, v),
                cone_hits(6 * size, 0.0, 9 * size),
                9 * size,
            ),
            ("torus", cq.Solid.makeTorus(8 * size, 3 * size, v), torus_hits(8 * size, 3 * size), 0.0),
            (
                "box",
                cq.Workplane("XY").box(9 * size, 7 * size, 5 * size).translate(tuple(centre)).val(),
                box_hits((9 * size, 7 * size, 5 * size)),
                0.0,
            ),
        ]
        # What double precision leaves of an offset from the silhouette at these coordinates.
        grazing = (1e-4, 1e-6) if place == "_far" else (1e-3, 1e-6, 1e-9)
        for (name, solid, judge, height), nurbs in itertools.product(solids, (False, True)):
            box = solid.BoundingBox(1e-6)
            shape = solid
            if nurbs:
                shape = cq.Shape.cast(BRepBuilderAPI_NurbsConvert(solid.wrapped, True).Shape())
            yield Scene(
                f"{name}{place}{'_nurbs' if nurbs else ''}",
                shape,
                judge,
                centre,
                box.DiagonalLength,
                height,
                grazing,
            )


def views() -> list[Array]:
    """The 26 directions of a cube's faces, edges and corners."""
    return [np.array(d, float) for d in itertools.product((-1, 0, 1), repeat=3) if any(d)]


def rays_of(scene: Scene, view: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """n x n parallel rays over the solid, rays through its axis and centre, and grazing rays.

    The grid is shifted by an irrational part of a cell, so that no ray lies in a rim or a seam by
    accident; those that shall lie there are added on purpose.
    """
    d = view / np.linalg.norm(view)
    right = np.cross(d, [0.0, 0.0, 1.0] if abs(d[2]) < 0.9 else [1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, d)
    half = 0.55 * scene.diagonal
    g = ((np.arange(n) + 0.41421356) / n * 2 - 1) * half
    x, y = (a.ravel() for a in np.meshgrid(g, g))
    local = x[:, None] * right + y[:, None] * up
    # Through the axis at mid height, so that the ray crosses the seam; no ray lies in a rim's plane.
    special = [np.array([0.0, 0.0, 0.4142 * scene.height])]
    if "sphere" in scene.name:
        radius = 7e-3 if "tiny" in scene.name else 7.0
        for h in scene.grazing:
            for sign in (-1, 1):
                a = rng.uniform(0, 2 * np.pi, 8)
                r = radius + sign * h * scene.diagonal
                special += list(r * (np.cos(a)[:, None] * right + np.sin(a)[:, None] * up))
    local = np.concatenate([local, np.array(special)])
    origins = scene.centre + local - d * 2 * scene.diagonal
    length = rng.uniform(0.5, 2.0)  # directions need not be of unit length
    return origins, np.broadcast_to(d * length, origins.shape).copy()


@dataclass
class Result:
    name: str
    rays: int = 0
    wrong: int = 0
    worst: float = 0.0  # |dt| times the direction's length, as a fraction of the diagonal


def check(scene: Scene, n: int, mode: str = "standard") -> Result:
    """All 26 views of one scene with n x n rays each."""
    rng = np.random.default_rng(20261122)
    model = trimray.load(scene.shape, cache=False)
    result = Result(scene.name)
    for view in views():
        origins, directions = rays_of(scene, view, n, rng)
        t = model.cast(origins, directions, mode=mode).t
        o = origins.astype(np.longdouble) - scene.centre.astype(np.longdouble)
        truth = scene.first_hit(o, directions.astype(np.longdouble))
        miss = np.isinf(truth) != np.isinf(t)
        both = np.isfinite(truth) & np.isfinite(t)
        error = np.abs(truth[both] - t[both]) * np.linalg.norm(directions[0]) / scene.diagonal
        result.rays += len(t)
        result.wrong += int(miss.sum()) + int((error > HIT_TOL).sum())
        result.worst = max(result.worst, float(error.max(initial=0)))
    return result
