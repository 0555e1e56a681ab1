"""Meshes for a camera: as coarse as its picture allows."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from . import _core
from .camera import Camera
from .importer.errors import UsageError
from .tri_mesh import MeshIssue, Part, Piece, TriMesh, parse_deviation, place, placed

if TYPE_CHECKING:
    from .model import Model

DEFAULT_DEVIATION = "0.3px"


class Levels:
    """The meshes that views of a model have had, kept for the next ones."""

    def __init__(self) -> None:
        self._kept: tuple[float, _core.MeshLevels] | None = None

    def of(self, store: _core.Store, angle: float) -> _core.MeshLevels:
        kept = self._kept
        if kept is None or kept[0] != angle:
            kept = self._kept = (angle, _core.MeshLevels(store, angle))
        return kept[1]


def tessellate_view(
    model: Model,
    levels: Levels,
    deviation: float | str | None,
    angle: float | None,
    camera: Camera,
    threads: int,
    progress: Callable[[str, float | None], None] | None,
) -> TriMesh:
    """Model.tessellate with a view."""
    number, unit = parse_deviation(DEFAULT_DEVIATION if deviation is None else deviation)
    if unit != "px":
        raise UsageError(f"deviation: '{deviation}': with a view it is given in pixels, such as 0.3px")
    if angle is not None and not angle > 0.0:
        raise UsageError(f"angle: {angle} is not a positive angle")
    if progress is not None:
        progress("mesh", None)
    kept = levels.of(model._core, math.inf if angle is None else float(angle))
    found, meshes, _ = kept.meshes(camera._core, number, threads)
    parts = [Part(*arrays) for arrays, _ in meshes]
    issues = [MeshIssue(face, reason) for _, named in meshes for face, reason in named]
    instances = placed(model)
    pieces = tuple(Piece(instance, instances[instance], parts[mesh]) for instance, mesh, _ in found)
    return place(model, pieces, issues, math.nan, number)
