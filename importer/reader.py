"""read_model: a file, bytes or a shape in; a BrepModel or MeshModel out."""

import os
import stat
import tempfile
from pathlib import Path
from typing import Any, Literal

from . import errors, shapes
from .mesh_model import MeshModel
from .model import BrepModel
from .process import Progress, Request, Start, run_child

Heal = Literal["default", "off", "strict"]


def read_model(
    source: Any,
    *,
    name: str | None = None,
    heal: Heal = "default",
    precision: float | None = None,
    time_limit: float | None = None,
    memory_limit: int | None = None,
    progress: Progress | None = None,
    start: Start = "spawn",
) -> BrepModel | MeshModel:
    """Reads a STEP, IGES, BREP, STL, OBJ, PLY or OFF file, also compressed (gzip, zip), or takes a shape
    given in Python. Files of triangles become a MeshModel.

    source: a path; bytes or an open binary file (``name`` then names it in messages, and its extension
        decides where the content does not); a cadquery, build123d or OCP shape, which is taken as it is, in
        this process, so that the other arguments do not apply.
    heal: "default" is what OpenCascade's readers do; "off" leaves the file's geometry alone; "strict" is
        "default", but every face that was changed beyond tolerance or is invalid is an error in the report;
        seams added and curves split, which change no point, stay notes.
    precision: mm; nearer points are taken as equal, and IGES faces are sewn within it. Default: the file's.
    time_limit: seconds of wall clock, process start included. memory_limit: bytes of resident memory of the
        reading process, which needs about 300 MiB before it has read anything. There is no limit by default.
    progress: called with a stage ("parse", "transfer", "sew", "extract") and a fraction or None.
    start: of the reading process: "spawn" is a new interpreter; "fork" a copy of this process, which is there
        at once where OCP has been imported already (child.preload), and is meant for processes that read many
        files. No other thread may be at work then.
    Raises an Error of errors.py; the caller's process never loads OpenCascade for a file.
    """
    check_arguments(heal, precision, time_limit, memory_limit)
    if not isinstance(source, str | os.PathLike | bytes | bytearray | memoryview) and shapes.is_shape(source):
        return shapes.from_shape(source, name=name)
    with tempfile.TemporaryDirectory(prefix="trimray-") as folder:
        path, shown = input_file(source, name, Path(folder))
        request = Request(str(path), shown, folder, heal, precision, memory_limit)
        return run_child(request, time_limit=time_limit, progress=progress, start=start)


def check_arguments(
    heal: str, precision: float | None, time_limit: float | None, memory_limit: int | None
) -> None:
    """Raises UsageError for one that makes no sense."""
    if heal not in ("default", "off", "strict"):
        raise errors.UsageError(f"heal: '{heal}' is not one of default, off, strict")
    for argument, value in (
        ("precision", precision),
        ("time_limit", time_limit),
        ("memory_limit", memory_limit),
    ):
        if value is not None and not 0 < value < float("inf"):
            raise errors.UsageError(f"{argument}: {value} is not a positive number")


def input_file(source: Any, name: str | None, folder: Path) -> tuple[Path, str]:
    """A readable, non-empty file and the name to show for it."""
    if isinstance(source, str | os.PathLike):
        shown = os.fsdecode(source) if name is None else name
        path = Path(os.fsdecode(source))
        _check_file(path, shown)
        return path, shown
    shown = name or getattr(source, "name", None) or "<bytes>"
    if not isinstance(shown, str):
        shown = "<bytes>"
    if isinstance(source, bytes | bytearray | memoryview):
        data = bytes(source)
    elif callable(getattr(source, "read", None)):
        try:
            data = source.read()
        except OSError as error:
            raise errors.InputError(f"{shown}: {error.strerror or error}") from None
        if isinstance(data, str):
            data = data.encode()
    else:
        raise errors.UsageError(f"cannot read a model from {type(source).__name__}")
    if not data:
        raise errors.InputError(f"{shown}: empty")
    target = folder / "input"
    try:
        target.write_bytes(data)
    except OSError as error:
        raise errors.OutputError(f"{target}: {error.strerror or error}") from None
    return target, shown


def _check_file(path: Path, shown: str) -> None:
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise errors.InputError(f"{shown}: is a directory")
        if stat.S_ISREG(status.st_mode) and status.st_size == 0:
            raise errors.InputError(f"{shown}: empty")
        if not stat.S_ISREG(status.st_mode):
            raise errors.InputError(f"{shown}: not a regular file")
        with path.open("rb"):
            pass
    except (OSError, ValueError) as error:
        raise errors.InputError(f"{shown}: {getattr(error, 'strerror', None) or error}") from None
