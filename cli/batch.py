"""trimray batch: a picture of every model in a library."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from types import FrameType
from typing import TYPE_CHECKING, Any

from trimray import OutputError, UsageError

from .batch_progress import BatchProgress
from .files import check_target
from .output import say, shown_path, write_stdout

if TYPE_CHECKING:
    from trimray.batch import Settings, Summary
    from trimray.batch.run import Draw
    from trimray.batch.shard import Shard
    from trimray.batch.state import Run

# Of the settings, those that are options under their own names.
_SETTINGS = (
    *("size", "view", "projection", "up", "samples", "background"),
    *("heal", "precision", "time_limit", "memory_limit", "cache"),
)
_OF_MERGE = ("inputs", "lines", "gallery", "progress", "quiet", "verbose")


def run(inputs: tuple[str, ...], *, given: set[str], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name. given: those on the command line."""
    if inputs and inputs[0] == "merge":
        foreign = sorted(name for name in given if name not in _OF_MERGE)
        if foreign:
            raise UsageError(f"batch merge takes no --{foreign[0]}; a folder of that name is ./merge")
        from .batch_merge import run as merge

        return merge(inputs[1:], options)
    folder = options["folder"]
    if folder is None:
        raise UsageError("missing output: give -o DIR")
    if "-" in inputs:
        raise UsageError("a batch reads files and folders, not stdin; a file of that name is ./-")
    shard = _shard(options["shard"])
    last = _remembered(folder, shard) if options["resume"] and not inputs else None
    if not inputs and last is None:
        resumed = (
            f": the state in {folder} knows of no run to go on with" if options["resume"] else ", or --resume"
        )
        raise UsageError(f"missing input: give files or folders{resumed}")
    template = options["template"] or (last.options["template"] if last else None)
    include = options["include"] or (tuple(last.options["include"]) if last else ())
    settings = _settings(options, given, last, template)
    paths = inputs or (last.paths if last else ())
    options["gallery"] = options["gallery"] or (last is not None and last.options.get("gallery", False))
    _check_report(options["lines"], folder)
    if options["dry_run"]:
        _show_plan(paths, folder, settings, include, template, shard)
        return 0
    from trimray.batch import run as run_batch

    progress = BatchProgress(options["progress"], options["quiet"], options["verbose"])
    with one_interruption(), progress:
        try:
            draw = _drawing_on(options) if options["scheduler"] else None
            summary = run_batch(
                paths,
                folder,
                settings,
                include=include,
                template=template,
                workers=options["workers"],
                shard=shard,
                resume=options["resume"],
                retry_failed=options["retry_failed"],
                gallery=options["gallery"],
                listener=progress,
                draw=draw,
            )
        except KeyboardInterrupt:
            progress.close()
            done = f": {progress.done} of {progress.total} files are done; go on with --resume"
            say(f"interrupted{done if progress.total else ''}", error=True)
            if progress.total:
                _write_interrupted(folder, shard, options)
            return 130
    tell_summary(summary, options["quiet"])
    write_results(summary.state, summary.run, folder, options)
    return summary.exit_code


def _write_interrupted(folder: str, shard: Shard, options: dict[str, Any]) -> None:
    """What there is to say of a run that was interrupted; what cannot be written is told."""
    from trimray.batch.find import absolute
    from trimray.batch.state import State

    place = os.path.join(absolute(folder), shard.state_name)
    try:
        with State(place, create=False) as state:
            last = state.last_run()
        if last is not None:
            write_results(place, last.id, folder, options)
    except OutputError as error:
        say(str(error), error=True)


def _check_report(path: str | None, folder: str) -> None:
    """Hours of work must not end at a folder that is missing. folder: of the pictures, which will be made.
    Raises OutputError."""
    if path is None or path == "-":
        return
    place = os.path.dirname(os.path.abspath(path))
    if not f"{place}/".startswith(f"{os.path.abspath(folder)}/"):
        check_target(path)


