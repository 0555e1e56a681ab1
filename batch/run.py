"""A batch from end to end: finds files, leaves out what is done, has the rest drawn, keeps what became of it."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

from .record import Item, Outcome, Settings

if TYPE_CHECKING:
    from .find import File, Found
    from .shard import Shard
    from .state import Row, State

# Draws items, taken one by one as they are needed; tells of each when it is done, in any order. Closing the
# iterator stops all work at once.
Draw = Callable[[Iterable[Item], Settings], Iterator[Outcome]]

NOTHING_FOUND = 6  # exit code
_HASH_THREADS = 4


class Listener:
    """Hears how a batch goes on; all in the thread that called run. Override what is of interest."""

    def begin(self, total: int) -> None:
        """The files of this run are known."""

    def skipped(self, outcome: Outcome) -> None:
        """A file is what it was when its picture was made, or failed."""

    def drawn(self, outcome: Outcome) -> None:
        """A file was drawn, or failed."""

    def note(self, text: str) -> None:
        """One line that explains something."""


@dataclass
class Summary:
    """What a run came to. total: files of it, and folders that could not be searched; statuses: how many of
    each, "pending" where the run was interrupted; drawn and skipped: which of them were drawn now, and had
    been before; state: path of the state file; run: its number in there."""

    state: str
    run: int
    total: int = 0
    drawn: int = 0
    skipped: int = 0
    seconds: float = 0.0
    exit_code: int = 0
    statuses: Counter[str] = field(default_factory=Counter)

    @property
    def failed(self) -> int:
        return self.statuses["failed"]


def run(
    paths: Sequence[str],
    output: str,
    settings: Settings | None = None,
    *,
    include: Sequence[str] = (),
    template: str | None = None,
    workers: int = 0,
    shard: Shard | None = None,
    resume: bool = False,
    retry_failed: bool = False,
    listener: Listener | None = None,
    draw: Draw | None = None,
) -> Summary:
    """Draws every model under paths into the folder output, which is made where it is missing.

    What was drawn before under the same settings by the same version is left as it is, where the file's bytes
    are the same; failures are not tried again, unless retry_failed is set, which also redoes what is
    degraded. With resume, size and date of a file stand for its bytes; with no paths at all, those of the
    last run are taken, its settings, include and template too where they are not given.

    include, template: as in find and Template. workers: processes; 0 for one a core. shard: only that share
    of the files. draw: by default a pool of processes on this machine.

    Summary.exit_code is what all files have in common, 0 when all are complete, else 1; 6 when no file was
    found. Raises UsageError; OutputError when the folder or the state in it cannot be written;
    KeyboardInterrupt when interrupted, after all work was stopped: nothing that was finished is lost.
    """
    from trimray import OutputError, UsageError
    from trimray.formats import check_fit
    from trimray.views import parse_background

    from .find import absolute, find
    from .shard import Shard
    from .state import State
    from .targets import Template, targets

    start = time.perf_counter()
    shard, listener = shard or Shard(), listener or Listener()
    folder = absolute(output)
    place = os.path.join(folder, shard.state_name)
    if not paths and not resume:
        raise UsageError("missing input: give files or folders")
    if not paths:
        with State(place, create=False) as state:
            last = state.last_run()
        if last is None:
            raise UsageError(f"{place}: no run to go on with")
        paths = last.paths
        settings = settings or settings_of(last.options)
        include = include or last.options["include"]
        template = template or last.options["template"]
    settings = settings or Settings()
    check_fit(settings.format, ("color",), all(c[3] >= 1.0 for c in parse_background(settings.background)))
    form = Template(template, settings.format)
    places = [absolute(path) for path in paths]
    found = find(places, include=include, leave_out=folder)
    aims = targets(found.files, form)
    _check_apart(found.files, aims, places, folder)
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: not made: {error.strerror or error}") from None

    options = asdict(settings) | {"include": list(include), "template": template, "shard": str(shard)}
    with State(place) as state:
        last = state.last_run()
        work = _Work(state, state.begin(places, options), folder, settings, listener)
        if last is not None and not last.finished:
            work.clean(last.id)
        share = [k for k, file in enumerate(found.files) if file.relative in shard]
        work.plan([(found.files[k], aims[k]) for k in share], found, resume, retry_failed)
        empty = not (found.files or found.failures)
        del found, aims, share
        if draw is None:
            draw = _pool(workers)
        try:
            work.draw(draw)
        except BaseException:
            with suppress(OutputError):
                work.clean(work.run)
            raise
        state.finish(work.run)
        summary = work.summary(place, time.perf_counter() - start)
    return replace(summary, exit_code=NOTHING_FOUND) if empty else summary


def settings_of(options: dict[str, Any]) -> Settings:
    """Settings from the options of a run that the state remembers."""
    words = {name: options[name] for name in Settings.__dataclass_fields__ if name in options}
    return Settings(**(words | {"size": tuple(words["size"])}))


def _pool(workers: int) -> Draw:
    from .pool import draw_all

    count = workers or len(os.sched_getaffinity(0))
    return lambda items, settings: cast("Iterator[Outcome]", draw_all(items, settings, count))


def _check_apart(files: list[File], aims: list[str], places: list[str], folder: str) -> None:
    """No picture may take the place of an input; that can be only where inputs lie below the pictures' folder.
    Raises UsageError."""
    from trimray import UsageError

    real = os.path.realpath(folder)
    if not any(os.path.realpath(place).startswith(f"{real}/") or place == folder for place in places):
        return
    inputs = {os.path.realpath(file.path) for file in files}
    for file, aim in zip(files, aims, strict=True):
        if os.path.join(real, aim) in inputs:
            raise UsageError(f"{file.path}: its picture would overwrite the input {aim}")


class _Work:
    """The files of one run, on their way from the state and back to it."""

    def __init__(
        self, state: State, run: int, folder: str, settings: Settings, listener: Listener
    ) -> None:
        self.run = run
        self._state, self._folder, self._settings, self._listener = state, folder, settings, listener
        self._key = settings.key()
        self._aims: dict[str, tuple[File | None, str]] = {}  # by path: what is to be drawn
        self._fresh: list[str] = []
        self._doubtful: list[tuple[File, str, Row]] = []
        self._drawn = self._skipped = 0

    def plan(
        self, share: list[tuple[File, str]], found: Found, resume: bool, retry_failed: bool
    ) -> None:
        """What is to be drawn, what may be, and what is done; all of it in the state."""
        self._listener.begin(len(share) + len(found.failures))
        done: list[Row] = []
        with self._state.together():
            for file, target in share:
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
            for failure in found.failures:
                row = self._state.row(failure.path)
                self._record(failure, "", 0, 0, row)
        for failure in found.failures:
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
        from trimray import __version__

        if row is None or row.status == "pending" or row.settings != self._key or row.version != __version__:
            return "draw"
        if row.exit_code == 4 or (retry_failed and row.status in ("failed", "degraded")):
            return "draw"  # what could not be written is no fault of the file
        if row.status != "failed" and (row.target != target or not self._is_there(target)):
            return "draw"
        same = (row.size, row.mtime_ns) == (file.size, file.mtime_ns) and file.mtime_ns
        return "skip" if resume and same else "hash"

    def _is_there(self, target: str) -> bool:
        try:
            return os.stat(os.path.join(self._folder, target)).st_size > 0
        except OSError:
            return False

    def draw(self, draw: Draw) -> None:
        """First what must be drawn for sure, while threads look which other files changed; then these."""
        from .hashing import Hashing

        hashing = Hashing([file.path for file, _, _ in self._doubtful], _HASH_THREADS)
        with closing(hashing):
            if self._fresh:
                self._draw(draw, self._fresh, hashing.ready)
            changed = [path for k, sha256 in hashing.rest() if (path := self._judge(k, sha256))]
        self._fresh = []
        if changed:
            changed.sort(key=lambda path: (-self._aims[path][0].size, path))
            self._draw(draw, changed, lambda: iter(()))

    def _draw(self, draw: Draw, paths: list[str], hashed: Callable[[], Iterator[tuple[int, str]]]) -> None:
        outcomes = draw((self._item(path) for path in paths), self._settings)
        late: list[str] = []
        try:
            for outcome in outcomes:
                self._finish(outcome)
                late += [path for k, sha256 in hashed() if (path := self._judge(k, sha256))]
        finally:
            close = getattr(outcomes, "close", None)
            if close is not None:
                close()
        for path in paths:
            if path in self._aims:
                self._finish(self._lost(path))
        if late:
            late.sort(key=lambda path: (-self._aims[path][0].size, path))
            self._draw(draw, late, hashed)

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
        from .hashing import sha256_of

        file, target = self._aims.pop(outcome.path, (None, ""))
        if file is None:
            return  # told twice
        for shown in (outcome.path, " ".join(outcome.path.split())):
            outcome = replace(outcome, reason=outcome.reason.removeprefix(f"{shown}: "))
        if not outcome.sha256 and file.mtime_ns:  # the process that read it is gone
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
        from trimray import __version__

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
        from .leftovers import remove_leftovers

        pending = [row.target for row in self._state.rows(run) if row.status == "pending"]
        for path in remove_leftovers(self._folder, pending):
            self._listener.note(f"{path}: half a picture, removed")

    def summary(self, place: str, seconds: float) -> Summary:
        statuses: Counter[str] = Counter()
        codes: set[int] = set()
        for (status, code), number in self._state.counts(self.run).items():
            statuses[status] += number
            codes.add(1 if status == "pending" else code)
        total = sum(statuses.values())
        return Summary(
            state=place,
            run=self.run,
            total=total,
            drawn=self._drawn,
            skipped=self._skipped,
            seconds=seconds,
            exit_code=exit_code(codes),
            statuses=statuses,
        )


def exit_code(codes: set[int]) -> int:
    """codes: those of all files, each once."""
    if not codes:
        return 0
    return codes.pop() if len(codes) == 1 else 1
