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

    @classmethod
    def of(
        cls,
        aovs: Sequence[str] | str,
        samples: int | str,
        background: Background,
        mode: str,
        orientation: bool,
        threads: int,
    ) -> Look:
        """Raises UsageError."""
        return cls(
            parse_aovs(aovs),
            parse_samples(samples),
            parse_background(background),
            choose("mode", mode, MODES),
            bool(orientation),
            int(threads),
        )


def draw(
    model: Model, camera: _core.Camera, look: Look, time_limit: float | None, progress: Progress | None
) -> Frame:
    """Raises TimeLimitError."""
    backdrop = np.array(look.background, np.float32)

    def work(tiles: _core.Progress) -> dict[str, npt.NDArray[Any]]:
        scene = model._scene
        start = time.perf_counter()
        planes = scene.render(
            camera,
            list(look.aovs),
            look.samples,
            backdrop,
            look.orientation,
            look.mode,
            look.threads,
            tiles,
        )
        model._seconds["trace"] = time.perf_counter() - start
        return planes

    planes = run_watched(work, _core.Progress(), time_limit, progress)
    return Frame(planes, (camera.width_px, camera.height_px))
