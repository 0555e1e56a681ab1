"""Runs a render in a thread of its own, so that the caller's thread hears Ctrl-C, the clock and the
progress."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TypeVar

from . import _core
from .importer.errors import TimeLimitError

T = TypeVar("T")

_LOOK_SECONDS = 0.05


def run_watched(
    work: Callable[[_core.Progress], T],
    tiles: _core.Progress,
    time_limit: float | None,
    progress: Callable[[str, float | None], None] | None,
) -> T:
    """work(tiles), its errors included. Raises TimeLimitError; whatever interrupts the wait also stops the
    work."""
    done: list[T] = []
    failed: list[BaseException] = []

    def target() -> None:
        try:
            done.append(work(tiles))
        except BaseException as error:
            failed.append(error)
        finally:
            finished.set()

    # An event rather than join: an interrupted join takes the thread for ended (bugs.python.org/issue45274).
    finished = threading.Event()
    thread = threading.Thread(target=target, name="trimray-render", daemon=True)
    deadline = None if time_limit is None else time.monotonic() + time_limit
    thread.start()
    try:
        ended = False
        while not ended:
            ended = finished.wait(_LOOK_SECONDS)
            if progress is not None:  # at least once, however quick the work
                total = tiles.total
                progress("trace" if total else "hierarchy", tiles.done / total if total else None)
            if deadline is not None and time.monotonic() > deadline and not ended:
                raise TimeLimitError(f"rendering took longer than {time_limit:g} s")
    except BaseException:
        tiles.cancel()
        finished.wait()
        raise
    finally:
        thread.join()
    if failed:
        raise failed[0]
    return done[0]
