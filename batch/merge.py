"""Joins what the shards of a batch know into one state."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, replace

from trimray import OutputError, UsageError

from .find import absolute
from .gallery import check_gallery, write_gallery_of_state
from .run import NOTHING_FOUND, Summary
from .shard import Shard, shard_of_state
from .state import State


@dataclass(frozen=True)
class Merged:
    """missing: shards that have left no state. unfinished: those that did not finish."""

    summary: Summary
    missing: list[Shard]
    unfinished: list[Shard]


def merge(output: str, *, gallery: bool = False) -> Merged:
    """Takes the last run of every state `trimray-batch.K-of-N.sqlite` in the folder output as one run of
    `trimray-batch.sqlite`, which is made where it is missing; the states of the shards stay.

    gallery: write index.html, a page of all pictures in output. The exit code is that of the whole, at least
    1 where a shard is missing or did not finish. Raises UsageError where there are no shards, or of several
    divisions; OutputError where a state cannot be used, or the page not be written.
    """
    start = time.perf_counter()
    folder = absolute(output)
    if gallery:
        check_gallery(folder)
    shards = _shards(folder)
    n = shards[0].n
    unfinished: list[Shard] = []
    paths: list[str] = []
    with State(os.path.join(folder, Shard().state_name)) as whole:
        run = whole.begin([], {})
        for shard in shards:
            with State(os.path.join(folder, shard.state_name), create=False) as state, whole.together():
                last = state.last_run()
                if last is None or not last.finished:
                    unfinished.append(shard)
                if last is None:
                    continue
                paths = list(last.paths)
                options = last.options | {"shard": str(Shard())}
                whole.describe(run, paths, options)
                for row in state.rows(last.id):
                    known = whole.row(row.path)
                    if known is not None and known.finished > row.finished:
                        whole.enroll(run, row.path, known.target, pending=False)
                    else:
                        whole.adopt(run, row)
        whole.forget_gone(run)
        whole.finish(run)
        if gallery:
            write_gallery_of_state(folder, whole)
        summary = Summary.of(os.path.join(folder, Shard().state_name), run, whole.counts(run))
    missing = [Shard(k, n) for k in range(1, n + 1) if Shard(k, n) not in shards]
    code = summary.exit_code if summary.total else NOTHING_FOUND
    if (missing or unfinished) and code in (0, NOTHING_FOUND):
        code = 1
    summary = replace(
        summary,
        skipped=summary.total - summary.statuses["pending"],
        seconds=time.perf_counter() - start,
        exit_code=code,
    )
    return Merged(summary, missing, unfinished)


def _shards(folder: str) -> list[Shard]:
    try:
        names = os.listdir(folder)
    except OSError as error:
        raise OutputError(f"{folder}: {error.strerror or error}") from None
    shards = sorted((s for name in names if (s := shard_of_state(name))), key=lambda s: (s.n, s.k))
    if not shards:
        raise UsageError(f"{folder}: no state of a shard, such as {Shard(1, 2).state_name}")
    divisions = sorted({shard.n for shard in shards})
    if len(divisions) > 1:
        several = " and ".join(map(str, divisions))
        raise UsageError(f"{folder}: states of {several} shards: remove those that are out of date")
    return shards
