"""Volume, area, centroid, inertia and bounds of both, with what their integration may be off by.

Where there is no inspection of a file, the numbers are those of a mesh whose deviation is proven: less
precise, and honest about it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .findings import found
from .record import Finding
from .side import Float64s, Side
from .tolerances import Tolerances

# Of the mesh, as a share of the diagonal.
_DEVIATION = 1e-4
# Units whose sizes files mix up, in mm.
_UNITS = {"mm": 1.0, "cm": 10.0, "inch": 25.4, "ft": 304.8, "m": 1000.0, "mil": 0.0254, "um": 1e-3}


@dataclass(frozen=True)
class Mass:
    """In the world, mm: each number and what it may be off by. inertia: about the centroid, of density 1."""

    volume: tuple[float, float]
    area: tuple[float, float]
    centroid: tuple[Float64s, float]
    inertia: tuple[Float64s, float]


def compare_mass(a: Side, b: Side, tolerances: Tolerances) -> list[Finding]:
    scale = max(a.diagonal, b.diagonal)
    masses = mass_of(a), mass_of(b)
    findings = [
        _number("volume", "mm³", masses[0].volume, masses[1].volume, tolerances.volume),
        _number("area", "mm²", masses[0].area, masses[1].area, tolerances.area),
        _vector("centroid", "mm", masses[0].centroid, masses[1].centroid, tolerances.centroid * scale),
        _vector(
            "inertia", "mm⁵", masses[0].inertia, masses[1].inertia,
            tolerances.inertia * max(float(np.abs(m.inertia[0]).max()) for m in masses),
        ),
    ]  # fmt: skip
    return [*findings, *_bounds(a, b, tolerances.bounds * scale)]


def _number(name: str, unit: str, a: tuple[float, float], b: tuple[float, float], relative: float) -> Finding:
    tolerance = relative * max(abs(a[0]), abs(b[0])) + a[1] + b[1]
    difference = b[0] - a[0]
    return Finding("mass", name, a[0], b[0], abs(difference) <= tolerance, unit, difference, tolerance)


def _vector(
    name: str, unit: str, a: tuple[Float64s, float], b: tuple[Float64s, float], tolerance: float
) -> Finding:
    tolerance += a[1] + b[1]
    difference = float(np.abs(b[0] - a[0]).max())
    values = a[0].tolist(), b[0].tolist()
    return found("mass", name, values, difference <= tolerance, unit, difference, tolerance)


def _bounds(a: Side, b: Side, tolerance: float) -> list[Finding]:
    boxes = [side.sound._extent[0] for side in (a, b)]
    if not all(np.isfinite(box).all() for box in boxes):
        shown = [bool(np.isfinite(box).all()) for box in boxes]
        return [found("mass", "can be drawn", shown, shown[0] == shown[1], missing=shown[0] != shown[1])]
    difference = float(np.abs(boxes[0] - boxes[1]).max())
    same = difference <= tolerance
    values = boxes[0].tolist(), boxes[1].tolist()
    reason = "" if same else _scaled(a, b)
    return [found("mass", "bounds", values, same, "mm", difference, tolerance, reason=reason)]


def _scaled(a: Side, b: Side) -> str:
    """Whether B is A in another unit."""
    ratio = b.diagonal / a.diagonal if a.diagonal > 0.0 else 0.0
    for one, size in _UNITS.items():
        for other, other_size in _UNITS.items():
            if one != other and abs(ratio * other_size / size - 1.0) < 1e-3:
                return f"{ratio:.6g} times as large: as if {other} had been read as {one}"
    return ""


def mass_of(side: Side) -> Mass:
    """Of the inspection, else of a mesh."""
    return _of_mesh(side)


def _of_mesh(side: Side) -> Mass:
    zero = np.zeros(3), 0.0
    if side.diagonal == 0.0:
        return Mass((0.0, 0.0), (0.0, 0.0), zero, (np.zeros((3, 3)), 0.0))
    deviation = _DEVIATION * side.diagonal
    mesh = side.sound.tessellate(deviation, angle=0.2)
    low, high = side.sound.bounds
    origin = 0.5 * (low + high)
    corners = mesh.vertices[mesh.triangles] - origin
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(crosses, axis=1)
    volumes = np.einsum("ij,ij->i", corners[:, 0], crosses) / 6.0
    area, volume = float(areas.sum()), float(volumes.sum())
    moments = np.einsum("i,ij->j", volumes, corners.sum(axis=1)) / 4.0
    second = _second_moments(corners, volumes)
    proven = mesh.deviation[np.isfinite(mesh.deviation)]
    off = float(proven.max(initial=0.0)) if len(proven) == len(mesh.deviation) else side.diagonal
    noise = off * area
    # Of the area: chords of an angle of 0.2 are short of their arcs by 0.2 ** 2 / 24.
    error = area * 2e-3 * (1.0 if off > 0.0 else 1e-9)
    closed = volume != 0.0 and abs(volume) > noise
    center = moments / volume if closed else np.zeros(3)
    reach = side.diagonal * min(1.0, noise / abs(volume)) if closed else side.diagonal
    about = second - volume * np.outer(center, center)
    inertia = np.trace(about) * np.eye(3) - about
    return Mass((volume, noise), (area, error), (center + origin, reach), (inertia, noise * side.diagonal**2))


def _second_moments(corners: Float64s, volumes: Float64s) -> Float64s:
    """(3, 3): the integral of x xᵀ over the tetrahedra between triangles and the origin."""
    total = corners.sum(axis=1)
    outer = np.einsum("ijk,ijl,i->kl", corners, corners, volumes)
    outer += np.einsum("ij,ik,i->jk", total, total, volumes)
    return np.asarray(outer / 20.0, np.float64)
