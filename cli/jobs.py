"""Inputs to outputs: reads, hands on, tells what became of each; one bad file never ends a batch."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from trimray import Error, TimeLimitError, UsageError, load

from .files import Job, name_of
from .limit import Limited, within
from .output import json_text, say, write_stdout
from .progress import Sink, progress_of

if TYPE_CHECKING:
    from trimray import Model, Report

# Makes the output of a job: model, job, progress, start of the work on the clock of perf_counter; returns 0,
# or 1 when it told of something that is missing. Raises Error.
Make = Callable[["Model", Job, Sink, float], int]

Value = TypeVar("Value")

# Lines about missing faces on stderr, an input; the report names all.
_MAX_NAMED = 20


def run_jobs(jobs: list[Job], options: dict[str, Any], make: Make, *, what: str, trace: bool = False) -> int:
    """Returns the exit code. what: the output is called in messages. trace: make casts rays."""
    if options["output"] == "-":
        if options["report"] == "-":
            raise UsageError(f"the {what} and the report cannot both go to stdout")
        if sys.stdout.isatty() and not options["dry_run"]:
            raise UsageError("stdout is a terminal: redirect it, or give -o FILE")
    if options["dry_run"]:
        lines = (f"{' + '.join(job.sources)} -> {job.target} ({job.format})\n" for job in jobs)
        write_stdout("".join(lines))
        return 0
    results = [result for job in jobs for result in _run(job, options, make, trace)]
    if options["report"]:
        _write_report(options["report"], results)
    return exit_code([int(result["exit_code"]) for result in results])


def exit_code(codes: list[int]) -> int:
    """Of several inputs: the common code, or 1 when some fared worse than others."""
    return codes[0] if len(set(codes)) == 1 else 1


@dataclass(frozen=True)
class Done(Generic[Value]):
    """What became of an input: a value, or an error, which is told already, and its exit code."""

    source: str
    name: str
    value: Value | None
    error: str = ""
    exit_code: int = 0


def each_input(
    inputs: tuple[str, ...], options: dict[str, Any], work: Callable[[str, str, Limited], Value]
) -> Iterator[Done[Value]]:
    """Does the work on every input, one after the other, each within the time limit; one that fails does not
    end it.

    work: of the source, what messages call it, and a progress.
    """
    for source in inputs:
        name = name_of(source)
        try:
            with limited_progress(name, options) as progress:
                value = work(source, name, progress)
        except Error as error:
            text = tell_error(name, error)
            yield Done(source, name, None, text, error.exit_code)
        else:
            yield Done(source, name, value)


@contextmanager
def limited_progress(name: str, options: dict[str, Any]) -> Iterator[Limited]:
    """name: what messages call the work, which has to be done within the time limit."""
    with (
        progress_of(name, options["progress"], options["quiet"]) as sink,
        within(options["time_limit"], name, sink) as limited,
    ):
        yield limited


def tell_error(name: str, error: Error) -> str:
    """A line on stderr, which names the input; returns it."""
    text = str(error) if name in str(error) else f"{name}: {error}"
    say(text, error=True)
    return text


def _run(job: Job, options: dict[str, Any], make: Make, trace: bool) -> list[dict[str, Any]]:
    """What became of each input, for the report. Never raises for an input's sake."""
    results: list[dict[str, Any]] = [
        {"input": source, "output": job.target, "format": job.format, "error": None} for source in job.sources
    ]
    start = time.perf_counter()
    with progress_of(job.name, options["progress"], options["quiet"]) as progress:
        alone = len(results) == 1
        models = [_load(result, options, progress, prepare=trace and alone) for result in results]
        code = _make(job, results, models, make, progress, start)
    seconds = time.perf_counter() - start
    for result, model in zip(results, models, strict=True):
        if model is not None:
            if result["error"] is None:
                told = _tell(name_of(result["input"]), job, model, options, seconds)
                result["exit_code"] = max(told, code)
            if options["report"]:
                result["report"] = model.report.as_dict()
        result["seconds"] = round(seconds, 6)
    return results


def _load(result: dict[str, Any], options: dict[str, Any], progress: Sink, prepare: bool) -> Model | None:
    """None when it cannot be read, which is told."""
    name = name_of(result["input"])
    try:
        return read(result["input"], name, progress, options, prepare)
    except Error as error:
        result["error"], result["exit_code"] = tell_error(name, error), error.exit_code
        return None


