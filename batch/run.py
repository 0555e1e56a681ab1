"""A batch from end to end: finds files, leaves out what is done, has the rest drawn, keeps the outcome."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

from .record import Item, Outcome, Settings

if TYPE_CHECKING:
    from .shard import Shard

# Draws items, taken one by one as they are needed; tells of each when it is done, in any order. Closing the
# iterator stops all work at once.
Draw = Callable[[Iterable[Item], Settings], Iterator[Outcome]]

NOTHING_FOUND = 6  # exit code


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

    @classmethod
    def of(cls, state: str, run: int, counts: Mapping[tuple[str, int], int]) -> Summary:
        """counts: of files, by status and exit code."""
        statuses: Counter[str] = Counter()
        codes: set[int] = set()
        for (status, code), number in counts.items():
            statuses[status] += number
            codes.add(1 if status == "pending" else code)
        return cls(state, run, sum(statuses.values()), exit_code=exit_code(codes), statuses=statuses)

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
    gallery: bool = False,
    listener: Listener | None = None,
    draw: Draw | None = None,
) -> Summary:
    """Draws every model under paths into the folder output, which is made where it is missing.

    What was drawn before under the same settings by the same version is left as it is, where the file's bytes
    are the same; failures are not tried again, unless retry_failed is set, which also redoes what is
    degraded. With resume, size and date of a file stand for its bytes; with no paths at all, those of the
    last run are taken, its settings, include, template and gallery too where they are not given.

    include, template: as in find and Template. workers: processes; 0 for one a core. shard: only that share
    of the files. gallery: write index.html, a page of all pictures in output. draw: by default a pool of
    processes on this machine.

    Summary.exit_code is what all files have in common, 0 when all are complete, else 1; 6 when no file was
    found. Raises UsageError; OutputError when the folder or the state in it cannot be written;
    KeyboardInterrupt when interrupted, after all work was stopped: nothing that was finished is lost, and the
    gallery shows it.
    """
    from trimray import OutputError, UsageError

    from .find import absolute
    from .plan import plan
    from .shard import Shard
    from .state import State
    from .work import Work

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
        gallery = gallery or last.options.get("gallery", False)
    if gallery:
        from .gallery import check_gallery, write_gallery_of_state

        if shard.n > 1:
            raise UsageError(
                f"a gallery of shard {shard} alone: give --gallery to batch merge, after the last one"
            )
        check_gallery(folder)
    settings = settings or Settings()
    planned = plan(paths, folder, settings, include=include, template=template, shard=shard)
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: not made: {error.strerror or error}") from None

    options = asdict(settings) | {"include": list(include), "template": template, "shard": str(shard)}
    options["gallery"] = gallery
    with State(place) as state:
        last = state.last_run()
        run = state.begin([absolute(path) for path in paths], options)
        work = Work(state, run, folder, settings, listener)
        if last is not None and not last.finished:
            work.clean(last.id)
        work.take(planned, resume, retry_failed)
        nothing = planned.found == 0
        del planned
        if draw is None:
            draw = _pool(workers)
        try:
            work.draw(draw)
        except BaseException as error:
            with suppress(OutputError):
                work.clean(work.run)
                if gallery and isinstance(error, KeyboardInterrupt):
                    write_gallery_of_state(folder, state)
            raise
        state.finish(work.run)
        if gallery:
            write_gallery_of_state(folder, state)
        summary = work.summary(place, time.perf_counter() - start)
    return replace(summary, exit_code=NOTHING_FOUND) if nothing else summary


def settings_of(options: dict[str, Any]) -> Settings:
    """Settings from the options of a run that the state remembers."""
    words = {name: options[name] for name in Settings.__dataclass_fields__ if name in options}
    return Settings(**(words | {"size": tuple(words["size"])}))


def _pool(workers: int) -> Draw:
    from .pool import draw_all

    count = workers or len(os.sched_getaffinity(0))
    return lambda items, settings: draw_all(items, settings, count)


@contextmanager
def closing(outcomes: Iterator[Outcome]) -> Iterator[Iterator[Outcome]]:
    """Closing a generator of outcomes ends its workers at once."""
    try:
        yield outcomes
    finally:
        close = getattr(outcomes, "close", None)
        if close is not None:
            close()


def exit_code(codes: set[int]) -> int:
    """codes: those of all files, each once."""
    if not codes:
        return 0
    return codes.pop() if len(codes) == 1 else 1
