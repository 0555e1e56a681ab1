"""Drawing: from a camera and what is wished of the picture to a Frame."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
import numpy.typing as npt

from . import _core
from .frame import Frame
from .importer.errors import UsageError
from .run import run_watched
from .seeds import SEED_AOVS, SEED_PROCESSES, SEEDS, choose_seeds
from .views import (
    MAX_OCCLUSION_RAYS,
    MAX_REFLECTIONS,
    MODES,
    Background,
    Rgba,
    choose,
    parse_aovs,
    parse_background,
    parse_count,
    parse_samples,
)

if TYPE_CHECKING:
    from .model import Model

Progress = Callable[[str, float | None], None]


class Words(TypedDict, total=False):
    """Model.render's arguments that say how a picture looks, and how it is made."""

    aovs: Sequence[str] | str
    samples: int | str
    background: Background
    mode: str
    orientation: bool
    threads: int
    seeds: str
    seed_process: str
    shadows: bool
    ambient_occlusion: int
    occlusion_distance: float
    reflections: int


@dataclass(frozen=True)
class Look:
    """What Model.render is asked for, the camera apart, checked."""

    aovs: tuple[str, ...]
    samples: int
    background: tuple[Rgba, Rgba]
    mode: str
    orientation: bool
    threads: int
    seeds: str
    seed_process: str
    shadows: bool
    ambient_occlusion: int
    occlusion_distance: float
    reflections: int

    @classmethod
    def of(
        cls,
        aovs: Sequence[str] | str = ("color",),
        samples: int | str = 4,
        background: Background = "white",
        mode: str = "hybrid",
        orientation: bool = False,
        threads: int = 0,
        seeds: str = "auto",
        seed_process: str = "uv",
        shadows: bool = False,
        ambient_occlusion: int = 0,
        occlusion_distance: float = 0.1,
        reflections: int = 0,
    ) -> Look:
        """Raises UsageError."""
        names, tracer = parse_aovs(aovs), choose("mode", mode, MODES)
        return cls(
            names,
            parse_samples(samples),
            parse_background(background),
            tracer,
            bool(orientation),
            int(threads),
            choose_seeds(choose("seeds", seeds, SEEDS), tracer, names),
            choose("seed_process", seed_process, SEED_PROCESSES),
            bool(shadows),
            parse_count("ambient_occlusion", ambient_occlusion, MAX_OCCLUSION_RAYS),
            _parse_distance(occlusion_distance),
            parse_count("reflections", reflections, MAX_REFLECTIONS),
        )

    def secondary(self, model: Model) -> _core.SecondaryOptions:
        options = _core.SecondaryOptions()
        if self.shadows or self.ambient_occlusion or self.reflections:
            lower, upper = model.bounds
            options.diagonal = float(np.linalg.norm(upper - lower))
            options.occlusion_distance = self.occlusion_distance * options.diagonal
        options.shadows, options.reflections = self.shadows, self.reflections
        options.ambient_occlusion = self.ambient_occlusion
        return options


def _parse_distance(fraction: float) -> float:
    if not 0.0 < fraction < math.inf:
        raise UsageError(f"occlusion_distance: {fraction!r} is not a number above 0")
    return float(fraction)


def draw(
    model: Model, camera: _core.Camera, look: Look, time_limit: float | None, progress: Progress | None
) -> Frame:
    """Raises TimeLimitError."""

    def work(tiles: _core.Progress) -> Frame:
        return trace(model, camera, look, seeds_of(model, camera, look), tiles)

    return run_watched(work, _core.Progress(), time_limit, progress)


def seeds_of(model: Model, camera: _core.Camera, look: Look) -> _core.Seeds | None:
    """None where none are wished for, or none can be had."""
    if look.seeds == "none":
        return None
    start = time.perf_counter()
    needed = any(aov in SEED_AOVS for aov in look.aovs)
    seeds = model._seeder.make(model, camera, look.seeds, look.seed_process, look.threads, needed)
    model._seconds["seeds"] = time.perf_counter() - start
    return seeds


def trace(
    model: Model, camera: _core.Camera, look: Look, seeds: _core.Seeds | None, tiles: _core.Progress
) -> Frame:
    """seeds: of this camera."""
    scene = model._scene
    start = time.perf_counter()
    planes: dict[str, npt.NDArray[Any]] = scene.render(
        camera,
        [aov for aov in look.aovs if aov not in SEED_AOVS],
        look.samples,
        np.array(look.background, np.float32),
        look.orientation,
        look.mode,
        look.threads,
        tiles,
        seeds,
        look.secondary(model),
    )
    model._seconds["trace"] = time.perf_counter() - start
    if seeds is not None:
        planes |= {"seed_id": seeds.id()} if "seed_id" in look.aovs else {}
        planes |= {"seed_uv": seeds.uv()} if "seed_uv" in look.aovs else {}
    return Frame({aov: planes[aov] for aov in look.aovs}, (camera.width_px, camera.height_px))
