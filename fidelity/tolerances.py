"""How much may differ before it counts, by profile."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerances:
    """Lengths are fractions of the larger diagonal of the two models' bounds; volume, area and inertia are
    relative, and what the integration may be off by is added to them. pixels: of one picture, that may
    differ."""

    volume: float
    area: float
    inertia: float
    centroid: float
    bounds: float
    distance: float  # of a point of one model from the other
    placement: float  # of an instance
    color: int  # steps of 8 bit sRGB
    depth: float
    normal: float  # radians
    pixels: int


PROFILES: dict[str, Tolerances] = {
    "strict": Tolerances(1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-12, 0, 1e-9, 1e-6, 0),
    "default": Tolerances(1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-9, 0, 1e-6, 1e-4, 0),
    "lenient": Tolerances(1e-3, 1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-6, 2, 1e-4, 1e-2, 64),
}
