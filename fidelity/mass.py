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
_DEVIATION = 1e-3
# Units whose sizes files mix up, in mm.
_UNITS = {"mm": 1.0, "cm": 10.0, "inch": 25.4, "ft": 304.8, "m": 1000.0, "mil": 0.0254, "um": 1e-3}


@dataclass(frozen=True)
class Mass:
    """In the world, mm: each number and what it may be off by. inertia: about the centroid, of density 1;
    both None where nothing is closed."""

    volume: tuple[float, float]
    area: tuple[float, float]
    centroid: tuple[Float64s, float] | None
    inertia: tuple[Float64s, float] | None


def compare_mass(a: Side, b: Side, tolerances: Tolerances) -> list[Finding]:
    scale = max(a.diagonal, b.diagonal)
    x, y = mass_of(a), mass_of(b)
    largest = max((float(np.abs(m.inertia[0]).max()) for m in (x, y) if m.inertia), default=0.0)
    findings = [
        _number("volume", "mm³", x.volume, y.volume, tolerances.volume),
        _number("area", "mm²", x.area, y.area, tolerances.area),
        *_vector("centroid", "mm", x.centroid, y.centroid, tolerances.centroid * scale),
        *_vector("inertia", "mm⁵", x.inertia, y.inertia, tolerances.inertia * largest),
    ]
    return [*findings, *_bounds(a, b, tolerances.bounds * scale)]


def _number(name: str, unit: str, a: tuple[float, float], b: tuple[float, float], relative: float) -> Finding:
    tolerance = relative * max(abs(a[0]), abs(b[0])) + a[1] + b[1]
    difference = b[0] - a[0]
    return Finding("mass", name, a[0], b[0], abs(difference) <= tolerance, unit, difference, tolerance)


def _vector(
    name: str, unit: str, a: tuple[Float64s, float] | None, b: tuple[Float64s, float] | None, tolerance: float
) -> list[Finding]:
    if a is None or b is None:  # the volumes tell
        return []
    tolerance += a[1] + b[1]
    difference = float(np.abs(b[0] - a[0]).max())
    values = a[0].tolist(), b[0].tolist()
    return [found("mass", name, values, difference <= tolerance, unit, difference, tolerance)]


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
    if side.inspection is None:
        return _of_mesh(side)
    mass, size = side.inspection.mass, side.diagonal
    error = float(mass.volume_error + mass.volume_noise)
    volume, area = (float(mass.volume), error), (float(mass.area), float(mass.area_error + mass.area_noise))
    if mass.centroid is None or mass.inertia is None or abs(mass.volume) <= error:
        return Mass(volume, area, None, None)
    reach = size * error / abs(mass.volume)
    inertia = np.array(mass.inertia, np.float64).reshape(3, 3), error * size**2
    return Mass(volume, area, (np.array(mass.centroid, np.float64), reach), inertia)


def _of_mesh(side: Side) -> Mass:
    """Of closed shells, as an inspection's."""
    if side.diagonal == 0.0:
        return Mass((0.0, 0.0), (0.0, 0.0), None, None)
    mesh = side.sound.tessellate(_DEVIATION * side.diagonal)
    low, high = side.sound.bounds
    origin = 0.5 * (low + high)
    corners = mesh.vertices[mesh.triangles] - origin
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(crosses, axis=1)
    inside = side.arrays["shells"]["closed"][side.arrays["faces"]["shell"]].astype(bool)[mesh.face]
    volumes = np.einsum("ij,ij->i", corners[:, 0], crosses) / 6.0 * inside
    volume = float(volumes.sum())
    off = np.where(np.isfinite(mesh.deviation), mesh.deviation, side.diagonal)
    error = float((off * areas)[inside].sum())
    # The surface over a triangle is larger by what its normals lean, about half the square of their angle.
    normals = mesh.normals()
    flat = crosses / np.where(areas > 0.0, 2.0 * areas, 1.0)[:, None]
    lean = 1.0 - np.clip(np.einsum("ijk,ik->ij", normals, flat), 0.0, 1.0).min(axis=1)
    short = float((areas * lean).sum()) + 1e-12 * float(areas.sum())
    area = float(areas.sum()), short
    if abs(volume) <= 2.0 * error or volume == 0.0:
        return Mass((volume, error), area, None, None)
    center = np.einsum("i,ij->j", volumes, corners.sum(axis=1)) / (4.0 * volume)
    about = _second_moments(corners, volumes) - volume * np.outer(center, center)
    inertia = np.trace(about) * np.eye(3) - about
    reach = side.diagonal * error / abs(volume)
    return Mass((volume, error), area, (center + origin, reach), (inertia, error * side.diagonal**2))


def _second_moments(corners: Float64s, volumes: Float64s) -> Float64s:
    """(3, 3): the integral of x xᵀ over the tetrahedra between triangles and the origin."""
    total = corners.sum(axis=1)
    outer = np.einsum("ijk,ijl,i->kl", corners, corners, volumes)
    outer += np.einsum("ij,ik,i->jk", total, total, volumes)
    return np.asarray(outer / 20.0, np.float64)
