"""Which input becomes which output; checked before any work is done."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

from trimray import OutputError, UsageError
from trimray.formats import extension_of, format_of, mesh_format_of, sequence_format_of, split_name


@dataclass(frozen=True)
class Kind:
    """What is written. format_of: a path and the format asked for, to the format. usual: where nothing else
    decides."""

    format_of: Callable[[str, str | None], str]
    usual: str


PICTURE = Kind(format_of, "png")
SEQUENCE = Kind(sequence_format_of, "webp")
MESH = Kind(mesh_format_of, "stl")


@dataclass(frozen=True)
class Job:
    """sources, target: paths, or "-"; several sources are one scene. format: of the output."""

    sources: tuple[str, ...]
    target: str
    format: str

    @property
    def name(self) -> str:
        """What messages call the input, or the inputs together."""
        return " + ".join(name_of(source) for source in self.sources)


def name_of(source: str) -> str:
    return "stdin" if source == "-" else source


def plan(inputs: tuple[str, ...], output: str | None, format: str | None, kind: Kind = PICTURE) -> list[Job]:
    """One job an input, or one for all where the output is one file. Raises UsageError, and OutputError when
    the folder to write to is missing."""
    if output is None:
        raise UsageError("missing output: give -o OUT, or -o - for stdout")
    if any("\0" in path for path in (*inputs, output)):
        raise UsageError("a path holds a NUL byte")
    if inputs.count("-") > 1:
        raise UsageError("stdin can be read once only")
    folder = output.endswith("/") or os.path.isdir(output)
    together = not folder and "{name}" not in output
    jobs: list[Job] = []
    taken: dict[str, str] = {}
    for group in [inputs] if together else [(source,) for source in inputs]:
        source = group[0]
        target = output.replace("{name}", stem(source))
        if folder:
            chosen = kind.format_of("", format or kind.usual)
            target = os.path.join(output, f"{stem(source)}.{extension_of(chosen)}")
        elif output == "-":
            chosen = kind.format_of("", format or kind.usual)
        else:
            chosen = kind.format_of(target, format)
        if output != "-":
            place = os.path.realpath(target)
            if place in taken:
                raise UsageError(f"{taken[place]} and {source} would both be written to {target}")
            taken[place] = source
            check_target(target)
        jobs.append(Job(group, target, chosen))
    sources = {os.path.realpath(s): s for s in inputs if s != "-"}
    for place, source in taken.items():
        if place in sources:
            raise UsageError(f"{source} would overwrite the input {sources[place]}")
    return jobs


def stem(source: str) -> str:
    """The file's name without its extensions: "a/part.step.gz" -> "part"."""
    if source == "-":
        return "stdin"
    return split_name(os.path.basename(source.rstrip("/")))[0]


def check_target(target: str) -> None:
    """Can it be written? Raises OutputError."""
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
