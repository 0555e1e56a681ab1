"""Volume, area, centroid, inertia and bounds of both, with what they may be off by.

All are integrated over the exact surfaces, trimmed by their p-curves, so that a tolerance of 1e-9 means what
it says. How far p-curves may stray is allowed for only where programs have made them anew, and a number
differs otherwise (``strips``).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from .findings import found
from .record import Finding
from .side import Float64s, Side
from .strips import changed_strips
from .tolerances import Tolerances

# Units whose sizes files mix up, in mm.
_UNITS = {"mm": 1.0, "cm": 10.0, "inch": 25.4, "ft": 304.8, "m": 1000.0, "mil": 0.0254, "um": 1e-3}


Value = float | Float64s


def compare_mass(a: Side, b: Side, tolerances: Tolerances) -> list[Finding]:
    x, y = a.mass, b.mass
    size, volume = max(a.diagonal, b.diagonal), max(abs(x.volume), abs(y.volume))
    work = _Numbers(a, b)
    allowed = tolerances.volume * volume + x.volume_error + y.volume_error
    findings = [work.compare("volume", "mm³", x.volume, y.volume, allowed, size / 6)]
    allowed = tolerances.area * max(x.area, y.area) + x.area_error + y.area_error
    findings.append(work.compare("area", "mm²", x.area, y.area, allowed, 1.0))
    if x.centroid is not None and y.centroid is not None:  # else the volumes tell
        allowed = tolerances.centroid * size + x.centroid_error + y.centroid_error
        findings.append(work.compare("centroid", "mm", x.centroid, y.centroid, allowed, size**2 / 6 / volume))
    if x.inertia is not None and y.inertia is not None:
        largest = max(float(np.abs(inertia).max()) for inertia in (x.inertia, y.inertia))
        allowed = tolerances.inertia * largest + x.inertia_error + y.inertia_error
        findings.append(work.compare("inertia", "mm⁵", x.inertia, y.inertia, allowed, size**3 / 6))
    return [*findings, *_bounds(a, b, tolerances.bounds * size)]


class _Numbers:
    """Compares numbers, and looks at p-curves when one differs."""

    def __init__(self, a: Side, b: Side) -> None:
        self._sides = a, b

    @cached_property
    def _strips(self) -> tuple[float, int]:
        return changed_strips(*self._sides)

    def compare(self, name: str, unit: str, a: Value, b: Value, tolerance: float, reach: float) -> Finding:
        """reach: at most what an area of 1 mm² that is added at a border changes."""
        difference = np.asarray(b) - np.asarray(a)
        worst, reason = float(np.abs(difference).max()), ""
        if tolerance < worst <= tolerance + reach * self._strips[0]:
            tolerance += reach * self._strips[0]
            reason = f"{self._strips[1]} edges have other p-curves"
        shown = float(difference) if difference.ndim == 0 else worst
        values = np.asarray(a).tolist(), np.asarray(b).tolist()
        return found("mass", name, values, worst <= tolerance, unit, shown, tolerance, reason=reason)


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
