"""A stand-in for the pool of a batch, and what is asked of a run that used it."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from trimray.batch import Item, Listener, Outcome, Settings, Summary
from trimray.batch.state import Row, State


class Drawer:
    """Writes the bytes of the input as its picture. A file's first word says what becomes of it."""

    def __init__(self) -> None:
        self.paths: list[str] = []
        self.stop_after: int | None = None
        self.closed = False

    def __call__(self, items: Iterable[Item], settings: Settings) -> Iterator[Outcome]:
        try:
            for item in items:
                if self.stop_after == 0:
                    raise KeyboardInterrupt
                if self.stop_after is not None:
                    self.stop_after -= 1
                self.paths.append(item.path)
                yield self.outcome(item)
        finally:
            self.closed = True

    @property
    def names(self) -> list[str]:
        """Of what was drawn since the last time."""
        names, self.paths = [os.path.basename(path) for path in self.paths], []
        return sorted(names)

    def outcome(self, item: Item) -> Outcome:
        try:
            data = Path(item.path).read_bytes()
        except OSError as error:
            return Outcome(item.path, item.target, "failed", 3, f"{item.path}: {error.strerror}")
        sha256 = hashlib.sha256(data).hexdigest()
        word = data.split()[0]
        if word == b"crash":
            return Outcome(item.path, item.target, "failed", 70, "crashed")
        if word == b"bad":
            return Outcome(item.path, item.target, "failed", 3, "no model", sha256)
        if word == b"full":
            return Outcome(item.path, item.target, "failed", 4, "not written", sha256)
        Path(item.target).parent.mkdir(parents=True, exist_ok=True)
        Path(item.target).write_bytes(data)
        if word == b"degraded":
            return Outcome(item.path, item.target, "degraded", 1, "coarse", sha256)
        return Outcome(item.path, item.target, "complete", 0, "", sha256, 0.1, 1000, 6, 0, 0.5)


class Told(Listener):
    def __init__(self) -> None:
        self.total = 0
        self.was_drawn: list[Outcome] = []
        self.was_skipped: list[Outcome] = []
        self.notes: list[str] = []

    def begin(self, total: int) -> None:
        self.total = total

    def drawn(self, outcome: Outcome) -> None:
        self.was_drawn.append(outcome)

    def skipped(self, outcome: Outcome) -> None:
        self.was_skipped.append(outcome)

    def note(self, text: str) -> None:
        self.notes.append(text)


def rows(summary: Summary) -> dict[str, Row]:
    with State(summary.state) as state:
        return {os.path.basename(row.path): row for row in state.rows(summary.run)}
