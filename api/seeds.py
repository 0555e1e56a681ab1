"""Seeds: a raster pass that tells the hybrid tracer where to look first. They decide about time alone."""

from __future__ import annotations

import math
import threading
import warnings
from typing import TYPE_CHECKING

from . import _core
from .importer.errors import UsageError

if TYPE_CHECKING:
    from .model import Model

SEEDS = ("auto", "none", "osmesa", "egl", "embree")
SEED_PROCESSES = ("uv", "id")
SEED_AOVS = ("seed_id", "seed_uv")

# How far the mesh that is drawn may be off, px: it must show the right surface almost everywhere, no more.
SEED_DEVIATION_PX = 1.5
# What part of a picture a model is taken to cover, to choose a pass by.
_COVERED = 0.3


def choose_seeds(asked: str, mode: str, aovs: tuple[str, ...]) -> str:
    """What of SEEDS makes a picture, "none" included, where "auto" leaves it open. Raises UsageError."""
    wanted = [aov for aov in aovs if aov in SEED_AOVS]
    if wanted and asked == "none":
        raise UsageError(f"{wanted[0]}: there are no seeds without a raster pass: seeds is 'none'")
    if wanted:
        return asked
    # The mesh of a picture costs more than its pixels, and so do its seeds where the leaves' own outlines say
    # as much: what is not asked for is not made.
    return "none" if mode != "hybrid" or asked == "auto" else asked


class Seeder:
    """The rasterizers of a model, kept for its next picture. From any thread."""

    def __init__(self) -> None:
        self._rasterizers: dict[str, _core.Rasterizer] = {}
        self._lock = threading.Lock()

    def make(
        self, model: Model, camera: _core.Camera, seeds: str, process: str, threads: int, needed: bool
    ) -> _core.Seeds | None:
        """None where no backend works, which is said in a warning. needed: raises UsageError instead."""
        levels = model._levels.of(model._core, math.inf)
        try:
            if seeds == "auto":
                triangles, _, _ = levels.triangles(camera, SEED_DEVIATION_PX, threads)
                seeds = _core.choose_raster(_COVERED * camera.width_px * camera.height_px, triangles)
            rasterizer = self._rasterizer(seeds)
            return rasterizer.seeds(levels, model._core, camera, SEED_DEVIATION_PX, process, threads)
        except _core.CoreError as error:
            text = f"no raster pass ({seeds or 'auto'}): {' '.join(str(error).split())}"
            if needed:
                raise UsageError(text) from None
            warnings.warn(f"{text}; rendering without seeds", RuntimeWarning, stacklevel=2)
            return None

    def _rasterizer(self, backend: str) -> _core.Rasterizer:
        with self._lock:
            if backend not in self._rasterizers:
                self._rasterizers[backend] = _core.Rasterizer(backend)
            return self._rasterizers[backend]
