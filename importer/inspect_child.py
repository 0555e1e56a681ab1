"""The process that inspects one file, alone with OpenCascade: a crash or a hang ends only it."""

from pathlib import Path
from typing import Any, BinaryIO

from . import inspection_wire, wire
from .child import serve
from .errors import UsageError
from .formats import TRIANGLES
from .input_file import InputFile, open_input
from .inspection import Inspection
from .report import Report


def main(argument: str) -> None:
    """argument: JSON of process.Request, with what child.serve wants."""
    serve(argument, _inspect)


def _inspect(request: dict[str, Any], pipe: BinaryIO) -> None:
    report = Report(on_stage=lambda stage: wire.send(pipe, {"stage": stage, "fraction": None}))
    path, name, folder, limit = (request[key] for key in ("path", "name", "folder", "memory_limit"))
    opened = open_input(path, name=name, folder=folder, memory_limit=limit, report=report)
    found = inspect_file(
        opened, name=name, folder=folder, heal=request["heal"], precision=request["precision"], report=report
    )
    wire.send(pipe, {"answer": inspection_wire.message_of(found)})


def inspect_file(
    opened: InputFile,
    *,
    name: str,
    folder: str,
    heal: str = "default",
    precision: float | None = None,
    report: Report | None = None,
) -> Inspection:
    """In the process that calls it. Raises as read_file, and UsageError for a file of triangles."""
    if opened.kind in TRIANGLES:
        raise UsageError(f"{name}: triangles: there is no B-rep to inspect")
    from .inspect_scene import inspect_scene
    from .read_file import read_scene

    report = report or Report()
    read = read_scene(opened, name=name, folder=folder, heal=heal, precision=precision, report=report)
    return inspect_scene(read, report, name=name, data=Path(opened.path).read_bytes())
