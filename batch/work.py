"""The files of one run, on their way from its plan through the pool into the state."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace

from trimray import __version__

from .find import File
from .hashing import Hashing, sha256_of
from .leftovers import remove_leftovers
from .plan import Plan
from .record import Item, Outcome, Settings
from .run import Draw, Listener, Summary, closing
from .state import Row, State

_HASH_THREADS = 4
# Most changes are found in this time, before the pool has to be waited for.
_HEAD_START_SECONDS = 0.5


class Work:
    """The files of one run, on their way from the state and back to it."""

    def __init__(self, state: State, run: int, folder: str, settings: Settings, listener: Listener) -> None:
        self.run = run
        self._state, self._folder, self._settings, self._listener = state, folder, settings, listener
        self._key = settings.key()
        self._aims: dict[str, tuple[File, str]] = {}  # by path: what is to be drawn
        self._fresh: list[str] = []
        self._doubtful: list[tuple[File, str, Row]] = []
        self._drawn = self._skipped = 0

    def take(self, planned: Plan, resume: bool, retry_failed: bool) -> None:
        """What is to be drawn, what may be, and what is done; all of it in the state."""
        self._listener.begin(len(planned.files) + len(planned.failures))
        done: list[Row] = []
        with self._state.together():
            for file, target in zip(planned.files, planned.targets, strict=True):
                row = self._state.row(file.path)
                fate = self._fate(row, file, target, resume, retry_failed)
                self._state.enroll(self.run, file.path, target, pending=fate == "draw")
                if fate == "draw":
                    self._aims[file.path] = (file, target)
                    self._fresh.append(file.path)
                elif row is not None and fate == "hash":
                    self._doubtful.append((file, target, row))
                elif row is not None:
                    done.append(row)
            for failure in planned.failures:
                row = self._state.row(failure.path)
                self._record(failure, "", 0, 0, row)
        for failure in planned.failures:
            self._listener.drawn(failure)
            self._drawn += 1
        gone = self._state.forget_gone(self.run)
        for row in gone:
            kept = f"; its picture stays: {row.target}" if row.finished and row.status != "failed" else ""
            self._listener.note(f"{row.path}: no longer there{kept}")
        for row in done:
            self._skip(row)

    def _fate(self, row: Row | None, file: File, target: str, resume: bool, retry_failed: bool) -> str:
        """skip, hash (skip if the bytes are the same), or draw."""
        if row is None or row.status == "pending" or row.settings != self._key or row.version != __version__:
            return "draw"
        if row.exit_code == 4 or (retry_failed and row.status in ("failed", "degraded")):
            return "draw"  # what could not be written is no fault of the file
        if row.status != "failed" and (row.target != target or not self._is_there(target)):
            return "draw"
        same = (row.size, row.mtime_ns) == (file.size, file.mtime_ns) and file.mtime_ns
        # Without a hash it could not be read, which permissions change, and no date tells.
        return "skip" if resume and same and row.sha256 else "hash"

    def _is_there(self, target: str) -> bool:
        try:
            return os.stat(os.path.join(self._folder, target)).st_size > 0
        except OSError:
            return False

    def draw(self, draw: Draw) -> None:
        """First what must be drawn for sure, while threads look which other files changed; then these."""
        with Hashing([file.path for file, _, _ in self._doubtful], _HASH_THREADS) as hashing:
            changed = self._changed(hashing.ready(_HEAD_START_SECONDS))
            if self._fresh:
                changed += self._draw(draw, self._fresh, hashing)
            changed += self._changed(hashing.rest())
            if changed:
                changed.sort(key=lambda path: (-self._aims[path][0].size, path))
                self._draw(draw, changed, hashing)

    def _draw(self, draw: Draw, paths: list[str], hashing: Hashing) -> list[str]:
        """Returns what was found to have changed meanwhile."""
        changed: list[str] = []
        with closing(draw((self._item(path) for path in paths), self._settings)) as outcomes:
            for outcome in outcomes:
                self._finish(outcome)
                changed += self._changed(hashing.ready())
        for path in paths:
            if path in self._aims:
                self._finish(self._lost(path))
        return changed

    def _changed(self, hashed: Iterable[tuple[int, str]]) -> list[str]:
        return [path for k, sha256 in hashed if (path := self._judge(k, sha256))]

    def _item(self, path: str) -> Item:
        file, target = self._aims[path]
        return Item(path, os.path.join(self._folder, target), file.size)

    def _lost(self, path: str) -> Outcome:
        item = self._item(path)
        reason = "internal error: nothing was heard of this file"
        return Outcome(item.path, item.target, "failed", exit_code=70, reason=reason)

    def _judge(self, k: int, sha256: str) -> str | None:
        """The path of a file whose bytes changed; another one is skipped."""
        file, target, row = self._doubtful[k]
        if sha256 == row.sha256:
            if (row.size, row.mtime_ns) != (file.size, file.mtime_ns):
                self._state.touch(file.path, file.size, file.mtime_ns)
            self._skip(row)
            return None
        self._aims[file.path] = (file, target)
        self._state.enroll(self.run, file.path, target, pending=True)
        return file.path

    def _skip(self, row: Row) -> None:
        outcome = row.outcome(self._folder)
        assert outcome is not None
        self._skipped += 1
        self._listener.skipped(outcome)

    def _finish(self, outcome: Outcome) -> None:
        """Into the state, then to the listener."""
        if outcome.path not in self._aims:
            return  # told twice
        file, target = self._aims.pop(outcome.path)
        for shown in (outcome.path, " ".join(outcome.path.split())):
            outcome = replace(outcome, reason=outcome.reason.removeprefix(f"{shown}: "))
        if not outcome.sha256 and outcome.exit_code != 3:  # the process that read it is gone
            outcome = replace(outcome, sha256=sha256_of(file.path))
        row = self._state.row(file.path)
        if outcome.status == "failed" and row is not None and row.finished:
            self._remove_stale(target)
        self._record(outcome, target, file.size, file.mtime_ns, row)
        self._drawn += 1
        self._listener.drawn(outcome)

    def _remove_stale(self, target: str) -> None:
        """A picture that an earlier run made shows what the file no longer is."""
        try:
            os.unlink(os.path.join(self._folder, target))
        except OSError:
            return

    def _record(self, outcome: Outcome, target: str, size: int, mtime_ns: int, row: Row | None) -> None:
        same = row is not None and (row.sha256, row.settings, row.version) == (
            outcome.sha256,
            self._key,
            __version__,
        )
        self._state.record(
            self.run,
            outcome,
            target,
            size=size,
            mtime_ns=mtime_ns,
            settings=self._key,
            attempt=row.attempt + 1 if row is not None and same else 1,
        )

    def clean(self, run: int) -> None:
        """Removes what a killed worker left of the pictures that this run had yet to make."""
        for path in remove_leftovers(self._folder, self._state.pending(run)):
            self._listener.note(f"{path}: half a picture, removed")

    def summary(self, place: str, seconds: float) -> Summary:
        found = Summary.of(place, self.run, self._state.counts(self.run))
        return replace(found, drawn=self._drawn, skipped=self._skipped, seconds=seconds)
