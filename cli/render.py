"""trimray render: each input to a picture; one bad file never ends a batch."""

from __future__ import annotations

import json
import sys
import time
from typing import TYPE_CHECKING, Any

from trimray import Error, TimeLimitError, UsageError, load
from trimray.formats import check_fit
from trimray.views import parse_aovs, parse_background

from .files import Job, plan
from .output import say, write_stdout
from .progress import Sink, progress_of

if TYPE_CHECKING:
    from trimray import Model, Report

# Lines about missing faces on stderr, an input; the report names all.
_MAX_NAMED = 20


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    jobs = plan(inputs, options["output"], options["format"])
    aovs = parse_aovs(",".join(options["aov"]))
    opaque = all(color[3] >= 1.0 for color in parse_background(options["background"]))
    for job in jobs:
        check_fit(job.format, aovs, opaque)
    if options["output"] == "-":
        if options["report"] == "-":
            raise UsageError("the picture and the report cannot both go to stdout")
        if sys.stdout.isatty() and not options["dry_run"]:
            raise UsageError("stdout is a terminal: redirect it, or give -o FILE")
    if options["dry_run"]:
        write_stdout("".join(f"{job.source} -> {job.target} ({job.format})\n" for job in jobs))
        return 0
    results = [_one(job, aovs, options) for job in jobs]
    if options["report"]:
        _write_report(options["report"], results)
    return exit_code([int(result["exit_code"]) for result in results])


def exit_code(codes: list[int]) -> int:
    """Of a batch: the common code, or 1 when some inputs fared worse than others."""
    return codes[0] if len(set(codes)) == 1 else 1


def _one(job: Job, aovs: tuple[str, ...], options: dict[str, Any]) -> dict[str, Any]:
    """What became of one input, for the report. Never raises for an input's sake."""
    result: dict[str, Any] = {"input": job.source, "output": job.target, "format": job.format, "error": None}
    start = time.perf_counter()
    model: Model | None = None
    try:
        with progress_of(job.name, options["progress"], options["quiet"]) as progress:
            model = read(job.source, job.name, options, progress, prepare=True)
            _draw(model, job, aovs, options, progress, start)
        result["exit_code"] = _tell(job, model, options, time.perf_counter() - start)
    except Error as error:
        text = str(error)
        if job.name not in text and job.target not in text:
            text = f"{job.name}: {text}"
        say(text, error=True)
        result["error"], result["exit_code"] = text, error.exit_code
    if options["report"] and model is not None:
        result["report"] = model.report.as_dict()
    result["seconds"] = round(time.perf_counter() - start, 6)
    return result


def read(source: str, name: str, options: dict[str, Any], progress: Sink, prepare: bool = False) -> Model:
    """The model of a path or of stdin, under the options of the table. prepare: it will be drawn."""
    data: str | bytes = sys.stdin.buffer.read() if source == "-" else source
    return load(
        data,
        cache=options["cache"],
        heal=options["heal"],
        precision=options["precision"],
        time_limit=options["time_limit"],
        memory_limit=options["memory_limit"],
        name=name,
        progress=progress,
        prepare=prepare,
    )


def _draw(
    model: Model, job: Job, aovs: tuple[str, ...], options: dict[str, Any], progress: Sink, start: float
) -> None:
    """start: of the input's work, on the clock of perf_counter."""
    from trimray.image_io import encode, preload, write_file

    preload()
    limit: float | None = options["time_limit"]
    left = None if limit is None else limit - (time.perf_counter() - start)
    if left is not None and left <= 0:
        raise TimeLimitError(f"{job.name}: not done within {limit:g} s")
    frame = model.render(
        options["size"],
        view=options["view"],
        projection=options["projection"],
        up=options["up"],
        samples=options["samples"],
        background=options["background"],
        mode=options["mode"],
        aovs=aovs,
        orientation=options["orientation"],
        threads=options["jobs"],
        time_limit=left,
        progress=progress,
    )
    progress("write", None)
    data = encode(frame, job.format)
    if job.target == "-":
        write_stdout(data)
    else:
        write_file(job.target, data)


def _tell(job: Job, model: Model, options: dict[str, Any], seconds: float) -> int:
    """Lines on stderr about a picture that was written; returns its exit code."""
    report = model.report
    if options["verbose"]:
        origin = "from the cache" if report.cached else "imported"
        say(
            f"{job.name}: {report.drawn} of {report.faces} faces drawn, {origin}, "
            f"{seconds:.2f} s: {job.target}"
        )
        for stage, value in report.seconds.items():
            say(f"{job.name}: {stage} {value:.3f} s")
        _tell_remarks(job.name, report, notes=options["verbose"] > 1)
    tell_problems(job.name, report.reasons(), "--report FILE")
    return 0 if tell_damage(job.name, report) and report.complete else 1


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
    """One line where the file's text is damaged, since what was read of it may not be what was meant. True
    when it is sound."""
    damage = [issue for issue in report.issues if issue.kind in ("syntax", "knots")]
    if damage:
        more = f" and {len(damage) - 1} more" if len(damage) > 1 else ""
        what = f"{damage[0].entity} {damage[0].reason}".strip()
        say(f"{name}: the file is damaged and may be meant otherwise: {what}{more}")
    return not damage


def tell_problems(name: str, reasons: list[str], option: str) -> None:
    """One line each, the first ones; then their number. option: the one that names all."""
    for line in reasons[:_MAX_NAMED]:
        say(f"{name}: {line}")
    if len(reasons) > _MAX_NAMED:
        say(f"{name}: {len(reasons) - _MAX_NAMED} more reasons; {option} names all")


def _write_report(path: str, results: list[dict[str, Any]]) -> None:
    from trimray import __version__

    data = json.dumps({"trimray": __version__, "results": results}, indent=2, ensure_ascii=False) + "\n"
    if path == "-":
        write_stdout(data)
    else:
        from trimray.image_io import write_file

        write_file(path, data.encode("utf-8", "surrogateescape"))
