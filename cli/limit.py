"""One time limit for everything that a command does with one input."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from trimray import TimeLimitError

from .progress import Sink

# Seconds until the clock rings again, should the first time be heard by nobody: enough to clear away before.
_AGAIN = 5.0


class Limited:
    """Progress of limited work, which knows the stage that the limit ends."""

    def __init__(self, limit: float | None, sink: Sink) -> None:
        self._limit, self._sink = limit, sink
        self._end = None if limit is None else time.monotonic() + limit
        self.stage = "start"

    def __call__(self, stage: str, fraction: float | None) -> None:
        self.stage = stage
        self._sink(stage, fraction)

    def left(self) -> float | None:
        """Seconds."""
        return None if self._end is None else max(0.001, self._end - time.monotonic())


@contextmanager
def within(limit: float | None, name: str, sink: Sink) -> Iterator[Limited]:
    """Gives the progress to hand on. When limit (seconds) is over, TimeLimitError is raised in the work,
    which is left as after any other error: child processes end, temporary files go.

    A call of the native core goes on to its end first. In another thread than the main one nothing is raised.
    """
    limited = Limited(limit, sink)
    over = False
    if limit is None or threading.current_thread() is not threading.main_thread():
        yield limited
        return

    def ring(number: int, frame: FrameType | None) -> None:
        if not over:  # else it would keep what is below from putting the clock away
            raise TimeLimitError(f"{name}: not done within {limit:g} s (stopped in stage '{limited.stage}')")

    handler = signal.signal(signal.SIGALRM, ring)
    timer = signal.setitimer(signal.ITIMER_REAL, limited.left() or limit, _AGAIN)
    try:
        yield limited
    finally:
        over = True
        signal.setitimer(signal.ITIMER_REAL, *timer)
        signal.signal(signal.SIGALRM, handler)