def _make(
    job: Job,
    results: list[dict[str, Any]],
    models: list[Model | None],
    make: Make,
    progress: Sink,
    start: float,
) -> int:
    """What make returns; an error of it is told, and noted for all inputs that it holds."""
    there = [model for model in models if model is not None]
    if not there:
        return 0
    try:
        if len(models) == 1:
            return make(there[0], job, progress, start)
        from trimray import merge

        return make(merge(there), job, progress, time.perf_counter())
    except Error as error:
        text = str(error)
        if job.name not in text and job.target not in text:
            text = f"{job.name}: {text}"
        say(text, error=True)
        for result, model in zip(results, models, strict=True):
            if model is not None:
                result["error"], result["exit_code"] = text, error.exit_code
        return error.exit_code


def read(source: str, name: str, progress: Sink, options: dict[str, Any], prepare: bool = False) -> Model:
    """The model of a path or of stdin, under the options of the table. prepare: it will be drawn."""
    return load(data_of(source), name=name, progress=progress, prepare=prepare, **loading_words(options))


def data_of(source: str) -> str | bytes:
    """The path, or the bytes of stdin."""
    return sys.stdin.buffer.read() if source == "-" else source


def loading_words(options: dict[str, Any]) -> dict[str, Any]:
    """What every reading command hands on to ``load`` as it stands."""
    return {name: options[name] for name in ["cache", "heal", "precision", "time_limit", "memory_limit"]}


def drawing_words(options: dict[str, Any]) -> dict[str, Any]:
    """What render and turntable hand on to the model as it stands."""
    names = "samples background mode seeds seed_process orientation shadows ambient_occlusion reflections"
    return {name: options[name] for name in names.split()} | {"threads": options["jobs"]}


def time_left(name: str, limit: float | None, start: float) -> float | None:
    """Seconds of the limit, None for none. start: of the work, on the clock of perf_counter. Raises
    TimeLimitError."""
    left = None if limit is None else limit - (time.perf_counter() - start)
    if left is not None and left <= 0:
        raise TimeLimitError(f"{name}: not done within {limit:g} s")
    return left


def write(target: str, data: bytes) -> None:
    """To a file, whole or not at all, or to stdout for "-". Raises OutputError."""
    if target == "-":
        write_stdout(data)
    else:
        from trimray.image_io import write_file

        write_file(target, data)


def _tell(name: str, job: Job, model: Model, options: dict[str, Any], seconds: float) -> int:
    """Lines on stderr about an input whose output was written; returns its exit code."""
    report = model.report
    if options["verbose"]:
        origin = "from the cache" if report.cached else "imported"
        say(f"{name}: {report.drawn} of {report.faces} faces drawn, {origin}, {seconds:.2f} s: {job.target}")
        for stage, value in report.seconds.items():
            say(f"{name}: {stage} {value:.3f} s")
        _tell_remarks(name, report, notes=options["verbose"] > 1)
    tell_problems(name, report.reasons(), "--report FILE")
    return 0 if tell_damage(name, report) and report.complete else 1


def _tell_remarks(name: str, report: Report, notes: bool) -> None:
    """Warnings, and on request notes; one line for all that differ only in the entity."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    for issue in report.issues:
        if issue.severity == "warning" or (notes and issue.severity == "note"):
            groups.setdefault((issue.severity, issue.kind, issue.reason), []).append(issue.entity)
    for (severity, kind, reason), entities in groups.items():
        others = f" and {len(entities) - 1} others" if len(entities) > 1 else ""
        say(f"{name}: {severity}: {entities[0]}{others} ({kind}): {reason}")


def tell_damage(name: str, report: Report) -> bool:
    """Says where the file's text is damaged. True when it is sound."""
    damage = report.damage()
    if damage:
        say(f"{name}: {damage}")
    return not damage


def tell_problems(name: str, reasons: list[str], option: str) -> None:
    """One line each, the first ones; then their number. option: the one that names all."""
    for line in reasons[:_MAX_NAMED]:
        say(f"{name}: {line}")
    if len(reasons) > _MAX_NAMED:
        say(f"{name}: {len(reasons) - _MAX_NAMED} more reasons; {option} names all")


def _write_report(path: str, results: list[dict[str, Any]]) -> None:
    from trimray import __version__

    text = json_text({"trimray": __version__, "results": results})
    write(path, text.encode("utf-8", "surrogateescape"))
