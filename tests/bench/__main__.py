"""Speed and memory of each stage, model by model, and of a cached second render; `scripts/bench mesh`: the
tessellator beside BRepMesh (mesh.py); `scripts/bench levels`: meshes for a view (levels.py);
`scripts/bench hybrid`: the hybrid tracer beside its baselines (hybrid.py); `scripts/bench batch`: a batch
beside loops over single commands (batch.py).

Every figure is a median of --repeat runs in this process or, for memory and the second render, of whole
processes. Rays are primary rays of the orthographic iso view at 1024 x 1024, background included, one
thread, so that rays/s is rays/s/core.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import trimray
from trimray import _core

from . import batch, distance, hybrid, levels, mesh, workers

ROOT = Path(__file__).resolve().parents[2]
MODELS = Path(os.environ.get("TRIMRAY_MODELS", ROOT.parent / "shared" / "models"))
SET = (
    "derived/utah_teapot_32patches.step",
    "vrsys+gpucast/part.igs",
    "BRL-CAD+brlcad/NIST_MBE_PMI_2.stp",
    "yuechen-li-dev+Aetheris/nist_ctc_01_asme1_ap242-e1.stp",
    "AngelLM+Thor/Art2BodyA.step",
    "pypi-pyiges/impeller.igs",
    "derived/tigl_D150_aircraft_mirrored.step",
    "VoronDesign+Voron-Stealthburner/Bowden_Module.step",
    "derived/kicad_board_small.step",
)
SIDE = 1024


def median(repeat: int, run: Callable[[], float]) -> float:
    return statistics.median(run() for _ in range(repeat))


def timed(run: Callable[[], object]) -> float:
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def iso_rays(model: trimray.Model) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions of SIDE x SIDE orthographic rays, 32 x 32 tiles."""
    low, high = model.bounds
    centre, diagonal = (low + high) / 2, float(np.linalg.norm(high - low))
    forward = np.array([-1.0, 1.0, -1.0]) / np.sqrt(3.0)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low) + low
    span = max(np.ptp(corners @ right), np.ptp(corners @ up)) * 1.05
    tile = np.arange(SIDE).reshape(-1, 32)
    order = np.array([(x, y) for ty in tile for tx in tile for y in ty for x in tx], float)
    offset = ((order + 0.5) / SIDE - 0.5) * span
    origins = centre - forward * diagonal * 1.5 + offset[:, :1] * right - offset[:, 1:] * up
    return origins, np.broadcast_to(forward, origins.shape).copy()


def cast_rate(model: trimray.Model, repeat: int) -> tuple[float, float]:
    """Millions of primary rays a second on one thread, and the share that hits."""
    scene = model._scene
    origins, directions = iso_rays(model)
    runs = [_core.measure_cast(scene, origins, directions, 1) for _ in range(repeat)]
    seconds = statistics.median(r["seconds"] for r in runs)
    return len(origins) / seconds / 1e6, runs[0]["covered"] / len(origins)


def import_table(files: list[Path], repeat: int) -> None:
    print(
        f"{'model':36} {'faces':>6} {'parse':>6} {'transf':>6} {'other':>6} {'extr':>6} {'store':>6} "
        f"{'e+s/1k':>7} {'hier':>6} {'hier/1k':>7} {'MB':>6} {'Mray/s':>7} {'cover':>6}"
    )
    for file in files:
        seconds: dict[str, list[float]] = {}
        for _ in range(repeat):
            model = trimray.load(file, cache=False)
            _ = model._scene
            for stage, value in model.report.seconds.items():
                seconds.setdefault(stage, []).append(value)
        s = {stage: statistics.median(values) for stage, values in seconds.items()}
        n = len(model.faces)
        named = ("parse", "transfer", "extract", "store", "hierarchy")
        other = sum(v for k, v in s.items() if k not in (*named, "extent", "total"))
        extra = s.get("extract", 0.0) + s["store"]
        rate, cover = cast_rate(model, repeat)
        print(
            f"{file.name:36} {n:6} {s.get('parse', 0):6.2f} {s.get('transfer', 0):6.2f} {other:6.2f} "
            f"{s.get('extract', 0):6.3f} {s['store']:6.3f} {extra / n * 1000:7.3f} {s['hierarchy']:6.3f} "
            f"{s['hierarchy'] / n * 1000:7.3f} {model._scene.bytes / 1e6:6.1f} {rate:7.2f} {cover:6.1%}",
            flush=True,
        )


