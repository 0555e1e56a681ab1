"""`python -m tests.bench.pools`: a hundred good files and bad ones among them, in this pool and in pebble's.

Needs pebble, which is no part of the product (docs/decisions/0007-batch-pool.md).
"""

from __future__ import annotations

import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import wait
from pathlib import Path

from trimray.batch.pool import draw_all
from trimray.batch.record import Item, Settings

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "batch"))
import misbehaving_draw

BAD = ("segfault", "abort", "hang", "deaf", "exit0", "exit7", "raise", "unspeakable", "killed", "killedonce")
LIMIT, PATIENCE = 3.0, 90.0


def items(bad: tuple[str, ...], folder: str) -> list[Item]:
    names = [f"good-{n}" for n in range(100)]
    for at, name in enumerate(bad):
        names.insert(3 + 7 * at, f"{name}-")
    return [Item(f"/nowhere/{name}", f"{folder}/{name}", 20) for name in names]


def ours(work: list[Item]) -> Iterator[tuple[str, str]]:
    for outcome in draw_all(work, Settings(time_limit=LIMIT), 2, draw=misbehaving_draw.draw):
        yield outcome.path, outcome.status


def pebble(work: list[Item]) -> Iterator[tuple[str, str]]:
    from pebble import ProcessPool

    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["misbehaving_draw"])
    pool = ProcessPool(max_workers=2, context=context)
    try:
        futures = {}
        for item in work:
            job = (item, Settings())
            futures[pool.schedule(misbehaving_draw.draw, args=job, timeout=LIMIT)] = item.path
        done, lost = wait(futures, timeout=PATIENCE)
        for future in done:
            yield futures[future], "complete" if future.exception() is None else "failed"
        for future in lost:
            yield futures[future], "lost"
    finally:
        pool.stop()
        pool.join()


def main(folder: str) -> int:
    pools: dict[str, Callable[[list[Item]], Iterator[tuple[str, str]]]] = {"ours": ours, "pebble": pebble}
    for bad in ((), *((name,) for name in BAD), BAD):
        for name, run in pools.items():
            for left in Path(folder).iterdir():
                left.unlink()
            start = time.perf_counter()
            try:
                results = dict(run(items(bad, folder)))
            except Exception as error:
                print(f"{name:8} {type(error).__name__}: {error}")
                continue
            good = Counter(status for path, status in results.items() if "good-" in path)
            rest = {p.rpartition("/")[2]: s for p, s in results.items() if "good-" not in p}
            what = bad[0] if len(bad) == 1 else f"{len(bad)} bad"
            told = ", ".join(f"{n}{s}" for n, s in rest.items()) if len(bad) < 2 else ""
            print(
                f"{name:8} {what:12} {time.perf_counter() - start:6.1f} s  good ones {dict(good)} {told}",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as scratch:
        sys.exit(main(scratch))
