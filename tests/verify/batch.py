"""A batch on a library of more than a thousand hostile files, undisturbed, killed, and interrupted."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from tests.batch.torture import library
from tests.batch.torture.judge import judge, out_of_time, table
from tests.batch.torture.runs import SIZE, Setup, disturbed, singles, undisturbed, unlike_singles
from tests.batch.torture.sources import models_folder

_PATIENCE = 3600.0
# How a run ends before it is gone on with, and when: share of the pictures.
_DISTURBED = (("group", 0.43), ("supervisor", 0.71), ("SIGINT", 0.18), ("SIGTERM", 0.9))
_SAMPLE = 60


def check(mutants: int, show: int, folder: str | None = None) -> int:
    """Prints what was found; returns the number of problems. folder: for all files; kept when given."""
    if models_folder() is None:
        print("TRIMRAY_MODELS names no folder: the library is made from the samples alone")
    with tempfile.TemporaryDirectory(prefix="torture-") as scratch:
        place = Path(folder or scratch)
        start = time.perf_counter()
        entries = library.build(place / "library", mutants=mutants)
        library.save(entries, place / "library.json")
        print(f"{len(entries)} files made in {time.perf_counter() - start:.0f} s", flush=True)
        setup = Setup(place / "library", place, entries, limits=("30", "2G"))
        return _check(setup, show)


def _check(setup: Setup, show: int) -> int:
    problems = 0

    def tell(what: str, found: list[str], start: float) -> None:
        nonlocal problems
        problems += len(found)
        print(f"{what}: {len(found)} unexpected, {time.perf_counter() - start:.0f} s", flush=True)
        for line in found[:show]:
            print("   ", line.encode("utf-8", "backslashreplace").decode())

    start = time.perf_counter()
    like = singles(setup.entries, setup.library, setup.folder)
    print(f"{len(like)} models drawn by trimray render, {time.perf_counter() - start:.0f} s", flush=True)
    start = time.perf_counter()
    done, found = undisturbed(setup, "whole", _PATIENCE)
    tell("the run", found, start)
    print(done.err.decode(errors="backslashreplace").splitlines()[-1])
    rows = setup.rows("whole")
    verdict = judge(setup.entries, rows, setup.output("whole"), SIZE, like=like)
    tell("files", verdict.problems, start)
    print(f"{len(out_of_time(rows))} files ran out of time: they are left out where runs are compared")
    print(table(verdict))
    start = time.perf_counter()
    found, count = unlike_singles(setup, rows, _SAMPLE, seed=1)
    tell(f"{count} mutants beside trimray render", found, start)
    for how, share in _DISTURBED:
        start = time.perf_counter()
        found, again = disturbed(setup, how, "whole", how, share, _PATIENCE)
        tell(f"{how} at {share:.0%}, then --resume ({again} pictures made again)", found, start)
    print(f"{problems} unexpected")
    return problems
