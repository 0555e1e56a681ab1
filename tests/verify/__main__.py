"""The full runs: `scripts/verify closed-forms|reference|parity|opencascade|mesh|hybrid|fidelity|...`"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import trimray
from tests.bench.hybrid_scenes import SCENES

from . import (
    batch,
    closed_forms,
    contact_sheet,
    defects,
    fidelity,
    hybrid,
    mesh,
    opencascade,
    parity,
    reference,
)

ROOT = Path(__file__).resolve().parents[2]


def _models(args: argparse.Namespace) -> list[Path]:
    folder = Path(os.environ.get("TRIMRAY_MODELS", ROOT.parent / "shared" / "models"))
    files = [*contact_sheet.models_in(ROOT / "samples")]
    if folder.is_dir():
        files += contact_sheet.models_in(folder)
    return [f for f in files if args.only in str(f)]


def _loaded(args: argparse.Namespace) -> Iterator[tuple[str, trimray.Model]]:
    for file in _models(args):
        try:
            model = trimray.load(file)
            _ = model.bounds  # a model without a face that can be drawn has none
            yield file.name, model
        except trimray.Error as error:
            print(f"{file.name:44} {error}")


def run_closed_forms(args: argparse.Namespace) -> int:
    print(f"{'scene':24} {'rays':>9} {'wrong':>6} {'worst |dt|':>12}")
    wrong = 0
    for scene in closed_forms.scenes():
        if args.only in scene.name:
            n = args.rays if "torus" not in scene.name else min(args.rays, 24)  # the judge is slow there
            r = closed_forms.check(scene, n, args.mode)
            wrong += r.wrong
            print(f"{r.name:24} {r.rays:9} {r.wrong:6} {r.worst:12.2e}", flush=True)
    return wrong


def run_reference(args: argparse.Namespace) -> int:
    print(
        f"{'model':44} {'rays':>7} {'hits':>7} {'knife':>6} {'in face':>7} {'band':>5} {'coinc.':>6} "
        f"{'unexplained':>11} {'s':>6}"
    )
    wrong = 0
    for name, model in _loaded(args):
        start = time.perf_counter()
        r = reference.check(model, args.rays)
        wrong += len(r.unexplained)
        print(
            f"{name:44} {r.rays:7} {r.hits:7} {r.knife_edge:6} {r.edge_on:7} {r.band:5} {r.coincident:6} "
            f"{len(r.unexplained):11} {time.perf_counter() - start:6.1f}",
            flush=True,
        )
        for line in r.unexplained[: args.show]:
            print("   ", line)
    return wrong


def run_parity(args: argparse.Namespace) -> int:
    print(f"{'model':44} {'solids':>6} {'rays':>9} {'odd':>5}")
    total = odd = 0
    for name, model in _loaded(args):
        r = parity.check(model, args.rays)
        total, odd = total + r.rays, odd + r.odd
        note = "" if r.solids else "  (not closed)"
        print(f"{name:44} {r.solids:6} {r.rays:9} {r.odd:5}{note}", flush=True)
    print(f"{'all':44} {'':6} {total:9} {odd:5}")
    return odd


def run_opencascade(args: argparse.Namespace) -> int:
    wrong = 0
    for file in _models(args):
        if file.suffix.lower() not in (".step", ".stp", ".igs", ".iges"):
            continue
        try:
            classes = opencascade.check(file, args.rays)
        except trimray.Error as error:
            print(f"{file.name:44} {error}")
            continue
        wrong += classes["ours wrong"]
        print(f"{file.name:44}", dict(classes), flush=True)
    return wrong


def run_mesh(args: argparse.Namespace) -> int:
    print(mesh.HEADER)
    wrong = 0
    for file in _models(args):
        try:
            model = trimray.load(file)
            rows = mesh.check(file, model, list(args.deviations), args.time_limit, args.rays)
        except trimray.Error as error:
            print(f"{file.name:44} {error}")
            continue
        for fraction, ours, theirs in rows:
            print(mesh.line(file.name, "ours", fraction, ours))
            print(mesh.line("", "occt", fraction, theirs), flush=True)
            if isinstance(ours, mesh.Judgement):
                wrong += ours.wrong
                for note in ours.notes[: args.show]:
                    print("   ", note, flush=True)
    print(f"{wrong} wrong")
    return wrong


def run_hybrid(args: argparse.Namespace) -> int:
    files = [s.file for s in SCENES if args.only in s.name and s.file.is_file()] or _models(args)
    print(f"hybrid against standard, seeds of {', '.join(hybrid.backends()) or 'no backend'}")
    planes = "".join(f" {name:>8}" for name in hybrid.PLANES)
    print(f"{'model':44} {'pictures':>8} {'pixels':>10} {'covered':>10}{planes} {'s':>6}")
    wrong = 0
    for file in files:
        start = time.perf_counter()
        try:
            r = hybrid.check(trimray.load(file), args.rays, args.views)
        except trimray.Error as error:
            print(f"{file.name:44} {error}")
            continue
        wrong += sum(r.differ.values())
        counts = "".join(f" {r.differ[name]:8}" for name in hybrid.PLANES)
        print(
            f"{file.name:44} {r.pictures:8} {r.pixels:10} {r.covered:10}{counts} "
            f"{time.perf_counter() - start:6.1f}",
            flush=True,
        )
        if r.first:
            print("   ", r.first, dict(r.by_seeds), flush=True)
    print(f"{wrong} pixels differ")
    return wrong


def run_fidelity(args: argparse.Namespace) -> int:
    fidelity.preload()
    print(fidelity.HEADER)
    wrong = 0
    for file in sorted(_models(args), key=lambda f: f.stat().st_size):
        for via in args.via:
            try:
                r = fidelity.check(file, via, points=args.rays, time_limit=args.time_limit)
            except trimray.Error as error:
                print(fidelity.unreadable(file, error), flush=True)
                break
            wrong += len(r.failures)
            print(fidelity.line(r), flush=True)
            for reason in sorted({known.reason for _, known in r.explained}):
                count = sum(known.reason == reason for _, known in r.explained)
                print(f"    {count} explained: {reason}", flush=True)
            for failure in r.failures[: args.show]:
                print(f"    {failure}", flush=True)
    print(f"{wrong} failures")
    return wrong


def run_defects(args: argparse.Namespace) -> int:
    fidelity.preload()
    every = sorted(_models(args), key=lambda f: f.stat().st_size)
    return defects.run(every if args.only else defects.files(every), args.show)


def run_batch(args: argparse.Namespace) -> int:
    return batch.check(args.rays, args.show, args.folder)


def run_sheet(args: argparse.Namespace) -> int:
    out = Path(args.output)
    out.parent.mkdir(parents=True, exist_ok=True)
    for file, why in contact_sheet.make(_models(args), out):
        print(f"{file.name:44} {why}")
    print(f"The sheet is in {out}")
    return 0


COMMANDS = {
    "closed-forms": (run_closed_forms, 64, "first hits against closed forms"),
    "reference": (run_reference, 40, "the fast tracer against the reference tracer"),
    "parity": (run_parity, 2, "even counts on closed solids"),
    "opencascade": (run_opencascade, 40, "against OpenCascade's ray caster"),
    "mesh": (run_mesh, 20000, "closed, manifold and as near as proven, beside BRepMesh"),
    "hybrid": (run_hybrid, 128, "the hybrid tracer against the standard one, bit by bit; rays: picture side"),
    "fidelity": (run_fidelity, 6000, "round trips of the store lose nothing; rays: points on each model"),
    "defects": (run_defects, 0, "defects planted into real models are found, and nothing else is"),
    "batch": (run_batch, 400, "hostile files: named, isolated, and the same after kill -9; rays: mutants"),
    "sheet": (run_sheet, 0, "a contact sheet of all models"),
}


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/verify", description=__doc__)
    sub = parser.add_subparsers(dest="command", required=True)
    for name, (_, rays, text) in COMMANDS.items():
        p = sub.add_parser(name, help=text)
        p.add_argument("--rays", type=int, default=rays, help="rays per view side, view or target; triangles")
        p.add_argument("--only", default="", help="models or scenes whose name holds this")
        p.add_argument("--mode", default="standard", choices=("standard", "reference"))
        p.add_argument("--show", type=int, default=3, help="unexplained rays to print per model")
        p.add_argument("--deviations", type=float, nargs="+", default=(1e-2, 1e-3), help="of the diagonal")
        p.add_argument("--time-limit", type=float, default=300.0, help="seconds for BRepMesh's child")
        p.add_argument("--via", nargs="+", default=["step"], choices=("step", "brep"), help="of fidelity")
        p.add_argument("--views", type=int, default=26, help="of the hybrid tracer's 26")
        p.add_argument("--output", default="out/sheet.png")
        p.add_argument("--folder", help="for the files of a batch; by default one that is removed")
    args = parser.parse_args()
    return 1 if COMMANDS[args.command][0](args) else 0


if __name__ == "__main__":
    sys.exit(main())
