"""One file to one picture, in a worker: read, drawn, judged, written."""

from __future__ import annotations

import contextlib
import hashlib
import os
import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from trimray import Error, MemoryLimitError, Model, OutputError, TimeLimitError, load
from trimray.formats import format_of
from trimray.frame import Frame
from trimray.image_io import encode, write_file
from trimray.importer.forked import data_bytes, peak_bytes

from .hashing import regular_file
from .record import Item, Outcome, Settings, Status
from .visible import Visible, visible

if TYPE_CHECKING:
    from trimray import Report

# Parts of the time limit: to read with repairs, and to have read without; of what is then left, the part that
# drawing may take before a coarse picture is drawn.
_READ_SHARE, _UNREPAIRED_SHARE, _DRAW_SHARE = 0.66, 0.85, 0.7
# A coarse picture has so many times fewer pixels in each direction, and one sample in each.
_COARSE = 4
_COARSE_SECONDS = 1.0  # at least, even where that is over the limit


@dataclass(frozen=True)
class Picture:
    """frame: the colour alone. visible: how much of it can be seen. degraded: why it is less than asked for,
    "" where it is not. peak_memory: bytes, of the process that read or of this one, whichever was larger."""

    frame: Frame
    report: Report
    visible: Visible
    degraded: str
    peak_memory: int


def write_picture(item: Item, picture: Picture, settings: Settings) -> None:
    """Raises OutputError."""
    _write(item.target, encode(picture.frame, format_of("", settings.format)))


def draw_file(
    item: Item,
    settings: Settings,
    *,
    threads: int = 1,
    write: Callable[[Item, Picture, Settings], None] = write_picture,
) -> Outcome:
    """Draws one file and writes its picture. Never raises for the file's sake.

    threads: of the tracer; one, since workers are processes. The picture is the same for any number. write:
    puts the picture where it belongs; an Error that it raises is the outcome.
    """
    start = time.monotonic()
    facts: dict[str, Any] = {}
    try:
        facts["sha256"] = hash_file(item.path)
        picture = picture_of(item.path, settings, start=start, threads=threads)
        facts |= {
            "peak_memory": picture.peak_memory,
            "drawn": picture.report.drawn,
            "not_drawn": picture.report.faces - picture.report.drawn,
            "covered": picture.visible.covered,
        }
        status, reason = _judge(picture)
        with _memory_limited(settings.memory_limit, _name(item.path)):
            write(item, picture, settings)
        facts |= {"status": status, "reason": reason, "exit_code": 0 if status == "complete" else 1}
    except Error as error:
        facts |= {"status": "failed", "exit_code": error.exit_code, "reason": _without_name(item.path, error)}
        facts["peak_memory"] = error.peak_memory
    except Exception as error:
        text = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        facts |= {"status": "failed", "exit_code": Error.exit_code, "reason": f"internal error: {text}"}
    seconds = round(time.monotonic() - start, 3)
    return Outcome(path=item.path, target=item.target, seconds=seconds, **facts)


def hash_file(path: str) -> str:
    """The SHA-256 of a regular file, hex. Raises InputError."""
    with regular_file(path, _name(path)) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def picture_of(path: str, settings: Settings, *, start: float | None = None, threads: int = 1) -> Picture:
    """The picture of a file, within the time and memory of the settings.

    start: on the clock of time.monotonic, from which the time limit counts; by default now. Where time runs
    short, the file is read without repairs, then drawn coarsely. Raises Error.
    """
    clock = _Clock(time.monotonic() if start is None else start, settings.time_limit)
    _reset_peak()
    with _memory_limited(settings.memory_limit, _name(path)):
        model, degraded = _read(path, settings, clock)
        frame, coarse = _draw(model, settings, clock, threads, _name(path))
        degraded = "; ".join(text for text in (degraded, coarse) if text)
        seen = visible(frame, settings.background)
        report = model.report
    peak = max(report.reader_memory, peak_bytes())
    return Picture(Frame({"color": frame["color"]}, settings.size), report, seen, degraded, peak)


class _Clock:
    def __init__(self, start: float, limit: float | None) -> None:
        self.start, self.limit = start, limit

    def until(self, share: float) -> float | None:
        """Seconds until this part of the limit is over, at least a few; None without a limit."""
        if self.limit is None:
            return None
        return max(0.001, self.start + share * self.limit - time.monotonic())


def _read(path: str, settings: Settings, clock: _Clock) -> tuple[Model, str]:
    """The model, and why it is less than asked for."""
    heal = settings.heal
    try:
        return _load(
            path, settings, heal, clock.until(_READ_SHARE if heal != "off" else _UNREPAIRED_SHARE)
        ), ""
    except TimeLimitError as error:
        if heal == "off":
            raise _too_slow(path, settings, "read", error) from error
    try:
        model = _load(path, settings, "off", clock.until(_UNREPAIRED_SHARE))
    except TimeLimitError as error:
        raise _too_slow(path, settings, "read, nor without repairs", error) from error
    return model, "read without repairs, for want of time"