def write_results(place: str, run: int, folder: str, options: dict[str, Any]) -> None:
    """What is made of the state once a run, or the joining of several, is over. place: of the state."""
    if options["gallery"] and not options["quiet"]:
        say(f"gallery: {shown_path(os.path.join(folder, 'index.html'))}")
    if not options["lines"]:
        return
    from trimray.batch.find import absolute
    from trimray.batch.report import lines, write_report
    from trimray.batch.state import State

    folder = absolute(folder)
    with State(place, create=False) as state:
        rows = state.rows(run)
        if options["lines"] == "-":
            for line in lines(rows, folder):
                write_stdout(line)
        else:
            write_report(options["lines"], rows, folder)


def tell_summary(summary: Summary, quiet: bool) -> None:
    """One line."""
    facts: dict[str, Any] = {
        "event": "summary",
        "total": summary.total,
        "drawn": summary.drawn,
        "skipped": summary.skipped,
        "statuses": dict(summary.statuses),
        "seconds": round(summary.seconds, 3),
        "exit_code": summary.exit_code,
    }
    if summary.total == 0 and summary.exit_code:
        say("no file found", error=True, **facts)
        return
    if quiet:
        return
    parts = [f"{number} {status}" for status, number in summary.statuses.most_common()]
    text = f"{summary.total} files: {', '.join(parts) or 'nothing to do'}"
    if summary.skipped:
        text += f"; {summary.skipped} of them unchanged"
    rate = f", {summary.drawn / summary.seconds:.1f} a second" if summary.drawn and summary.seconds else ""
    say(f"{text}; {summary.drawn} drawn in {summary.seconds:.1f} s{rate}", **facts)


def _shard(text: str | None) -> Shard:
    from trimray.batch.shard import Shard, parse_shard, shard_of_environment

    if text is not None:
        return parse_shard(text)
    told = shard_of_environment()
    if told is None:
        return Shard()
    shard, variable = told
    say(f"shard {shard}, as {variable} says; --shard 1/1 draws all files")
    return shard


def _remembered(folder: str, shard: Shard) -> Run | None:
    from trimray.batch.state import State

    place = os.path.join(folder, shard.state_name)
    if not os.path.exists(place):
        raise UsageError(f"--resume: there is no run to go on with, no {place}")
    with State(place, create=False) as state:
        return state.last_run()


def _drawing_on(options: dict[str, Any]) -> Draw:
    """On a cluster, which is there. Raises UsageError."""
    from trimray.batch.cluster import check, draw_on_cluster

    scheduler = options["scheduler"]
    check(scheduler)
    tell = None if options["quiet"] else say
    return partial(draw_on_cluster, scheduler=scheduler, workers_per_task=options["workers"] or 1, tell=tell)


def _settings(options: dict[str, Any], given: set[str], last: Run | None, template: str | None) -> Settings:
    """The options'; where a run is gone on with, that run's but for what the command line says."""
    from trimray.batch import Settings
    from trimray.batch.run import settings_of
    from trimray.batch.targets import format_of_template

    format = format_of_template(template, options["format"])
    words = {name: options[name] for name in _SETTINGS}
    if last is None:
        return Settings(**words, format=format)
    changes = {name: value for name, value in words.items() if name in given}
    if "format" in given or "template" in given:
        changes["format"] = format
    return replace(settings_of(last.options), **changes)


def _show_plan(
    paths: tuple[str, ...],
    folder: str,
    settings: Settings,
    include: tuple[str, ...],
    template: str | None,
    shard: Shard,
) -> None:
    """What would be drawn where, whatever is there already."""
    from trimray.batch.plan import plan

    planned = plan(paths, folder, settings, include=include, template=template, shard=shard)
    for failure in planned.failures:
        say(f"{shown_path(failure.path)}: {failure.reason}", error=True)
    for file, aim in zip(planned.files, planned.targets, strict=True):
        write_stdout(f"{shown_path(file.path)} -> {shown_path(os.path.join(folder, aim))}\n")


@contextmanager
def one_interruption() -> Iterator[None]:
    """SIGTERM, which Slurm sends before the end, and SIGHUP are as Ctrl-C; a second one disturbs nothing.
    What is ignored already (nohup) stays so."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        for each in before:
            signal.signal(each, signal.SIG_IGN)
        raise KeyboardInterrupt

    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    before = {number: handler for number, handler in before.items() if handler is not signal.SIG_IGN}
    try:
        for number in before:
            signal.signal(number, interrupt)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
