"""The hybrid tracer beside its baselines, scene by scene: `scripts/bench hybrid`.

    scripts/bench hybrid [NAME...] [--sizes 512 1024] [--zooms 1 10] [--repeat 5] [--json FILE]

Times are medians of turns that all contenders take in one process (tests/bench/hybrid_bench.cpp, built into
build/bench when needed): processor time at one thread, wall time with all cores. All give t, face, instance,
uv and normal of one ray a pixel. standard: our own best. hybrid: the fastest way to seeds, the raster pass
included (mesh at hand); which one stands in the last column. paper: many small boxes, packets of 2 x 2 rays
or single rays, whichever is faster. Embree: packets through a mesh no farther than 0.1 px from its surface.
Every ratio is that baseline's time divided by the hybrid tracer's.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import trimray

from .hybrid_scenes import ROOT, SCENES, Scene, View, framed, magnified

Result = dict[str, Any]

HEADER = (
    f"{'scene':15} {'px':>5} {'zoom':>4} {'cover':>6} {'std ms':>8} {'hyb ms':>8} {'x std':>6} "
    f"{'all thr':>7} {'paper ms':>8} {'x paper':>7} {'Embree':>8} {'x Embr':>6} "
    f"{'edge':>6} {'open':>6} {'steps':>5} {'calls':>5} {'Mpx/s':>6} {'differ':>6}  hybrid with"
)


def program() -> Path:
    """Builds hybrid_bench as the sources are now; quick when nothing has changed."""
    folder = ROOT / "build" / "bench"
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DTRIMRAY_BENCH=ON", "-DTRIMRAY_PYTHON=OFF"]
    quiet = {"check": True, "stdout": subprocess.DEVNULL}
    subprocess.run(["cmake", "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", *options], **quiet)  # type: ignore[call-overload]
    subprocess.run(["cmake", "--build", str(folder), "--target", "hybrid_bench"], **quiet)  # type: ignore[call-overload]
    return folder / "tests" / "bench" / "hybrid_bench"


def measure(exe: Path, store: Path, view: View, repeat: int, options: list[str]) -> Result:
    command = [str(exe), str(store), "--camera", view.numbers(), "--repeat", str(repeat), *options]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    result: Result = json.loads(done.stdout)
    return result


def totals(times: dict[str, float]) -> dict[str, float]:
    """Milliseconds of each way to a hybrid picture, by the name of what gives the seeds."""
    found = {"no seeds": times["hybrid"]} if "hybrid" in times else {}
    for name, ms in times.items():
        if name.startswith("hybrid_"):
            of = name.removeprefix("hybrid_")
            found[of.replace("_", " ")] = ms + times["raster_" + of]
    return found


def figures(r: Result, seeds: str) -> dict[str, float]:
    """What the table shows, for the hybrid tracer with these seeds."""
    cpu, wall = r["cpu_ms"], r["wall_ms"]
    name = "hybrid" if seeds == "no seeds" else "hybrid_" + seeds.replace(" ", "_")
    s = r["stats"][name]
    covered = max(r["covered"], 1)
    hybrid, hybrid_all = totals(cpu)[seeds], totals(wall)[seeds]
    return {
        "cover": r["covered"] / r["pixels"],
        "standard": cpu["standard"],
        "hybrid": hybrid,
        "ratio": cpu["standard"] / hybrid,
        "ratio_all": wall["standard"] / hybrid_all,
        "paper": min(cpu["paper4"], cpu["paper1"]),
        "ratio_paper": min(cpu["paper4"], cpu["paper1"]) / hybrid,
        "embree": cpu.get("embree", float("nan")),
        "ratio_embree": cpu.get("embree", float("nan")) / hybrid,
        "edge": s["edge_rays"] / covered,
        "open": s["open"] / covered,
        "steps": s["newton_steps"] / s["newton_roots"] if s["newton_roots"] else float("nan"),
        "calls": s["solves"] / covered,
        "rate": r["covered"] / hybrid * 1e-3,
        "differ": max(n for key, n in r["differ"].items() if key != "embree_face"),
    }


def line(scene: str, size: int, zoom: float, f: dict[str, float], seeds: str) -> str:
    return (
        f"{scene:15} {size:5} {zoom:4g} {f['cover']:6.1%} {f['standard']:8.2f} {f['hybrid']:8.2f} "
        f"{f['ratio']:6.2f} {f['ratio_all']:7.2f} {f['paper']:8.2f} {f['ratio_paper']:7.2f} "
        f"{f['embree']:8.2f} {f['ratio_embree']:6.2f} {f['edge']:6.2%} {f['open']:6.2%} {f['steps']:5.2f} "
        f"{f['calls']:5.2f} {f['rate']:6.2f} {f['differ']:6.0f}  {seeds}"
    )


def missed(scene: Scene, size: int, zoom: float, f: dict[str, float]) -> list[str]:
    """The goals that these figures do not reach."""
    much = f["cover"] >= 0.15
    goals = [
        ("x standard, 1 thread", f["ratio"], 2.0 if much else 1.0),
        ("x standard, all threads", f["ratio_all"], 1.7 if much else 1.0),
        ("x the paper's way", f["ratio_paper"], 5.0 if much else 1.0),
        ("Newton steps", -f["steps"], -2.0),
        ("calls a covered pixel", -f["calls"], -1.05),
        ("share traced through the hierarchy", -f["edge"], -0.02),
        ("pixels that differ", -f["differ"], 0.0),
        ("M covered px/s/core", f["rate"], scene.rate if zoom == 1 else 0.0),
    ]
    if size == 512:
        goals.append(("x Embree", f["ratio_embree"], 1.0))
    # Not a number: not measured.
    return [f"{text} {abs(value):.3g}, goal {abs(goal):g}" for text, value, goal in goals if value < goal]


def table(
    names: list[str], sizes: list[int], zooms: list[float], repeat: int, options: list[str], out: Path | None
) -> int:
    exe = Path(os.environ["TRIMRAY_HYBRID_BENCH"]) if "TRIMRAY_HYBRID_BENCH" in os.environ else program()
    scenes = [s for s in SCENES if s.file.is_file() and (not names or s.name in names)]
    if not scenes:
        print(f"no scene; there are {', '.join(s.name for s in SCENES)}")
        return 2
    everything, misses = [], []
    print(HEADER)
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "store"
        for scene in scenes:
            model = trimray.load(scene.file)
            store.write_bytes(model._core.save())
            for size in sizes:
                for zoom in zooms:
                    if zoom != 1 and size != sizes[0]:
                        continue
                    view = framed(scene, model, size)
                    if zoom != 1:
                        view = magnified(model, view, zoom)
                    r = measure(exe, store, view, repeat, options)
                    ways = totals(r["cpu_ms"])
                    seeds = min(ways, key=ways.__getitem__)
                    f = figures(r, seeds)
                    print(line(scene.name, size, zoom, f, seeds), flush=True)
                    misses += [f"{scene.name} {size} x{zoom:g}: {m}" for m in missed(scene, size, zoom, f)]
                    everything.append({"scene": scene.name, "size": size, "zoom": zoom, **r})
    print(f"\n{len(misses)} goals missed")
    for miss in misses:
        print("  ", miss)
    if out is not None:
        out.write_text(json.dumps(everything, indent=1) + "\n")
    return 0


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="scripts/bench hybrid", description=__doc__)
    parser.add_argument("names", nargs="*", help="scenes; default: all")
    parser.add_argument("--sizes", type=int, nargs="+", default=[512, 1024], help="of pictures, px")
    parser.add_argument("--zooms", type=float, nargs="+", default=[1.0, 10.0], help="at the first size")
    parser.add_argument("--repeat", type=int, default=5, help="turns")
    parser.add_argument("--skip", default="egl", help="contenders to leave out, as a,b")
    parser.add_argument("--seed-px", type=float, default=1.5, help="deviation of the mesh that seeds")
    parser.add_argument("--tile", type=int, default=32, help="px")
    parser.add_argument("--json", type=Path, help="writes all figures of all contenders")
    args = parser.parse_args(arguments)
    options = ["--skip", args.skip, "--seed-px", str(args.seed_px), "--tile", str(args.tile)]
    return table(args.names, args.sizes, args.zooms, args.repeat, options, args.json)
