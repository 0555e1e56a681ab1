"""What a model costs to draw: the report that the paper of hybrid ray tracing makes of its scenes.

O. Abert, M. Broecker, R. Spring, "Accelerating Rendering of NURBS Surfaces by Using Hybrid Ray Tracing", WSCG
2008, table 1. Every figure is a median of several pictures with one ray a pixel, whose outputs are t, face,
instance, uv and normal; the tracers take turns.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from .camera import Camera
from .importer.errors import UsageError
from .seeds import SEED_DEVIATION_PX, SEED_PROCESSES
from .views import choose

if TYPE_CHECKING:
    from .model import Model

SEEDS = ("auto", "none", "osmesa", "egl", "embree")
PAPER_PACKET = 4

Figures = dict[str, Any]


def measure(
    model: Model,
    camera: Camera,
    *,
    seeds: str = "auto",
    threads: int = 0,
    repeat: int = 5,
    progress: Callable[[str, float | None], None] | None = None,
) -> Figures:
    """Facts and times of one picture, by the names that docs/cli.md explains.

    seeds: the backend that draws the seeds; "auto" chooses, "none" leaves them out. threads: of the figures
    for all threads; 0 for all cores. Raises EmptyError, UsageError.
    """
    seeds = choose("seeds", seeds, SEEDS)
    view, store = camera._core, model._core
    if progress is not None:
        progress("hierarchy", None)
    scene, paper = model._scene, _core.paper_scene(store, PAPER_PACKET)
    # The mesh that seeds, and who draws it.
    levels = _core.MeshLevels(store, math.inf)
    start = time.perf_counter()
    triangles, _, _ = levels.triangles(view, SEED_DEVIATION_PX)
    mesh_seconds = time.perf_counter() - start
    first = _core.measure_picture(scene, view, "standard")
    rasterizer = _rasterizer(seeds, first["covered"], triangles)

    def draw(process: str, count: int) -> _core.Seeds:
        assert rasterizer is not None
        return rasterizer.seeds(levels, store, view, SEED_DEVIATION_PX, process, count)

    # By name: the scene, the mode and the seeds' process of a tracer.
    tracers: dict[str, tuple[_core.Scene, str, str | None]] = {
        "paper": (paper, "standard", None),
        "standard": (scene, "standard", None),
        "hybrid": (scene, "hybrid", None),
    }
    drawn: dict[str, _core.Seeds] = {}
    if rasterizer is not None:
        for process in SEED_PROCESSES:
            drawn[process] = draw(process, threads)
            tracers[f"hybrid_{process}"] = (scene, "hybrid", process)
    counters: dict[str, Figures] = {}
    frames: dict[str, dict[str, float]] = {}
    stages: dict[str, float] = {}
    for name, count in (("one_thread", 1), ("all_threads", threads)):
        seconds: dict[str, list[float]] = {}
        for turn in range(max(repeat, 1)):
            if progress is not None:
                progress("trace", (turn + (repeat if count != 1 else 0)) / (2 * max(repeat, 1)))
            for process in drawn:
                start = time.perf_counter()
                drawn[process] = draw(process, count)
                seconds.setdefault(f"raster_{process}", []).append(time.perf_counter() - start)
            for tracer, (of, mode, by) in tracers.items():
                figures = _core.measure_picture(of, view, mode, None if by is None else drawn[by], 32, count)
                seconds.setdefault(tracer, []).append(figures["seconds"])
                counters[tracer] = figures
            start = time.perf_counter()
            _color(scene, view, count)
            seconds.setdefault("color", []).append(time.perf_counter() - start)
        median = {key: statistics.median(values) for key, values in seconds.items()}
        frames[name] = {
            tracer: round(1.0 / (median[tracer] + (0.0 if by is None else median[f"raster_{by}"])), 3)
            for tracer, (_, _, by) in tracers.items()
        }
        if count == 1:
            stages = {f"raster_{process}": median[f"raster_{process}"] for process in drawn}
            stages |= {"trace": median["hybrid"], "shade": max(0.0, median["color"] - median["hybrid"])}
    best = counters["hybrid_uv" if drawn else "hybrid"]
    covered = best["covered"]
    return {
        "size": list(camera.size),
        "nurbs_surfaces": int(sum(status == "ok" for status in store.face_statuses())),
        "triangles": triangles,
        "screen_coverage": _share(covered, best["pixels"]),
        "bvh_boxes": {"paper": paper.leaf_boxes, "standard": scene.leaf_boxes},
        "intersections": {name: c["solves"] for name, c in counters.items()},
        "frames_per_second": frames,
        "raster": None if rasterizer is None else rasterizer.name,
        "fallback_share": _share(best["edge_rays"], covered),
        "open_share": _share(best["open"], covered),
        "seeded_share": _share(best["seeded"], covered),
        "newton_steps": _share(best["newton_steps"], best["newton_roots"]),
        "calls_per_covered_pixel": _share(best["solves"], covered),
        "stage_seconds": {key: round(value, 6) for key, value in ({"mesh": mesh_seconds} | stages).items()},
        "bytes": {"store": len(store.save()), "hierarchy": scene.bytes, "paper_hierarchy": paper.bytes},
    }


def _share(part: int, whole: int) -> float | None:
    return round(part / whole, 6) if whole else None


def _rasterizer(seeds: str, covered: int, triangles: int) -> _core.Rasterizer | None:
    if seeds == "none":
        return None
    if seeds == "auto":
        try:
            return _core.Rasterizer(_core.choose_raster(covered, triangles))
        except _core.CoreError:
            return None  # none of them can draw here
    try:
        return _core.Rasterizer(seeds)
    except _core.CoreError as error:
        raise UsageError(f"seeds: {' '.join(str(error).split())}") from None


def _color(scene: _core.Scene, view: _core.Camera, threads: int) -> None:
    white = np.ones((2, 4), np.float32)
    scene.render(view, ["color"], 1, white, False, "hybrid", threads, _core.Progress())
