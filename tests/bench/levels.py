"""Meshes for a view: triangles against the pixels that the model covers, seconds to build, and for the next
step of a turntable.

    scripts/bench levels [FILE...] [--sizes 512 1024] [--zooms 1 10] [--pixels 0.1 0.2 0.3]

The hybrid tracer wants at most a third of a triangle a covered pixel. Covered pixels are those of the face
AOV under the same camera. The step turns the view by 5 degrees at the same scale.
"""

from __future__ import annotations

import math
import statistics
import time
from pathlib import Path

import trimray
from trimray import _core
from trimray.views import VIEWS

SET = (
    "derived/utah_teapot_32patches.step",
    "vrsys+gpucast/part.igs",
    "BRL-CAD+brlcad/NIST_MBE_PMI_2.stp",
    "pypi-pyiges/impeller.igs",
    "derived/tigl_D150_aircraft_mirrored.step",
    "VoronDesign+Voron-Stealthburner/Bowden_Module.step",
    "yuechen-li-dev+Aetheris/nist_stc_06_asme1_ap242-e3.stp",
)
SIZES, ZOOMS, PIXELS = (512, 1024), (1.0, 10.0), (0.1, 0.2, 0.3)
STEP_DEG = 5.0


def views(
    model: trimray.Model, camera: trimray.Camera, turned: trimray.Camera, pixels: float, repeat: int
) -> tuple[int, float, float, int]:
    """Triangles of the first view; median seconds of it and of the next; meshes built for the next."""
    first, step, triangles, built = [], [], 0, 0
    for _ in range(repeat):
        levels = _core.MeshLevels(model._core, math.inf)
        start = time.perf_counter()
        triangles, _, _ = levels.triangles(camera._core, pixels)
        first.append(time.perf_counter() - start)
        start = time.perf_counter()
        _, built, _ = levels.triangles(turned._core, pixels)
        step.append(time.perf_counter() - start)
    return triangles, statistics.median(first), statistics.median(step), built


def table(files: list[Path], sizes: list[int], zooms: list[float], pixels: list[float], repeat: int) -> None:
    print(
        f"{'model':36} {'size':>5} {'zoom':>4} {'dev px':>6} {'triangles':>9} {'covered':>9} {'ratio':>6} "
        f"{'build s':>8} {'next s':>8} {'built':>5}"
    )
    azimuth, elevation = VIEWS["iso"]
    for file in files:
        model = trimray.load(file)
        for size in sizes:
            for zoom in zooms:
                camera = model.camera((size, size), zoom=zoom)
                step = (azimuth + STEP_DEG, elevation)
                fitted = model.camera((size, size), view=step)
                turned = model.camera((size, size), view=step, zoom=fitted.pixel / camera.pixel)
                face = model.render(view=camera, aovs=("face",), samples=1)["face"]
                covered = int((face >= 0).sum())
                for px in pixels:
                    triangles, first, second, built = views(model, camera, turned, px, repeat)
                    ratio = f"{triangles / covered:6.3f}" if covered else f"{'-':>6}"
                    print(
                        f"{file.name:36} {size:5} {zoom:4g} {px:6g} {triangles:9} {covered:9} {ratio} "
                        f"{first:8.3f} {second:8.3f} {built:5}",
                        flush=True,
                    )
