"""Both models under one camera, pixel by pixel.

A pixel belongs to the one ray through its centre. Where that ray passes an outline or an edge, rounding alone
may decide what it meets. So two pixels that differ are looked at again: if one model, seen by a ray moved by
no more than the tolerance, shows what the other one shows, they are the same.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from trimray.camera import Camera
from trimray.frame import Frame

from .colors import colors_of
from .findings import found, not_comparable
from .overlay import overlay
from .record import Finding, Picture
from .side import Float64s, Side
from .tolerances import Tolerances

VIEWS = ("iso", "front", "back", "left", "right", "top", "bottom")
SIZE = (384, 384)
# Layers of coincident faces that a ray is asked for.
_LAYERS = 4
_AROUND = 8

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Seen:
    """What rays meet first. depth: (n,) mm, inf for nothing. normal: (n, 3). color: (n, 4) 8 bit; (n, 0)
    where colours are not compared."""

    depth: Float64s
    normal: Float64s
    color: npt.NDArray[np.int16]

    def of(self, which: Any) -> Seen:
        return Seen(self.depth[which], self.normal[which], self.color[which])


@dataclass(frozen=True)
class Limits:
    """depth: mm. normal: cosine of the angle. color: steps; None where colours are not compared."""

    depth: float
    normal: float
    color: int | None


def compare_pictures(
    a: Side,
    b: Side,
    tolerances: Tolerances,
    *,
    views: Sequence[str] = VIEWS,
    size: tuple[int, int] = SIZE,
    images: bool = True,
    colors: bool = True,
    threads: int = 0,
) -> tuple[list[Finding], list[Picture]]:
    """images: make the PNG of the pictures, too. colors: compare those, too, where both formats hold some."""
    drawable = [side.diagonal > 0.0 for side in (a, b)]
    if not all(drawable):
        return [not_comparable("pictures", "pictures", drawable, "no face can be drawn")], []
    limits = Limits(
        tolerances.depth * max(a.diagonal, b.diagonal),
        float(np.cos(tolerances.normal)),
        tolerances.color if colors and a.holds("colors") and b.holds("colors") else None,
    )
    findings: list[Finding] = []
    pictures: list[Picture] = []
    for view in views:
        camera = a.sound.camera(size, view=view, beside=[b.sound])
        planes = ("color", "depth", "normal", "face", "instance") if images else (
            "depth", "normal", "face", "instance"
        )  # fmt: skip
        frames = [s.sound.render(view=camera, aovs=planes, threads=threads) for s in (a, b)]
        differing = differing_pixels((a, b), frames, camera, limits, threads)
        counts = {name: int(plane.sum()) for name, plane in differing.items()}
        total = int(np.logical_or.reduce(list(differing.values())).sum())
        if limits.color is None:
            del counts["color"]
        pngs = [_png(frame["color"]) for frame in frames] if images else [b"", b""]
        marked = _png(overlay(frames, differing)) if images else b""
        pictures.append(Picture(view, size, counts, pngs[0], pngs[1], marked))
        findings.append(
            found("pictures", view, [int(np.isfinite(f["depth"]).sum()) for f in frames],
                total <= tolerances.pixels, "px", float(total), float(tolerances.pixels),
                reason=", ".join(f"{n} in {name}" for name, n in counts.items() if n),
            )
        )  # fmt: skip
    return findings, pictures


def differing_pixels(
    sides: tuple[Side, Side], frames: Sequence[Frame], camera: Camera, limits: Limits, threads: int = 0
) -> dict[str, Bools]:
    """(h, w) by plane: "coverage", "depth", "normal", "color"."""
    shape = frames[0]["depth"].shape
    colors = [_Colors(side) for side in sides]
    seen = [
        Seen(
            frame["depth"].ravel(),
            frame["normal"].reshape(-1, 3),
            known.of(frame["instance"].ravel(), frame["face"].ravel())
            if limits.color is not None
            else np.zeros((frame["depth"].size, 0), np.int16),
        )
        for frame, known in zip(frames, colors, strict=True)
    ]
    differ = _differences(seen[0], seen[1], limits)
    where = np.flatnonzero(np.logical_or.reduce(list(differ.values())))
    if len(where):
        origins, directions = (x.reshape(-1, 3)[where] for x in camera.rays())
        excused = np.zeros(len(where), bool)
        for k in (0, 1):
            excused |= _shown_nearby(
                sides[k], colors[k], seen[1 - k].of(where), origins, directions, camera, limits, threads
            )
        for plane in differ.values():
            plane[where[excused]] = False
    return {name: plane.reshape(shape) for name, plane in differ.items()}


def _differences(a: Seen, b: Seen, limits: Limits) -> dict[str, Bools]:
    hit_a, hit_b = np.isfinite(a.depth), np.isfinite(b.depth)
    both = hit_a & hit_b
    gap = np.where(both, a.depth, 0.0) - np.where(both, b.depth, 0.0)
    color = np.zeros(len(both), bool)
    if limits.color is not None:
        color = both & _other_color(a.color, b.color, limits.color)
    return {
        "coverage": hit_a != hit_b,
        "depth": both & (np.abs(gap) > limits.depth),
        "normal": both & (np.einsum("ij,ij->i", a.normal, b.normal) < limits.normal),
        "color": color,
    }


def _other_color(a: npt.NDArray[np.int16], b: npt.NDArray[np.int16], steps: int) -> Bools:
    other: Bools = (np.abs(a - b).max(axis=-1) > steps) | ((a[..., 0] < 0) != (b[..., 0] < 0))
    return other


class _Colors:
    """Of (instance, face), 8 bit."""

    def __init__(self, side: Side) -> None:
        self._side = side
        self._known: dict[int, tuple[int, npt.NDArray[np.int16]]] = {}

    def of(self, instances: npt.NDArray[np.int32], faces: npt.NDArray[np.int32]) -> npt.NDArray[np.int16]:
        """(n, 4); nothing (-1) has no colour."""
        result = np.full((len(faces), 4), -1, np.int16)
        for instance in np.unique(instances[instances >= 0]).tolist():
            if instance not in self._known:
                begin, end = self._side.arrays["prototypes"]["faces"][int(self._side.prototypes[instance])]
                self._known[instance] = int(begin), colors_of(self._side, instance, np.arange(begin, end))
            begin, table = self._known[instance]
            here = instances == instance
            result[here] = table[faces[here] - begin]
        return result


def _shown_nearby(
    side: Side,
    colors: _Colors,
    wanted: Seen,
    origins: Float64s,
    directions: Float64s,
    camera: Camera,
    limits: Limits,
    threads: int,
) -> Bools:
    """(n,): whether rays within the tolerance of the given ones show what is wanted of them."""
    count = len(origins)
    missed, agrees = np.zeros(count, bool), np.zeros(count, bool)
    least, most = np.full(count, np.inf), np.full(count, -np.inf)
    angles = np.arange(_AROUND) * (2.0 * np.pi / _AROUND)
    shifts = [(0.0, 0.0), *zip(np.cos(angles).tolist(), np.sin(angles).tolist(), strict=True)]
    for x, y in shifts:
        moved = origins + limits.depth * (x * camera.right + y * camera.up)
        start = np.zeros(count)
        for layer in range(_LAYERS):
            hits = side.sound.cast(moved, directions, tmin=start, threads=threads)
            hit = np.isfinite(hits.t)
            if layer == 0:
                missed |= ~hit
                top = hits.t
            near = hit & (hits.t <= top + 2.0 * limits.depth)
            if not near.any():
                break
            alike = near & (np.einsum("ij,ij->i", hits.normal, wanted.normal) >= limits.normal)
            if limits.color is not None:
                alike &= ~_other_color(colors.of(hits.instance, hits.face), wanted.color, limits.color)
            agrees |= alike
            least[alike] = np.minimum(least, hits.t)[alike]
            most[alike] = np.maximum(most, hits.t)[alike]
            start = np.where(hit, np.nextafter(hits.t, np.inf) + 1e-12 * limits.depth, start)
    nothing = ~np.isfinite(wanted.depth)
    depth = np.where(nothing, 0.0, wanted.depth)
    fits = agrees & (depth >= least - limits.depth) & (depth <= most + limits.depth)
    return np.asarray(np.where(nothing, missed, fits), bool)


def _png(rgba: npt.NDArray[Any]) -> bytes:
    stream = io.BytesIO()
    Frame({"color": rgba}, (rgba.shape[1], rgba.shape[0])).save(stream, format="png")
    return stream.getvalue()
