"""Fills the freedesktop thumbnail cache of whole folders, with the pool of a batch."""

from __future__ import annotations

import contextlib
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from trimray import EmptyError, OutputError
from trimray.batch.record import Item, Outcome, Settings
from trimray.batch.run import NOTHING_FOUND, Listener, closing, exit_code

from .entries import (
    SIZES,
    Original,
    cache_folder,
    failure_folder,
    failure_of,
    is_current,
    make_private,
    write_failure,
)

if TYPE_CHECKING:
    from trimray.batch.draw import Picture

# Draws items in worker processes, as trimray.batch.pool.draw_all does; outcomes in any order.
DrawAll = Callable[..., Iterator[Outcome]]


@dataclass
class Filled:
    """What it came to. total: files found, and folders that could not be searched. current: had an entry of
    this very state, skipped: failed in this very state before. statuses: how many of those tried now."""

    total: int = 0
    current: int = 0
    skipped: int = 0
    seconds: float = 0.0
    exit_code: int = 0
    statuses: Counter[str] = field(default_factory=Counter)


def fill_cache(
    paths: Sequence[str],
    size: str = "large",
    *,
    workers: int = 0,
    time_limit: float | None = 30.0,
    memory_limit: int | None = 2 << 30,
    listener: Listener | None = None,
    draw_all: DrawAll | None = None,
) -> Filled:
    """A thumbnail of every model in the files and folders.

    size: of SIZES. workers: processes; 0 for one a core. Limits as of a batch. Valid entries are left alone,
    also those of other programs; so are our failures, until the file or the version changes. Raises
    OutputError where the cache cannot be written, UsageError.
    """
    from trimray.batch.find import find

    if draw_all is None:
        from trimray.batch import pool

        draw_all = pool.draw_all
    start = time.monotonic()
    listener = listener or Listener()
    cache = cache_folder()
    pictures, failures = os.path.join(cache, size), failure_folder(cache)
    make_private(pictures)
    make_private(failures)
    found = find(paths)
    filled = Filled(total=len(found.files) + len(found.failures))
    listener.begin(filled.total)
    codes: set[int] = set()
    for failure in found.failures:
        _count(failure, filled, codes)
        listener.drawn(failure)
    settings = Settings(
        size=(SIZES[size], SIZES[size]),
        background="transparent",
        time_limit=time_limit,
        memory_limit=memory_limit,
    )
    # As they were when they were given away: a failure is that of this state.
    originals: dict[str, Original] = {}
    files = (file.path for file in found.files)
    items = _items(files, pictures, failures, originals, filled, codes, listener)
    count = workers or len(os.sched_getaffinity(0))
    with closing(draw_all(items, settings, count, draw=draw_thumbnail)) as outcomes:
        for outcome in outcomes:
            _note_failure(outcome, originals.pop(outcome.path, None), failures)
            _count(outcome, filled, codes)
            listener.drawn(outcome)
    filled.seconds = time.monotonic() - start
    filled.exit_code = exit_code(codes) if filled.total else NOTHING_FOUND
    return filled


def _items(
    paths: Iterable[str],
    pictures: str,
    failures: str,
    originals: dict[str, Original],
    filled: Filled,
    codes: set[int],
    listener: Listener,
) -> Iterator[Item]:
    """Those that have no entry of any kind, as workers fall free."""
    for path in paths:
        try:
            original = Original.of(path)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            outcome = Outcome(path, "", "failed", exit_code=3, reason=reason)
            _count(outcome, filled, codes)
            listener.drawn(outcome)
            continue
        target = os.path.join(pictures, original.name)
        if is_current(target, original):
            filled.current += 1
            codes.add(0)
            listener.skipped(Outcome(path, target, "complete"))
        elif is_current(failure := os.path.join(failures, original.name), original):
            code, reason = failure_of(failure)
            filled.skipped += 1
            codes.add(code)
            listener.skipped(Outcome(path, target, "failed", exit_code=code, reason=reason))
        else:
            originals[path] = original
            yield Item(path, target, original.size)


def _count(outcome: Outcome, filled: Filled, codes: set[int]) -> None:
    filled.statuses[outcome.status] += 1
    codes.add(outcome.exit_code)


def _note_failure(outcome: Outcome, original: Original | None, folder: str) -> None:
    """An entry for what failed, none for what did not. What was no fault of the file, or may be mended
    without a change of it, is tried again."""
    if original is None:
        return
    path = os.path.join(folder, original.name)
    if outcome.status != "failed":
        with contextlib.suppress(OSError):
            os.unlink(path)
    elif (
        outcome.exit_code != OutputError.exit_code
        and os.path.isfile(outcome.path)
        and os.access(outcome.path, os.R_OK)
    ):
        write_failure(path, original, outcome.exit_code, outcome.reason)


def draw_thumbnail(item: Item, settings: Settings) -> Outcome:
    """Draws one file into the cache; in a worker. Never raises for the file's sake."""
    from trimray.batch.draw import draw_file

    try:
        original = Original.of(item.path)  # as it is before it is read
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        return Outcome(item.path, item.target, "failed", exit_code=3, reason=reason)
    return draw_file(item, settings, write=partial(_write, original))


def _write(original: Original, item: Item, picture: Picture, settings: Settings) -> None:
    """A picture that shows nothing is a failure: a file manager then keeps its icon. Raises EmptyError,
    OutputError."""
    from trimray.image_io import encode, write_file

    if picture.visible.blank:
        raise EmptyError(picture.visible.reason)
    write_file(item.target, encode(picture.frame, "png", text=original.keys()), mode=0o600)
