"""MassProperties: area, volume, centroid and inertia of a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _core

Float64s = npt.NDArray[np.float64]


@dataclass(frozen=True)
class MassProperties:
    """Of the surfaces and p-curves as they are, in the world, mm, of density 1, with what each may be off by.

    Only closed shells have a volume; it is negative for shells inside out and taken off for cavities.

    volume: mm³. area: mm², of all faces.
    centroid: (3,) float64, mm, of the volume; None where there is none.
    inertia: (3, 3) float64, mm⁵, about the centroid and along the world's axes; None as centroid.
    *_error: what the number may be off by, in its unit: the difference between the last two rules of the
        integration, and rounding. Not in it is what p-curves are off their edges.
    face_areas, face_area_errors: (n,) float64, mm², by the face's number, where its part was modelled (that
        is before an instance scales it); NaN for faces that cannot be drawn.
    shell_volumes, shell_volume_errors: (s,) float64, mm³, by shell in the order of the faces, as face_areas;
        NaN for shells that are not closed.
    left_out: numbers of the faces that are in no sum since they cannot be drawn (``report`` says why). Their
        shells have no volume.
    """

    volume: float
    area: float
    centroid: Float64s | None
    inertia: Float64s | None
    volume_error: float
    area_error: float
    centroid_error: float
    inertia_error: float
    face_areas: Float64s
    face_area_errors: Float64s
    shell_volumes: Float64s
    shell_volume_errors: Float64s
    left_out: tuple[int, ...]


def mass_properties(core: _core.Store, threads: int) -> MassProperties:
    """threads: 0 for all cores."""
    found = _core.measure_mass(core, threads)
    solid = np.isfinite(found["centroid_error"])
    return MassProperties(
        volume=found["volume"][0],
        area=found["area"][0],
        centroid=found["centroid"] if solid else None,
        inertia=found["inertia"] if solid else None,
        volume_error=found["volume"][1],
        area_error=found["area"][1],
        centroid_error=found["centroid_error"] if solid else 0.0,
        inertia_error=found["inertia_error"] if solid else 0.0,
        face_areas=found["face_integrals"][:, 0].copy(),
        face_area_errors=found["face_integral_errors"][:, 0].copy(),
        shell_volumes=found["shell_volumes"],
        shell_volume_errors=found["shell_volume_errors"],
        left_out=tuple(found["left_out"].tolist()),
    )
