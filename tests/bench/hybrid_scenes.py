"""The scenes that the hybrid tracer is judged on, framed as the paper has them where it has them.

The paper's table (WSCG 2008): one patch at 27 % coverage, a Cornell box at 100 %, a teapot at 21 %.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

import trimray

ROOT = Path(__file__).resolve().parents[2]
MODELS = Path(os.environ.get("TRIMRAY_MODELS", ROOT.parent / "shared" / "models"))
PROJECTIONS = ("orthographic", "perspective")
SAMPLES = ROOT / "samples"


@dataclass(frozen=True)
class Scene:
    name: str
    file: Path
    view: str | tuple[float, float] = "iso"
    up: str = "z"
    perspective: bool = False
    coverage: float | None = None  # as the picture is framed; None: fitted
    rate: float = 0.0  # goal: millions of covered pixels a second and core


SCENES = (
    Scene("patch", SAMPLES / "patch.step", coverage=0.27),
    Scene("cornell", SAMPLES / "cornell_box.step", view="back", up="y", perspective=True, coverage=1.0),
    Scene("teapot", MODELS / "derived/utah_teapot_32patches.step", coverage=0.21, rate=5.0),
    # A thin bent shell, seen nearly edge-on in the iso view (12 %): from above, so that it is seen at all.
    Scene("part.igs", MODELS / "vrsys+gpucast/part.igs", view=(-110.0, 45.0), rate=5.0),
    Scene("NIST_MBE_PMI_2", MODELS / "BRL-CAD+brlcad/NIST_MBE_PMI_2.stp", rate=2.0),
    Scene("impeller", MODELS / "pypi-pyiges/impeller.igs"),
    Scene("aircraft", MODELS / "derived/tigl_D150_aircraft_mirrored.step"),
    Scene("Bowden_Module", MODELS / "VoronDesign+Voron-Stealthburner/Bowden_Module.step"),
)


@dataclass(frozen=True)
class View:
    """A camera in numbers, for what the API's cameras do not do: to look beside the model's middle."""

    eye: npt.NDArray[np.float64]
    right: npt.NDArray[np.float64]
    up: npt.NDArray[np.float64]
    forward: npt.NDArray[np.float64]
    pixel: float
    size: int
    perspective: bool = False

    @staticmethod
    def of(camera: trimray.Camera) -> View:
        c = camera
        return View(c.eye, c.right, c.up, c.forward, float(c.pixel), c.size[0], c.perspective)

    def zoomed(self, zoom: float, size: int | None = None) -> View:
        """The same middle; without a zoom the same field of view at any size."""
        size = size or self.size
        return replace(self, pixel=self.pixel / zoom * self.size / size, size=size)

    def moved(self, x_px: float, y_px: float) -> View:
        """To another middle; orthographic."""
        return replace(self, eye=self.eye + self.pixel * (x_px * self.right - y_px * self.up))

    def rays(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Origins and directions of the pixels' middles, row by row."""
        at = (np.arange(self.size) + 0.5 - 0.5 * self.size) * self.pixel
        aside = (at[None, :, None] * self.right - at[:, None, None] * self.up).reshape(-1, 3)
        if self.perspective:
            return np.broadcast_to(self.eye, aside.shape), self.forward + aside
        return self.eye + aside, np.broadcast_to(self.forward, aside.shape)

    def numbers(self) -> str:
        values = [*self.eye, *self.right, *self.up, *self.forward, self.perspective]
        values += [self.pixel, self.size, self.size]
        return ",".join(repr(float(v)) for v in values)


def covered(model: trimray.Model, view: View) -> npt.NDArray[np.bool_]:
    """(size, size): the pixels that show something."""
    return (model.cast(*view.rays()).face >= 0).reshape(view.size, view.size)


def framed(scene: Scene, model: trimray.Model, size: int) -> View:
    """The scene's view at its coverage, as near as the model's shape allows."""
    view = View.of(
        model.camera((size, size), view=scene.view, up=scene.up, projection=PROJECTIONS[scene.perspective])
    )
    if scene.coverage is None:
        return view
    low = view.zoomed(1.0, 192)
    near, far = 0.05, 20.0  # zooms that cover too little and enough
    for _ in range(24):
        zoom = math.sqrt(near * far)
        if covered(model, low.zoomed(zoom)).mean() < scene.coverage:
            near = zoom
        else:
            far = zoom
    return view.zoomed(far)


def magnified(model: trimray.Model, view: View, zoom: float) -> View:
    """Zoomed in on the place next to the picture's middle that is covered all around, if there is one."""
    if view.perspective:
        return view.zoomed(zoom)
    low = view.zoomed(1.0, 192)
    mask = covered(model, low)
    reach = max(1, round(0.5 * low.size / zoom))
    inner = mask.copy()
    for shift in range(-reach, reach + 1):
        inner &= np.roll(mask, shift, 0) & np.roll(mask, shift, 1)
    y, x = np.nonzero(inner if inner.any() else mask)
    if len(x) == 0:
        return view.zoomed(zoom)
    dx, dy = x + 0.5 - 0.5 * low.size, y + 0.5 - 0.5 * low.size
    k = int(np.argmin(dx * dx + dy * dy))
    return low.moved(float(dx[k]), float(dy[k])).zoomed(1.0, view.size).zoomed(zoom)
