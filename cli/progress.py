"""Progress on stderr: a bar on a terminal for whatever takes over a second, plain lines, or JSON lines."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Protocol

from .output import colored, emit, say

_BAR_AFTER_SECONDS = 1.0
_PLAIN_EVERY_SECONDS = 1.0


class Sink(Protocol):
    """Hears of stages ("parse", "trace", ...) and how far each is (None: not known)."""

    def __call__(self, stage: str, fraction: float | None) -> None: ...


class _Nothing:
    def __call__(self, stage: str, fraction: float | None) -> None:
        pass

    def close(self) -> None:
        pass


class _Plain:
    """A line when the stage changes, and at most one a second."""

    def __init__(self, name: str, as_json: bool) -> None:
        self._name, self._json = name, as_json
        self._stage, self._last = "", 0.0

    def __call__(self, stage: str, fraction: float | None) -> None:
        now = time.monotonic()
        if stage == self._stage and now - self._last < _PLAIN_EVERY_SECONDS:
            return
        self._stage, self._last = stage, now
        if self._json:
            emit("progress", input=self._name, stage=stage, fraction=fraction)
        else:
            say(f"{self._name}: {stage}" + ("" if fraction is None else f" {100 * fraction:.0f} %"))

    def close(self) -> None:
        pass


class _Bar:
    """The bar appears after a second, even while the stage says nothing."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._lock = threading.Lock()
        self._bar: Any = None
        self._task: Any = None
        self._now: tuple[str, float | None] = ("read", None)
        self._timer = threading.Timer(_BAR_AFTER_SECONDS, self._show)
        self._timer.daemon = True
        self._timer.start()

    def __call__(self, stage: str, fraction: float | None) -> None:
        with self._lock:
            self._now = (stage, fraction)
            self._update()

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        with self._lock:
            console = Console(stderr=True, no_color=not colored(sys.stderr))
            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                TextColumn("{task.fields[share]}"),
                TimeElapsedColumn(),
            )
            self._bar = Progress(*columns, console=console, transient=True)
            self._task = self._bar.add_task(self._name, total=None, share="")
            self._bar.start()
            self._update()

    def _update(self) -> None:
        if self._bar is None:
            return
        stage, fraction = self._now
        share = "" if fraction is None else f"{100 * fraction:3.0f} %"
        total = None if fraction is None else 1.0
        self._bar.update(
            self._task,
            description=f"{self._name}: {stage}",
            total=total,
            completed=fraction or 0,
            share=share,
        )

    def close(self) -> None:
        self._timer.cancel()
        if self._timer.is_alive():
            self._timer.join()
        if self._bar is not None:
            self._bar.stop()


@contextmanager
def progress_of(name: str, mode: str, quiet: bool) -> Iterator[Sink]:
    """mode: auto, none, plain or json. name: of the input, shown beside the progress."""
    sink: _Nothing | _Plain | _Bar
    if mode == "auto":
        mode = "bar" if sys.stderr.isatty() and not quiet else "none"
    if mode == "bar":
        sink = _Bar(name)
    elif mode in ("plain", "json"):
        sink = _Plain(name, mode == "json")
    else:
        sink = _Nothing()
    try:
        yield sink
    finally:
        sink.close()