def _load(path: str, settings: Settings, heal: Any, time_limit: float | None) -> Model:
    return load(
        path,
        cache=settings.cache,
        heal=heal,
        precision=settings.precision,
        time_limit=time_limit,
        memory_limit=settings.memory_limit,
        name=_name(path),
        start="fork",
    )


def _draw(model: Model, settings: Settings, clock: _Clock, threads: int, name: str) -> tuple[Frame, str]:
    """The frame with colour and face, and why it is less than asked for."""
    words: dict[str, Any] = {
        "view": settings.view,
        "projection": settings.projection,
        "up": settings.up,
        "background": settings.background,
        "aovs": ("color", "face"),
        "threads": threads,
    }
    left = clock.until(1.0)
    limit = None if left is None else left * _DRAW_SHARE
    try:
        return model.render(settings.size, samples=settings.samples, time_limit=limit, **words), ""
    except TimeLimitError:
        pass
    width, height = settings.size
    small = (-(-width // _COARSE), -(-height // _COARSE))
    try:
        left = clock.until(1.0)
        # Preparing the model may have taken all the time: the little that this takes is granted.
        limit = None if left is None else max(left, min(_COARSE_SECONDS, settings.time_limit or 0.0))
        frame = model.render(small, samples=1, time_limit=limit, **words)
    except TimeLimitError as error:
        raise _too_slow(name, settings, "drawn", error) from error
    planes = {
        aov: frame[aov].repeat(_COARSE, axis=0).repeat(_COARSE, axis=1)[:height, :width] for aov in frame
    }
    planes = {aov: np.ascontiguousarray(plane) for aov, plane in planes.items()}
    return Frame(planes, settings.size), f"drawn at {small[0]} x {small[1]} px, for want of time"


def _too_slow(path: str, settings: Settings, what: str, cause: Error) -> TimeLimitError:
    """The cause speaks of a share of the limit; this one of the whole."""
    error = TimeLimitError(f"{_name(path)}: not {what} within {settings.time_limit:g} s")
    error.peak_memory = cause.peak_memory
    return error


def _judge(picture: Picture) -> tuple[Status, str]:
    """What a picture is worth, and why it is not more."""
    reasons = [picture.degraded] if picture.degraded else []
    if picture.visible.blank:
        return "blank", "; ".join([picture.visible.reason, *reasons])
    damage, problems = picture.report.damage(), picture.report.reasons()
    if damage:
        reasons.append(damage)
    if problems:
        more = f" (and {len(problems) - 1} more reasons)" if len(problems) > 1 else ""
        reasons.append(problems[0] + more)
    if picture.degraded:
        return "degraded", "; ".join(reasons)
    if reasons or not picture.report.complete:
        return "partial", "; ".join(reasons) or "not all faces are drawn"
    return "complete", ""


def _write(target: str, data: bytes) -> None:
    """Raises OutputError."""
    try:
        os.makedirs(os.path.dirname(target) or ".", exist_ok=True)
    except OSError as error:
        raise OutputError(f"{target}: not written: {error.strerror or error}") from None
    write_file(target, data)


def _name(path: str) -> str:
    """What messages call a file, and the reader takes its extension from."""
    return os.path.basename(path) or path


def _without_name(path: str, error: Error) -> str:
    """The text of an error, one line, without the name of the input at its head."""
    text = str(error)
    for name in (path, _name(path)):
        head = " ".join(f"{name}:".split())
        if text.startswith(head):
            return text[len(head) :].strip()
    return text


@contextmanager
def _memory_limited(limit: int | None, name: str) -> Iterator[None]:
    """No more than so many bytes may be added to this process's data meanwhile. Raises MemoryLimitError."""
    if limit is None:
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_DATA)
    wanted = data_bytes() + limit
    if before[1] != resource.RLIM_INFINITY:
        wanted = min(wanted, before[1])
    try:
        resource.setrlimit(resource.RLIMIT_DATA, (wanted, before[1]))
        yield
    except (MemoryError, RuntimeError) as error:
        # RuntimeError: where a thread could not be started.
        if isinstance(error, RuntimeError) and not _starved(error):
            raise
        raise MemoryLimitError(f"{name}: cannot be drawn within {limit / 2**20:.0f} MiB") from None
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


def _starved(error: RuntimeError) -> bool:
    text = str(error)
    return "bad_alloc" in text or "start new thread" in text or "memory" in text


def _reset_peak() -> None:
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