def second_render(files: list[Path], repeat: int) -> None:
    """Whole processes: `trimray render` at 512 x 512, first (import) and again (from the cache)."""
    command = [str(Path(sys.executable).with_name("trimray")), "render", "-q", "--size", "512,512"]
    print(f"\n{'trimray render, 512 x 512, 4 samples':36} {'first s':>8} {'again s':>8} {'again MB':>9}")
    with tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, "XDG_CACHE_HOME": folder}
        for file in files:

            def run(file: Path = file) -> object:
                return subprocess.run([*command, str(file), "-o", f"{folder}/out.png"], env=env, check=False)

            first = timed(run)
            again = median(repeat, lambda: timed(run))
            memory = subprocess.run(
                ["/usr/bin/env", "python3", "-c", _PEAK, *command, str(file), "-o", f"{folder}/out.png"],
                env=env,
                capture_output=True,
                text=True,
                check=True,
            )
            print(f"{file.name:36} {first:8.2f} {again:8.2f} {json.loads(memory.stdout):9.0f}", flush=True)


_PEAK = (
    "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=False); "
    "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)"
)


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/bench", description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, help="models; default: a set from TRIMRAY_MODELS")
    parser.add_argument("--repeat", type=int, help="runs a figure; default: 3, of meshes 5")
    parser.add_argument("--skip-processes", action="store_true", help="leave out the whole-process table")
    parser.add_argument(
        "--deviations",
        type=float,
        nargs="+",
        default=mesh.DEVIATIONS,
        help="of meshes, parts of the diagonal",
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=levels.SIZES, help="of pictures, px")
    parser.add_argument("--zooms", type=float, nargs="+", default=levels.ZOOMS)
    parser.add_argument("--pixels", type=float, nargs="+", default=levels.PIXELS, help="deviations, px")
    parser.add_argument("--time-limit", type=float, default=300.0, help="seconds for BRepMesh's child")
    arguments = sys.argv[1:]
    if arguments[:1] == ["distance"]:
        distance.main(arguments[1:], MODELS)
        return 0
    if arguments[:1] == ["hybrid"]:
        return hybrid.main(arguments[1:])
    if arguments[:1] == ["workers"]:
        return workers.main(arguments[1:])
    if arguments[:1] == ["batch"]:
        return batch.main(arguments[1:])
    table = arguments[0] if arguments[:1] in (["mesh"], ["levels"]) else ""
    args = parser.parse_args(arguments[bool(table) :])
    default = {"mesh": mesh.SET, "levels": levels.SET}.get(table, SET)
    files = args.files or [MODELS / name for name in default]
    files = [f for f in files if f.is_file()]
    if not files:
        print(f"no models in {MODELS}; set TRIMRAY_MODELS or name files", file=sys.stderr)
        return 2
    print(f"trimray {trimray.__version__}, {os.cpu_count()} cores\n")
    if table == "mesh":
        mesh.table(files, list(args.deviations), args.repeat or 5, args.time_limit)
        return 0
    if table == "levels":
        levels.table(files, args.sizes, args.zooms, args.pixels, args.repeat or 3)
        return 0
    import_table(files, args.repeat or 3)
    if not args.skip_processes:
        second_render(files, args.repeat or 3)
    return 0


if __name__ == "__main__":
    sys.exit(main())
