"""`scripts/bench workers`: memory of a worker over hundreds of files, and the processor time of a file.

Memory: one worker that is never renewed draws the files again and again in one order; its resident memory
(RSS), its share of it (PSS) and what is its own (anonymous) after 30 and after 300 files. Time: processor
seconds of the worker and of its reading children, which other load on the machine does not blur, beside what
one `trimray render` takes.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from itertools import cycle, islice
from pathlib import Path

from trimray.batch.pool import draw_all
from trimray.batch.record import Item, Settings

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "batch"))
from measured_draw import measured, seconds

ROOT = Path(__file__).resolve().parents[2]
SUFFIXES = (".step", ".stp", ".igs", ".iges", ".stl", ".brep")
FIRST, LAST = 30, 300


def table(files: list[Path], count: int = LAST, size: int = 256) -> dict[str, float]:
    """Prints the memory; returns each kind's growth from FIRST to the last file, as a ratio."""
    settings = Settings(size=(size, size))
    with tempfile.TemporaryDirectory() as folder:
        items = (Item(str(f), f"{folder}/{n % 8}.png") for n, f in enumerate(islice(cycle(files), count)))
        print(f"{'files':>6} {'RSS MB':>8} {'PSS MB':>8} {'own MB':>8}")
        facts = []
        for outcome in draw_all(items, settings, 1, draw=measured, max_files=None):
            if outcome.reason.startswith("{"):
                facts.append(json.loads(outcome.reason))
            if len(facts) in {1, 3, 10, FIRST, 60, 100, 150, 200, 250, count}:
                row = " ".join(f"{facts[-1][k] / 1e6:8.1f}" for k in ("rss", "pss", "anonymous"))
                print(f"{len(facts):6} {row}", flush=True)
    growth = {k: facts[-1][k] / facts[FIRST - 1][k] for k in ("rss", "pss", "anonymous")}
    print("growth " + " ".join(f"{growth[k]:8.3f}" for k in ("rss", "pss", "anonymous")))
    return growth


def costs(files: list[Path], size: int = 256) -> None:
    """Prints the processor time of each file, in the batch and in a command of its own."""
    settings = Settings(size=(size, size))
    print(f"\n{'file':36} {'worker s':>9} {'reader s':>9} {'alone s':>9} {'ratio':>6}")
    command = [sys.executable, "-m", "trimray.cli", "render", "-q", "--no-cache", "--size", str(size)]
    with tempfile.TemporaryDirectory() as folder:
        items = [Item(str(f), f"{folder}/{n}.png") for n, f in enumerate([files[0], *files])]
        start = time.perf_counter()
        outcomes = list(draw_all(items, settings, 1, draw=measured))[1:]  # the first one warms up
        wall = time.perf_counter() - start
        for outcome in outcomes:
            facts = json.loads(outcome.reason)
            before = seconds()[1]
            subprocess.run([*command, outcome.path, "-o", f"{folder}/alone.png"], check=False)
            alone, both = seconds()[1] - before, facts["own"] + facts["children"]
            name = os.path.basename(outcome.path)
            print(
                f"{name:36} {facts['own']:9.3f} {facts['children']:9.3f} {alone:9.3f} {alone / both:6.1f}",
                flush=True,
            )
    print(f"one worker, wall clock: {len(items) / wall:.1f} files/s")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="scripts/bench workers", description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, help="default: samples and TRIMRAY_MODELS up to 1 MB")
    parser.add_argument("--count", type=int, default=LAST, help="files drawn for the memory")
    parser.add_argument("--skip-costs", action="store_true")
    args = parser.parse_args(arguments)
    files = args.files or default_files()
    print(f"{len(files)} different files, {args.count} in all, one worker that is not renewed")
    growth = table(files, args.count)
    if not args.skip_costs:
        costs([f for f in files if f.stat().st_size < 300_000][:12])
    return 0 if max(growth["rss"], growth["pss"]) <= 1.2 else 1


def default_files() -> list[Path]:
    models = Path(os.environ.get("TRIMRAY_MODELS", ROOT.parent / "shared" / "models"))
    found = [p for folder in (ROOT / "samples", models) for p in sorted(folder.rglob("*"))]
    return [p for p in found if p.suffix.lower() in SUFFIXES and p.stat().st_size < 1_000_000]
