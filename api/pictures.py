"""Drawing: from a camera and what is wished of the picture to a Frame."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core
from .frame import Frame
from .run import run_watched
from .seeds import SEED_AOVS, SEED_PROCESSES, SEEDS, choose_seeds
from .views import MODES, Background, Rgba, choose, parse_aovs, parse_background, parse_samples

if TYPE_CHECKING:
    from .model import Model

Progress = Callable[[str, float | None], None]


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

    @classmethod
    def of(
        cls,
        aovs: Sequence[str] | str,
        samples: int | str,
        background: Background,
        mode: str,
        orientation: bool,
        threads: int,
        seeds: str,
        seed_process: str,
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
        )


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
    )
    model._seconds["trace"] = time.perf_counter() - start
    if seeds is not None:
        planes |= {"seed_id": seeds.id()} if "seed_id" in look.aovs else {}
        planes |= {"seed_uv": seeds.uv()} if "seed_uv" in look.aovs else {}
    return Frame({aov: planes[aov] for aov in look.aovs}, (camera.width_px, camera.height_px))
