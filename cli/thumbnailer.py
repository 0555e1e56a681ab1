"""trimray thumbnailer: registers with file managers, and fills their cache."""

from __future__ import annotations

from typing import Any

from trimray import UsageError

from .batch_progress import BatchProgress
from .output import printable, say, write_stdout

# What of the options each action takes, beside -q and -v.
_INSTALLING = ("system", "dry_run")
_OPTIONS = {
    "install": _INSTALLING,
    "uninstall": _INSTALLING,
    "cache": ("thumbnails", "workers", "time_limit", "memory_limit", "progress"),
}


def run(inputs: tuple[str, ...], *, given: set[str], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name. given: those on the command line."""
    action, rest = inputs[0], inputs[1:]
    if action not in _OPTIONS:
        from trimray.views import did_you_mean

        hint = did_you_mean(action, list(_OPTIONS)) or f", one of: {', '.join(_OPTIONS)}"
        raise UsageError(f"thumbnailer: unknown action '{action}'{hint}")
    foreign = sorted(given - {"inputs", "quiet", "verbose", *_OPTIONS[action]})
    if foreign:
        name = {"thumbnails": "size", "workers": "jobs"}.get(foreign[0], foreign[0]).replace("_", "-")
        raise UsageError(f"thumbnailer {action} takes no --{name}")
    if action == "cache":
        return _cache(rest, options)
    if rest:
        raise UsageError(f"thumbnailer {action} takes no '{rest[0]}'")
    return _register(action, options)


def _register(action: str, options: dict[str, Any]) -> int:
    from trimray.desktop import install

    def tell(verb: str, what: str) -> None:
        if options["dry_run"]:
            write_stdout(f"{verb} {printable(what)}\n")
        elif options["verbose"]:
            say(f"{verb} {printable(what)}")

    place = install.system_place() if options["system"] else install.user_place()
    if action == "uninstall":
        remarks = install.uninstall(place, tell, dry_run=options["dry_run"])
    else:
        program = install.find_program()
        remarks = install.install(place, program, tell, dry_run=options["dry_run"])
        hidden = install.outside_of_sandbox(program)
        if hidden:
            say(
                f"{printable(hidden[0])} lies outside of /usr, where GNOME's file manager does not see it; "
                "for GNOME, install trimray under /usr, such as in a virtual environment of the system's "
                "Python in /usr/local/lib/trimray, and run its 'trimray thumbnailer install'"
            )
    for remark in remarks:
        if remark.startswith("!") or not options["quiet"]:
            say(printable(remark.removeprefix("!")), error=remark.startswith("!"))
    return 1 if any(remark.startswith("!") for remark in remarks) else 0


def _cache(paths: tuple[str, ...], options: dict[str, Any]) -> int:
    if not paths:
        raise UsageError("missing input: give folders or files whose thumbnails to make")
    from trimray.desktop.cache import fill_cache

    from .batch import one_interruption

    progress = BatchProgress(options["progress"], options["quiet"], options["verbose"])
    with one_interruption(), progress:
        try:
            filled = fill_cache(
                paths,
                options["thumbnails"],
                workers=options["workers"],
                time_limit=options["time_limit"],
                memory_limit=options["memory_limit"],
                listener=progress,
            )
        except KeyboardInterrupt:
            progress.close()
            say(f"interrupted: {progress.done} of {progress.total} files are done")
            return 130
    facts: dict[str, Any] = {
        "event": "summary",
        "total": filled.total,
        "statuses": dict(filled.statuses),
        "current": filled.current,
        "skipped": filled.skipped,
        "seconds": round(filled.seconds, 3),
        "exit_code": filled.exit_code,
    }
    if not filled.total:
        say("no file found", error=True, **facts)
    elif not options["quiet"]:
        parts = [f"{number} {status}" for status, number in filled.statuses.most_common()]
        parts += [f"{filled.current} up to date"] if filled.current else []
        parts += [f"{filled.skipped} failed before"] if filled.skipped else []
        say(f"{filled.total} files: {', '.join(parts)}; {filled.seconds:.1f} s", **facts)
    return filled.exit_code
