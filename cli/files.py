"""Which input becomes which output; checked before any work is done."""

from __future__ import annotations

import os
from dataclasses import dataclass

from trimray import OutputError, UsageError
from trimray.formats import format_of

_PACKED = (".gz", ".z", ".zip")
_EXTENSION = {"jpeg": "jpg", "tiff": "tif"}


@dataclass(frozen=True)
class Job:
    """source, target: paths, or "-". format: of the picture."""

    source: str
    target: str
    format: str

    @property
    def name(self) -> str:
        """What messages call the input."""
        return "stdin" if self.source == "-" else self.source


def plan(inputs: tuple[str, ...], output: str | None, format: str | None) -> list[Job]:
    """One job an input. Raises UsageError, and OutputError when the folder to write to is missing."""
    if output is None:
        raise UsageError("missing output: give -o OUT, or -o - for stdout")
    if any("\0" in path for path in (*inputs, output)):
        raise UsageError("a path holds a NUL byte")
    if inputs.count("-") > 1:
        raise UsageError("stdin can be read once only")
    folder = output.endswith("/") or os.path.isdir(output)
    if len(inputs) > 1 and not folder and "{name}" not in output:
        raise UsageError(
            f"{len(inputs)} inputs need a folder or a path with {{name}} as output, not '{output}'"
        )
    jobs: list[Job] = []
    taken: dict[str, str] = {}
    for source in inputs:
        target = output.replace("{name}", stem(source))
        if folder:
            chosen = format_of("", format or "png")
            target = os.path.join(output, f"{stem(source)}.{_EXTENSION.get(chosen, chosen)}")
        elif output == "-":
            chosen = format_of("", format or "png")
        else:
            chosen = format_of(target, format)
        if output != "-":
            place = os.path.realpath(target)
            if place in taken:
                raise UsageError(f"{taken[place]} and {source} would both be written to {target}")
            taken[place] = source
            _check_target(target)
        jobs.append(Job(source, target, chosen))
    sources = {os.path.realpath(s): s for s in inputs if s != "-"}
    for place, source in taken.items():
        if place in sources:
            raise UsageError(f"{source} would overwrite the input {sources[place]}")
    return jobs


def stem(source: str) -> str:
    """The file's name without its extensions: "a/part.step.gz" -> "part"."""
    if source == "-":
        return "stdin"
    name = os.path.basename(source.rstrip("/"))
    root, extension = os.path.splitext(name)
    if extension.lower() in _PACKED:
        root = os.path.splitext(root)[0]
    return root or name


def _check_target(target: str) -> None:
    folder = os.path.dirname(target) or "."
    if not os.path.isdir(folder):
        raise OutputError(f"{target}: not written: no folder '{folder}'")
    if os.path.isdir(target):
        raise OutputError(f"{target}: not written: is a directory")
    if os.path.exists(target):
        if not os.access(target, os.W_OK):
            raise OutputError(f"{target}: not written: permission denied")
    elif not os.access(folder, os.W_OK):
        raise OutputError(f"{target}: not written: permission denied for '{folder}'")
