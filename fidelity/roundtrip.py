"""roundtrip: a model is written, the written bytes are read back, and both are compared; and once more."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from trimray import EmptyError, Error, LimitError, TimeLimitError, UsageError
from trimray.exporter import Schema, write
from trimray.image_io import write_file
from trimray.model import Model
from trimray.views import choose

from .comparing import compare
from .record import Comparison, Finding, Verdict, verdict_of
from .result import exit_code_of
from .side import Side, read
from .writer import check_writer, run_writer

Via = Literal["step", "iges", "brep", "store"]
VIAS = ("step", "iges", "brep", "store")
SCHEMAS = ("ap203", "ap214", "ap242")
_SUFFIX = {"step": ".step", "iges": ".igs", "brep": ".brep", "store": ".step"}


@dataclass(frozen=True)
class RoundTrip:
    """first: B with A. second: C, written from B, with B; None where there is no B, or it was not asked for.
    size: of the written file, bytes. exit_code: 0, 7 for differences, 5 where a limit ended it."""

    first: Comparison
    second: Comparison | None
    size: int
    exit_code: int

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        return (self.first,) if self.second is None else (self.first, self.second)


@dataclass
class _Leg:
    """One writing and reading. code: exit code, where it failed."""

    side: Side | None = None
    error: str = ""
    code: int = 0
    empty: bool = False
    size: int = 0
    issues: tuple[tuple[int, str], ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)


class _Clock:
    def __init__(self, limit: float | None) -> None:
        self.limit, self.start = limit, time.monotonic()

    def left(self) -> float | None:
        return None if self.limit is None else max(0.001, self.start + self.limit - time.monotonic())


@dataclass(frozen=True)
class _Way:
    """How files are written and read."""

    via: str
    schema: str
    writer: str | None
    loading: dict[str, Any]  # options of trimray.load
    clock: _Clock

    @property
    def title(self) -> str:
        if self.writer is not None:
            return f"as written by {os.path.basename(check_writer(self.writer)[0])}"
        if self.via == "step":
            return f"as STEP {self.schema.upper()}"
        return (
            f"as {self.via.upper()}"
            if self.via != "store"
            else f"from the store, as STEP {self.schema.upper()}"
        )


def roundtrip(
    source: Any,
    *,
    via: Via = "step",
    schema: Schema = "ap242",
    writer: str | None = None,
    twice: bool = True,
    keep: str | os.PathLike[str] | None = None,
    profile: str = "default",
    name: str | None = None,
    heal: str = "default",
    precision: float | None = None,
    time_limit: float | None = None,
    memory_limit: int | None = None,
    cache: bool = True,
    progress: Any = None,
    **comparing: Any,
) -> RoundTrip:
    """Writes A to B, reads B from the written bytes alone, and compares it with A; then C, written from B,
    with B: a writer that is stable changes nothing any more there.

    source: a path, bytes, or a shape given in Python, as of ``trimray.load``; or a Model.
    via: the format; "store" makes the B-rep anew from our own store of the model, and writes that as STEP:
        what differs then, the store has lost. schema: of STEP.
    writer: a command that does the writing in place of ours, with {in} and {out} for the paths.
    twice: whether C is made. keep: path for the written file. profile: of tolerances. comparing: as of
        ``compare``.
    name, heal, precision, memory_limit (bytes), cache, progress: as of ``trimray.load``, for every reading.
    time_limit: seconds, of everything together but the comparisons.
    Raises InputError (A cannot be read), LimitError (A, within its limits), OutputError (keep), UsageError. A
    writer that fails, and a B that cannot be read, is a verdict.
    """
    _check(via, schema, writer, source)
    clock = _Clock(time_limit)
    loading = {
        "heal": heal, "precision": precision, "memory_limit": memory_limit,
        "cache": cache, "progress": progress,
    }  # fmt: skip
    way = _Way(via, schema, writer, loading, clock)
    a = _read_source(source, name, way)
    with tempfile.TemporaryDirectory(prefix="trimray-") as folder:
        path, again = (Path(folder) / f"{letter}{_SUFFIX[via]}" for letter in "BC")
        b, c = f"{a.name} {way.title}", f"{a.name} {way.title}, twice"
        leg = _leg(source, a, path, way, b)
        if keep is not None and leg.size:
            _keep(path, keep)
        first = _compared(a, leg, b, profile, comparing)
        if not twice or leg.side is None:
            return RoundTrip(first, None, leg.size, leg.code or exit_code_of([first]))
        other = _leg(str(path), leg.side, again, way, c)
        second = _compared(leg.side, other, c, profile, comparing)
    return RoundTrip(first, second, leg.size, other.code or exit_code_of([first, second]))


def _check(via: str, schema: str, writer: str | None, source: Any) -> None:
    choose("via", via, VIAS)
    choose("schema", schema, SCHEMAS)
    if writer is None:
        return
    check_writer(writer)
    if via == "store":
        raise UsageError("writer: cannot be given with via 'store', which writes by itself")
    if not isinstance(source, str | os.PathLike | bytes):
        raise UsageError("writer: needs a file, which a shape given in Python is none")


def _read_source(source: Any, name: str | None, way: _Way) -> Side:
    """A. Raises what reading it raises."""
    side = read(source, name=name, time_limit=way.clock.left(), **way.loading)
    if side.failure is not None:
        raise side.failure
    return side


def _leg(source: Any, a: Side, target: Path, way: _Way, title: str) -> _Leg:
    """Writes the source, whose model is a's, to target, and reads that. Never raises for the file's sake."""
    leg = _Leg()
    done = "written"
    try:
        with _timed(leg, "write"):
            leg.issues = _write(source, a, target, way)
        leg.size = target.stat().st_size
        done = "read back"
        with _timed(leg, "read"):
            side = read(target, name=title, time_limit=way.clock.left(), **{**way.loading, "cache": False})
        if side.failure is not None:
            raise side.failure
        leg.side = side
    except UsageError:
        raise
    except Error as error:
        leg.error, leg.empty = str(error), isinstance(error, EmptyError)
        if isinstance(error, TimeLimitError):
            leg.error = f"not {done} within {way.clock.limit:g} s"
        for known in (title, a.name):  # which messages say in front already
            leg.error = leg.error.removeprefix(f"{known}: ")
        leg.code = error.exit_code if isinstance(error, LimitError) else 0
    return leg


def _write(source: Any, a: Side, target: Path, way: _Way) -> tuple[tuple[int, str], ...]:
    """Returns what the written file does not hold, as exporter.Written.issues."""
    limit = way.clock.left()
    if way.writer is not None:
        with _file_of(source, a.format, target) as path:
            run_writer(way.writer, path, str(target), time_limit=limit)
        return ()
    # A Model has nothing but its store.
    store = way.via == "store" or isinstance(source, Model)
    written = write(
        a.sound._core if store else source,
        target,
        via="step" if way.via == "store" else way.via,  # type: ignore[arg-type]
        schema=way.schema,  # type: ignore[arg-type]
        name=a.name,
        time_limit=limit,
        **{key: way.loading[key] for key in ("heal", "precision", "memory_limit", "progress")},
    )
    return written.issues


@contextmanager
def _file_of(source: Any, format: str, beside: Path) -> Iterator[str]:
    """The absolute path of a source that is a path or bytes."""
    if not isinstance(source, bytes):
        yield os.path.abspath(os.fsdecode(source))
        return
    path = beside.with_name(f"A{_SUFFIX.get(format, '.step')}")
    path.write_bytes(source)
    yield str(path)


@contextmanager
def _timed(leg: _Leg, stage: str) -> Iterator[None]:
    start = time.perf_counter()
    try:
        yield
    finally:
        leg.seconds[stage] = time.perf_counter() - start


def _compared(a: Side, leg: _Leg, b: str, profile: str, comparing: dict[str, Any]) -> Comparison:
    """a with what a leg has brought. b: it is called."""
    unwritten = tuple(_unwritten(a, face, reason) for face, reason in leg.issues)
    if leg.side is None:
        verdict: Verdict = "empty" if leg.empty else "failed"
        return Comparison(
            a.name, b, profile, unwritten, error=leg.error, seconds=leg.seconds, verdict=verdict
        )
    compared = compare(a, leg.side, profile=profile, **comparing)
    findings = (*unwritten, *compared.findings)
    verdict = (
        verdict_of(findings) if compared.verdict in ("complete", "changed", "partial") else compared.verdict
    )
    return replace(compared, findings=findings, seconds=leg.seconds | compared.seconds, verdict=verdict)


def _unwritten(a: Side, face: int, reason: str) -> Finding:
    where = a.where(face) if face >= 0 else ""
    return Finding("file", "written", True, None, False, missing=True, where=where, reason=reason)


def _keep(written: Path, target: str | os.PathLike[str]) -> None:
    write_file(os.fspath(target), written.read_bytes())
